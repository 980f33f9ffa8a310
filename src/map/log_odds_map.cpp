#include "map/log_odds_map.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "core/bounds.hpp"
#include "core/exact.hpp"
#include "core/numbers.hpp"
#include "map/scan_kernel.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::map {
namespace {

constexpr int kChunk = 64;             // the map grows by so many cells
constexpr double kRim = 2.0;           // [cells] around what is known, so that neighbours can be read unchecked
constexpr int kSubcells = 256;         // steps of a hit's place within its cell
constexpr std::int16_t kMaxHits = 64;  // older hits fade beyond this
constexpr double kDeviations = 3.0;    // of noise, that it reaches

// The occupancy [%] for each value of the evidence, known cells only.
const std::array<std::int8_t, 256>& occupancy_table() {
  static const std::array<std::int8_t, 256> table = [] {
    std::array<std::int8_t, 256> t{};
    for (int i = 0; i < 256; ++i) {
      const double odds = exact::exp(-(i - 128) * 0.1);
      t[static_cast<std::size_t>(i)] = static_cast<std::int8_t>(std::floor(100.0 / (1.0 + odds) + 0.5));
    }
    t[128] = OccupancyGrid::kUnknown;
    return t;
  }();
  return table;
}

bool is_occupied(std::int8_t value) { return value >= OccupancyGrid::kOccupiedThreshold; }
bool is_free(std::int8_t value) { return value >= 0 && value <= OccupancyGrid::kFreeThreshold; }

// The cells of a grid, counted from the raster's origin.
Region extent(const OccupancyGrid& grid) {
  const Cell low = raster_cell(grid);
  return {low, {low.x + grid.width, low.y + grid.height}};
}

int floor_to_chunk(double cells) {
  const int cell = to_cell(cells);
  return cell - (cell % kChunk + kChunk) % kChunk;
}

// The old contents of a grid of `size` in a larger one, `offset` cells further in.
template <class T>
std::vector<T> moved_into(const std::vector<T>& old, int old_width, Cell offset, int width, int height, T fill) {
  std::vector<T> wider(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), fill);
  const auto row = static_cast<std::size_t>(old_width);
  for (std::size_t y = 0; row != 0 && y < old.size() / row; ++y) {
    const auto target =
        (y + static_cast<std::size_t>(offset.y)) * static_cast<std::size_t>(width) + static_cast<std::size_t>(offset.x);
    std::copy_n(old.begin() + static_cast<std::ptrdiff_t>(y * row), row,
                wider.begin() + static_cast<std::ptrdiff_t>(target));
  }
  return wider;
}

// The cells, counted from the raster's origin, in which two grids differ.
Region difference(const OccupancyGrid& a, const OccupancyGrid& b) {
  const Region all = united(extent(a), extent(b));
  const Cell a_low = raster_cell(a);
  const Cell b_low = raster_cell(b);
  Region changed;
  for (int y = all.low.y; y < all.high.y; ++y) {
    for (int x = all.low.x; x < all.high.x; ++x) {
      if (a.at({x - a_low.x, y - a_low.y}) == b.at({x - b_low.x, y - b_low.y})) continue;
      changed = united(changed, {{x, y}, {x + 1, y + 1}});
    }
  }
  return changed;
}

}  // namespace

LogOddsMap::LogOddsMap(const Settings& settings) : settings_(settings) { grid_.resolution = settings.resolution; }

LogOddsMap LogOddsMap::going_on_from(const OccupancyGrid& given, double free_range) {
  LogOddsMap map({.resolution = given.resolution, .free_range = free_range});
  map.grid_ = given;
  map.raster_ = given.origin;
  map.log_odds_.assign(given.data.size(), 0);
  map.hits_.resize(given.data.size());
  map.marks_.assign(given.data.size(), kUnseen);
  map.version_ = given.data.empty() ? 0 : 1;
  for (std::size_t i = 0; i < given.data.size(); ++i) {
    if (is_occupied(given.data[i])) map.log_odds_[i] = map.settings_.max;
    if (is_free(given.data[i])) map.log_odds_[i] = map.settings_.min;
    map.grid_.data[i] = occupancy_table()[static_cast<std::uint8_t>(map.log_odds_[i] + 128)];
  }
  for (int y = 0; y < given.height; ++y) {
    for (int x = 0; x < given.width; ++x) {
      if (map.log_odds_[given.index({x, y})] > 0) map.add_given_surface({x, y});
    }
  }
  return map;
}

// Seen from where it is free around. As far as a lidar's bias goes it was seen from nowhere: it is where it is.
void LogOddsMap::add_given_surface(Cell c) {
  constexpr std::int16_t kSightings = 12;
  int from_x = 0;
  int from_y = 0;
  bool visible = false;
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      if (log_odds({c.x + dx, c.y + dy}) >= 0) continue;
      visible = true;
      from_x += dx, from_y += dy;
    }
  }
  if (!visible) return;
  const auto sign = [](int sum) { return static_cast<std::int16_t>(sum > 0 ? kSightings : sum < 0 ? -kSightings : 0); };
  hits_[grid_.index(c)] = {.sum_from_x = sign(from_x), .sum_from_y = sign(from_y), .count = kSightings};
}

void LogOddsMap::insert(std::span<const Beam> scan, double range_bias, double range_noise) {
  if (!is_within(range_bias, -kMaxRangeBias, kMaxRangeBias)) {
    throw ContractError(
        fmt::format("range_bias must lie in [{:g}, {:g}] m, got {:g}", -kMaxRangeBias, kMaxRangeBias, range_bias));
  }
  const std::vector<Beam> beams = within_reach(scan);
  grow_to_hold(beams, range_bias);
  const Region seen = mark_free(beams, range_bias);
  for (const Beam& beam : beams) {
    if (beam.hit) add_hit(beam, range_bias);
  }
  apply_marks(seen, kDeviations * range_noise > grid_.resolution);
}

// The beams that the map can hold without growing beyond its limits.
std::vector<Beam> LogOddsMap::within_reach(std::span<const Beam> beams) const {
  constexpr double kSlack = 4 * kChunk;  // [cells] by which growing may overshoot: whole chunks and a rim
  const double r = grid_.resolution;
  const bool first = grid_.data.empty();
  Vec2 low = first ? Vec2{kInfinity, kInfinity} : grid_.origin;
  Vec2 high = first ? Vec2{-kInfinity, -kInfinity} : grid_.origin + Vec2{grid_.width * r, grid_.height * r};
  std::vector<Beam> kept;
  kept.reserve(beams.size());
  for (const Beam& beam : beams) {
    const Vec2 end = beam.origin + beam.range * beam.direction;
    if (!is_bounded(beam.origin) || !is_bounded(end)) continue;
    const Vec2 lower{std::min({low.x, beam.origin.x, end.x}), std::min({low.y, beam.origin.y, end.y})};
    const Vec2 upper{std::max({high.x, beam.origin.x, end.x}), std::max({high.y, beam.origin.y, end.y})};
    if (!fits_a_grid((upper.x - lower.x) / r + kSlack, (upper.y - lower.y) / r + kSlack)) continue;
    low = lower, high = upper;
    kept.push_back(beam);
  }
  return kept;
}

void LogOddsMap::grow_to_hold(std::span<const Beam> beams, double range_bias) {
  if (beams.empty()) return;
  Vec2 low{kInfinity, kInfinity};
  Vec2 high{-kInfinity, -kInfinity};
  for (const Beam& beam : beams) {
    for (const Vec2 p : {beam.origin, beam.origin + beam.range * beam.direction}) {
      low = {std::min(low.x, p.x), std::min(low.y, p.y)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y)};
    }
  }
  // hits lie where they are without the bias
  grow_to(low, high, std::max(kRim, std::ceil(std::fabs(range_bias) / grid_.resolution) + 1.0));
}

void LogOddsMap::make_room(Vec2 low, Vec2 high) { grow_to(low, high, kRim); }

// Whole chunks, and at least `rim` cells more than needed.
void LogOddsMap::grow_to(Vec2 low, Vec2 high, double rim) {
  const double r = grid_.resolution;
  low = low - raster_, high = high - raster_;
  const Vec2 corner = grid_.origin - raster_;
  const bool first = grid_.data.empty();
  const int old_x = first ? floor_to_chunk(low.x / r) : to_cell(corner.x / r + 0.5);
  const int old_y = first ? floor_to_chunk(low.y / r) : to_cell(corner.y / r + 0.5);
  const int x0 = std::min(old_x, floor_to_chunk(low.x / r - rim));
  const int y0 = std::min(old_y, floor_to_chunk(low.y / r - rim));
  const int x1 = std::max(old_x + grid_.width, floor_to_chunk(high.x / r + rim) + kChunk);
  const int y1 = std::max(old_y + grid_.height, floor_to_chunk(high.y / r + rim) + kChunk);
  if ((x1 - x0 == grid_.width && y1 - y0 == grid_.height) || !fits_a_grid(x1 - x0, y1 - y0)) return;

  const Cell offset{old_x - x0, old_y - y0};
  const int width = x1 - x0;
  const int height = y1 - y0;
  log_odds_ = moved_into(log_odds_, grid_.width, offset, width, height, std::int8_t{0});
  hits_ = moved_into(hits_, grid_.width, offset, width, height, CellHits{});
  grid_.data = moved_into(grid_.data, grid_.width, offset, width, height, OccupancyGrid::kUnknown);
  marks_.assign(grid_.data.size(), kUnseen);
  grid_.width = width;
  grid_.height = height;
  grid_.origin = raster_ + Vec2{x0 * r, y0 * r};
}

void LogOddsMap::replace(LogOddsMap other) {
  assert(raster_ == other.raster_ && grid_.resolution == other.grid_.resolution);
  const Region changed = difference(grid_, other.grid_);
  other.version_ = version_ + 1;
  other.changes_ = changes_;
  other.changes_.note(other.version_, changed);
  *this = std::move(other);
}

void LogOddsMap::add_hit(const Beam& beam, double range_bias) {
  const Vec2 measured = beam.origin + beam.range * beam.direction;
  const Cell c = grid_.cell(measured - range_bias * beam.direction);
  const std::size_t index = grid_.index(c);
  marks_[index] = kHit;

  CellHits& h = hits_[index];
  if (h.count >= kMaxHits) {
    for (std::int16_t* sum : {&h.sum_x, &h.sum_y, &h.sum_from_x, &h.sum_from_y, &h.count}) {
      *sum = static_cast<std::int16_t>(*sum / 2);
    }
  }
  const auto add = [](std::int16_t& sum, double value) {
    sum = static_cast<std::int16_t>(sum + static_cast<int>(std::floor(value + 0.5)));
  };
  const Vec2 offset = (kSubcells / grid_.resolution) * (measured - grid_.center(c));
  add(h.sum_x, offset.x);
  add(h.sum_y, offset.y);
  add(h.sum_from_x, -100.0 * beam.direction.x);
  add(h.sum_from_y, -100.0 * beam.direction.y);
  ++h.count;
}

// Marks what beams passed through. Returns where all lie that the scan saw.
Region LogOddsMap::mark_free(std::span<const Beam> beams, double range_bias) {
  if (beams.empty()) return {};
  const double cells = 1.0 / grid_.resolution;
  Vec2 low{kInfinity, kInfinity};
  Vec2 high{-kInfinity, -kInfinity};
  std::vector<GridLine> lines;
  lines.reserve(beams.size());
  for (const Beam& beam : beams) {
    // no further than beams are trusted to be free
    const double measured = std::max(beam.range - (beam.hit ? range_bias : 0.0), 0.0);
    const Vec2 end = beam.origin + std::min(measured, settings_.free_range) * beam.direction;
    lines.push_back({cells * (beam.origin - grid_.origin), cells * (end - grid_.origin)});
    const Vec2 hit = cells * (beam.origin + (beam.range - range_bias) * beam.direction - grid_.origin);
    for (const Vec2 p : {lines.back().from, lines.back().to, hit}) {
      low = {std::min(low.x, p.x), std::min(low.y, p.y)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y)};
    }
  }
  mark_passed(lines, grid_.width, marks_);
  // and a cell around, since a hit's may be computed otherwise
  return {{std::max(to_cell(low.x) - 1, 0), std::max(to_cell(low.y) - 1, 0)},
          {std::min(to_cell(high.x) + 2, grid_.width), std::min(to_cell(high.y) + 2, grid_.height)}};
}

// What becomes of the cells that the scan saw, and where others see a difference.
void LogOddsMap::apply_marks(const Region& seen, bool noisy) {
  const Evidence evidence{settings_.hit, settings_.pass, settings_.max, settings_.min};
  changed_.clear();
  for (int y = seen.low.y; y < seen.high.y; ++y) {
    add_evidence(evidence, grid_.index({seen.low.x, y}), grid_.index({seen.high.x - 1, y}) + 1, marks_, log_odds_,
                 changed_);
  }
  Region changed = show_changed(noisy);
  const Cell low = raster_cell(grid_);
  if (!changed.empty()) {
    changed = {{changed.low.x + low.x, changed.low.y + low.y}, {changed.high.x + low.x, changed.high.y + low.y}};
  }
  changes_.note(++version_, changed);
}

// What is seen through has no surface any more, nor does what only its noise reached beside it. Where noise reaches
// over a cell, such hits stay beside what is still there: they are those that fell short, without which it would seem
// to lie farther away. With less noise most are of a pose that was a little off.
void LogOddsMap::forget_surface(std::uint32_t index, bool noisy) {
  if (hits_[index].count == 0 || (noisy && is_beside_occupied(index))) return;
  hits_[index] = CellHits{};
  for (const std::ptrdiff_t step : steps_around()) {
    const auto other = static_cast<std::size_t>(static_cast<std::ptrdiff_t>(index) + step);
    if (hits_[other].count != 0 && log_odds_[other] < 0 && !is_beside_occupied(other)) hits_[other] = CellHits{};
  }
}

std::array<std::ptrdiff_t, 8> LogOddsMap::steps_around() const {
  const std::ptrdiff_t row = grid_.width;
  return {-row - 1, -row, -row + 1, -1, 1, row - 1, row, row + 1};
}

bool LogOddsMap::is_beside_occupied(std::size_t index) const {
  return std::ranges::any_of(steps_around(), [&](std::ptrdiff_t step) {
    return log_odds_[static_cast<std::size_t>(static_cast<std::ptrdiff_t>(index) + step)] > 0;
  });
}

// Brings grid and surfaces up to date where the evidence has changed. Returns where the grid is another one.
Region LogOddsMap::show_changed(bool noisy) {
  const std::array<std::int8_t, 256>& occupancy = occupancy_table();
  const auto width = static_cast<std::uint32_t>(grid_.width);
  std::uint32_t row = 0;  // where it begins; cells come in order
  int y = 0;
  Region changed{{grid_.width, grid_.height}, {0, 0}};
  for (const std::uint32_t index : changed_) {
    const std::int8_t value = log_odds_[index];
    if (value < 0) forget_surface(index, noisy);
    const std::int8_t now = occupancy[static_cast<std::uint8_t>(value + 128)];
    if (std::exchange(grid_.data[index], now) == now) continue;
    for (; index >= row + width; row += width) ++y;
    const int x = static_cast<int>(index - row);
    changed.low = {std::min(changed.low.x, x), std::min(changed.low.y, y)};
    changed.high = {std::max(changed.high.x, x + 1), y + 1};
  }
  return changed.empty() ? Region{} : changed;
}

}  // namespace threewe::map
