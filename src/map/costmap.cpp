#include "map/costmap.hpp"
#include "core/exact.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <utility>

namespace threewe::map {

namespace {

constexpr double kMostSlower = 20.0;  // beyond, a zone is no dearer
constexpr int kWall = 6;              // [cells] occupied in a tile, which then is a wall that a scan can be matched to

// A number that no tile of any costmap had before.
std::uint64_t new_stamp() {
  static std::atomic<std::uint64_t> last{0};
  return last.fetch_add(1, std::memory_order_relaxed) + 1;
}

}  // namespace

Costmap::Costmap(const Settings& settings) : settings_(settings) {}

void Costmap::update(const OccupancyGrid& grid, std::span<const Vec2> obstacles, std::span<const Vec2> include, int rim,
                     std::optional<Region> changed) {
  begin(grid);
  close_opened();
  move_to(frame_for(grid, include, rim));
  origin_ = {grid.origin.x + (low_.x - raster(grid.origin.x)) * resolution_,
             grid.origin.y + (low_.y - raster(grid.origin.y)) * resolution_};
  take_map(grid, changed);
  take_obstacles(obstacles);
  take_zones();
  inflate();
}

void Costmap::set_zones(const std::vector<Zone>& zones, double speed) {
  zones_ = zones;
  zone_speed_ = speed;
  zones_taken_ = false;
}

// Where a coordinate is, in whole cells. Costmaps of one map keep to its raster, whatever the map's extent.
int Costmap::raster(double metres) const { return to_cell(metres / resolution_ + 0.5); }

// The map's cells and those of `include`, in the map's own raster, and a rim; whole tiles.
Costmap::Frame Costmap::frame_for(const OccupancyGrid& grid, std::span<const Vec2> include, int rim) const {
  Cell low{0, 0};
  Cell high{grid.width - 1, grid.height - 1};
  for (const Vec2 p : include) {
    const Cell c = grid.cell(p);
    const Cell lower{std::min(low.x, c.x), std::min(low.y, c.y)};
    const Cell upper{std::max(high.x, c.x), std::max(high.y, c.y)};
    if (!fits_a_grid(upper.x - lower.x + 1, upper.y - lower.y + 1)) continue;
    low = lower, high = upper;
  }
  const auto tiles_down = [](int cells) { return (cells >= 0 ? cells : cells - kTile + 1) / kTile * kTile; };
  const Cell first{raster(grid.origin.x), raster(grid.origin.y)};
  const Cell from{tiles_down(first.x + low.x - rim), tiles_down(first.y + low.y - rim)};
  const Cell to{tiles_down(first.x + high.x + rim) + kTile, tiles_down(first.y + high.y + rim) + kTile};
  return {from, to.x - from.x, to.y - from.y};
}

// A map in cells of another size is another map.
void Costmap::begin(const OccupancyGrid& grid) {
  if (grid.resolution == resolution_) return;
  Costmap other(settings_);
  other.set_zones(zones_, zone_speed_);
  *this = std::move(other);
  resolution_ = grid.resolution;
  for (std::size_t i = 0; i < kUnknown; ++i) {
    const double d = resolution_ * exact::sqrt(static_cast<double>(i));
    const double t =
        std::clamp((settings_.caution_radius - d) / (settings_.caution_radius - settings_.lethal_radius), 0.0, 1.0);
    const auto known = static_cast<Weight>(kFree + settings_.near_weight * t * t);
    const auto unknown = static_cast<Weight>(known + settings_.unknown_weight);
    weight_at_[i] = d < settings_.lethal_radius ? kLethal : known;
    weight_at_[kUnknown + i] = d < std::max(settings_.lethal_radius, settings_.unknown_radius) ? kLethal : unknown;
  }
}

// What was opened was lethal.
void Costmap::close_opened() {
  for (const Cell c : opened_) set_weight(c, kLethal);
  opened_.clear();
}

// Keeps what lies in both frames; the rest of the new one is unknown. What is occupied no longer counts beyond the
// edge.
void Costmap::move_to(const Frame& frame) {
  if (frame == Frame{low_, width_, height_}) return;
  Costmap moved(settings_);
  moved.low_ = frame.low, moved.width_ = frame.width, moved.height_ = frame.height;
  const std::size_t size = static_cast<std::size_t>(frame.width) * static_cast<std::size_t>(frame.height);
  moved.occupied_.assign(size, 0);
  moved.unknown_.assign(size, 1);
  moved.squared_.assign(size, std::uint8_t{kMaxDistance * kMaxDistance});
  moved.weights_.assign(size, weight_at_.back());
  moved.stale_.assign(size / (std::size_t{kTile} * kTile), kDistances);
  moved.stamps_.resize(moved.stale_.size());
  for (std::uint64_t& stamp : moved.stamps_) stamp = new_stamp();

  const Cell by{low_.x - frame.low.x, low_.y - frame.low.y};
  for (int y = 0; y < height_; y += kTile) {
    for (int x = 0; x < width_; x += kTile) move_tile({x, y}, {x + by.x, y + by.y}, moved);
  }
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      const Cell to{x + by.x, y + by.y};
      if (x % kTile == 0 && moved.contains(to)) {
        x += kTile - 1;
      } else if (occupied_[index({x, y})] != 0) {
        moved.note_occupied(to);
      }
    }
  }
  for (const Cell c : seen_) {
    if (moved.contains({c.x + by.x, c.y + by.y})) moved.seen_.push_back({c.x + by.x, c.y + by.y});
  }
  moved.resolution_ = resolution_;
  moved.weight_at_ = weight_at_;
  moved.set_zones(zones_, zone_speed_);
  moved.zoned_ = zoned_;
  if (!slow_.empty() || settings_.sight > 0.0) {
    for (std::uint8_t& stale : moved.stale_) stale |= kWeights;
  }
  moved.count_walls();
  *this = std::move(moved);
}

// Hits of all tiles, and what is in sight of them.
void Costmap::count_walls() {
  hits_.assign(stale_.size(), 0);
  walls_in_sight_.assign(stale_.size(), 0);
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      if ((occupied_[index({x, y})] & kMapped) != 0) count_hit({x, y}, 1);
    }
  }
}

// A cell has become occupied in the map, or is so no more.
void Costmap::count_hit(Cell c, int more) {
  const std::size_t tile = tile_of(c);
  const bool was_wall = hits_[tile] >= kWall;
  hits_[tile] = static_cast<std::uint16_t>(hits_[tile] + more);
  if ((hits_[tile] >= kWall) != was_wall) show_wall(c, more);
}

// The tile of a cell has become a wall, or is none any more, for those that have it in sight.
void Costmap::show_wall(Cell c, int more) {
  const int x = c.x / kTile;
  const int y = c.y / kTile;
  const double sight = settings_.sight / (kTile * resolution_);
  const int reach = static_cast<int>(sight);
  for (int v = std::max(0, y - reach); v <= std::min(height_ / kTile - 1, y + reach); ++v) {
    for (int u = std::max(0, x - reach); u <= std::min(width_ / kTile - 1, x + reach); ++u) {
      if ((u - x) * (u - x) + (v - y) * (v - y) > sight * sight) continue;
      const std::size_t i = tile_of({u * kTile, v * kTile});
      const bool was_blind = is_blind(i);
      walls_in_sight_[i] += static_cast<std::uint32_t>(more);
      if (is_blind(i) != was_blind) stale_[i] |= kWeights;
    }
  }
}

// Copies the cells of a tile, which then are as up to date as they were, and, where it has neighbours all around before
// and after, its stamp.
void Costmap::move_tile(Cell from, Cell to, Costmap& target) const {
  if (!target.contains(to)) return;
  for (int row = 0; row < kTile; ++row) {
    const auto copy = [&](const auto& source, auto& copied) {
      std::copy_n(&source[index({from.x, from.y + row})], kTile, &copied[target.index({to.x, to.y + row})]);
    };
    copy(occupied_, target.occupied_);
    copy(unknown_, target.unknown_);
    copy(squared_, target.squared_);
    copy(weights_, target.weights_);
  }
  target.stale_[target.tile_of(to)] = 0;
  const auto is_inner = [](const Costmap& costmap, Cell corner) {
    return corner.x > 0 && corner.y > 0 && corner.x + kTile < costmap.width_ && corner.y + kTile < costmap.height_;
  };
  if (is_inner(*this, from) && is_inner(target, to)) {
    target.stamps_[target.tile_of(to)] = stamps_[tile_of(from)];
  }
}

// Compares block by block, cell by cell where a block differs. Outside of the map all is unknown.
void Costmap::take_map(const OccupancyGrid& grid, const std::optional<Region>& changed) {
  constexpr int kBlock = 64;
  const Cell by{raster(grid.origin.x) - low_.x, raster(grid.origin.y) - low_.y};
  Region region{{0, 0}, {width_, height_}};
  if (changed) {
    region = {{std::max(0, changed->low.x + by.x), std::max(0, changed->low.y + by.y)},
              {std::min(width_, changed->high.x + by.x), std::min(height_, changed->high.y + by.y)}};
  }
  std::array<std::int8_t, kBlock> values{};
  for (int y = region.low.y; y < region.high.y; ++y) {
    for (int x = region.low.x; x < region.high.x; x += kBlock) {
      const int count = std::min(kBlock, region.high.x - x);
      values.fill(OccupancyGrid::kUnknown);
      const int first = std::clamp(x - by.x, 0, grid.width);
      const int last = std::clamp(x - by.x + count, first, grid.width);
      if (y >= by.y && y < by.y + grid.height && first < last) {
        std::copy_n(&grid.data[grid.index({first, y - by.y})], last - first,
                    &values[static_cast<std::size_t>(first + by.x - x)]);
      }
      take_block({x, y}, std::span(values).first(static_cast<std::size_t>(count)));
    }
  }
}

void Costmap::take_block(Cell at, std::span<const std::int8_t> values) {
  std::uint8_t* occupied = &occupied_[index(at)];
  std::uint8_t* unknown = &unknown_[index(at)];
  const auto is_occupied = [&](std::size_t i) {
    return static_cast<std::uint8_t>(values[i] >= OccupancyGrid::kOccupiedThreshold ? kMapped : 0);
  };
  const auto is_unknown = [&](std::size_t i) { return static_cast<std::uint8_t>(values[i] < 0 ? 1 : 0); };
  std::uint8_t differs = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    differs =
        static_cast<std::uint8_t>(differs | ((occupied[i] & kMapped) ^ is_occupied(i)) | (unknown[i] ^ is_unknown(i)));
  }
  if (differs == 0) return;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const Cell c{at.x + static_cast<int>(i), at.y};
    if (unknown[i] != is_unknown(i)) stale_[tile_of(c)] |= kWeights;
    unknown[i] = is_unknown(i);
    if ((occupied[i] & kMapped) == is_occupied(i)) continue;
    set_occupied(c, static_cast<std::uint8_t>((occupied[i] & ~kMapped) | is_occupied(i)));
  }
}

// What was seen last time, and is not any more, goes.
void Costmap::take_obstacles(std::span<const Vec2> points) {
  std::vector<Cell> fresh;
  for (const Vec2 p : points) {
    const Cell c = cell(p);
    if (!contains(c) || (occupied_[index(c)] & kFresh) != 0) continue;
    set_occupied(c, occupied_[index(c)] | kFresh);
    fresh.push_back(c);
  }
  for (const Cell c : seen_) set_occupied(c, static_cast<std::uint8_t>(occupied_[index(c)] & ~kSeen));
  for (const Cell c : fresh)
    set_occupied(c, static_cast<std::uint8_t>((occupied_[index(c)] & (kMapped | kZoned)) | kSeen));
  seen_ = std::move(fresh);
}

// All of them anew, where they or the frame have changed.
void Costmap::take_zones() {
  if (std::exchange(zones_taken_, true)) return;
  if (zones_.empty() && !zoned_) return;
  zoned_ = !zones_.empty();
  std::vector<Weight> slow(weights_.size(), 0);
  bool slows = false;
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      const Cell c{x, y};
      std::uint8_t occupants = occupied_[index(c)] & static_cast<std::uint8_t>(~kZoned);
      for (const Zone& zone : zones_) {
        if (!zone.contains(center(c))) continue;
        if (!zone.speed_limit) occupants |= kZoned;
        if (!zone.speed_limit || *zone.speed_limit >= zone_speed_) continue;
        const double slower = std::min(zone_speed_ / *zone.speed_limit, kMostSlower);
        slow[index(c)] = std::max(slow[index(c)], static_cast<Weight>(kFree * (slower - 1.0)));
        slows = true;
      }
      set_occupied(c, occupants);
      if (slow[index(c)] != (slow_.size() == slow.size() ? slow_[index(c)] : 0)) stale_[tile_of(c)] |= kWeights;
    }
  }
  slow_ = slows ? std::move(slow) : std::vector<Weight>{};
}

void Costmap::set_occupied(Cell c, std::uint8_t occupants) {
  std::uint8_t& now = occupied_[index(c)];
  if ((now != 0) != (occupants != 0)) note_occupied(c);
  if (((now ^ occupants) & kMapped) != 0) count_hit(c, (occupants & kMapped) != 0 ? 1 : -1);
  now = occupants;
}

// A cell has been occupied or freed: distances around it may have changed.
void Costmap::note_occupied(Cell c) {
  constexpr int kReach = kMaxDistance - 1;
  for (int y = std::max(0, c.y - kReach) / kTile; y * kTile <= std::min(height_ - 1, c.y + kReach); ++y) {
    for (int x = std::max(0, c.x - kReach) / kTile; x * kTile <= std::min(width_ - 1, c.x + kReach); ++x) {
      stale_[tile_of({x * kTile, y * kTile})] |= kDistances;
    }
  }
}

// Distances, several tiles side by side at a time, then weights.
void Costmap::inflate() {
  constexpr int kMostAtATime = 8;
  for (int y = 0; y < height_; y += kTile) {
    for (int x = 0; x < width_; x += kTile) {
      int tiles = 0;
      while (tiles < kMostAtATime && x + tiles * kTile < width_ &&
             (stale_[tile_of({x + tiles * kTile, y})] & kDistances) != 0) {
        ++tiles;
      }
      if (tiles > 0) measure({{x, y}, {x + tiles * kTile, y + kTile}});
      for (int i = 0; i < std::max(1, tiles); ++i) {
        std::uint8_t& stale = stale_[tile_of({x + i * kTile, y})];
        if (stale != 0) weigh({x + i * kTile, y});
        stale = 0;
      }
      x += std::max(0, tiles - 1) * kTile;
    }
  }
}

// Distances within a region, of what is occupied within it and near enough to matter.
void Costmap::measure(const Region& region) {
  constexpr int kReach = kMaxDistance - 1;
  const Cell low{std::max(0, region.low.x - kReach), std::max(0, region.low.y - kReach)};
  const Cell high{std::min(width_, region.high.x + kReach), std::min(height_, region.high.y + kReach)};
  const int width = high.x - low.x;
  std::vector<std::uint8_t> occupied;
  occupied.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(high.y - low.y));
  for (int y = low.y; y < high.y; ++y) {
    const auto row = occupied_.begin() + static_cast<std::ptrdiff_t>(index({low.x, y}));
    occupied.insert(occupied.end(), row, row + width);
  }
  const Cell corner{region.low.x - low.x, region.low.y - low.y};
  const int columns = region.high.x - region.low.x;
  const int rows = region.high.y - region.low.y;
  std::vector<std::uint8_t> squared;
  squared_distances(occupied, width, high.y - low.y, {corner, {corner.x + columns, corner.y + rows}}, squared);
  for (int y = 0; y < rows; ++y) {
    const std::ptrdiff_t first = std::ptrdiff_t{y} * columns;
    std::copy_n(squared.begin() + first, columns, &squared_[index({region.low.x, region.low.y + y})]);
  }
}

// Weights of a tile by distance. Only what differs counts as a change.
void Costmap::weigh(Cell corner) {
  bool any = false;
  bool left = false;
  bool below = false;
  const std::size_t first = index(corner);
  const Weight at_corner = weights_[first];
  const bool blind = is_blind(tile_of(corner));
  for (int y = 0; y < kTile; ++y) {
    const std::size_t at = index({corner.x, corner.y + y});
    const std::array<Weight, kTile> row = row_of_weights(at, blind);
    const bool differs = !std::equal(row.begin(), row.end(), &weights_[at]);
    any = any || differs;
    left = left || row[0] != weights_[at];
    below = below || (y == 0 && differs);
    if (differs) std::ranges::copy(row, &weights_[at]);
  }
  if (any) restamp(corner, left, below, weights_[first] != at_corner);
}

// A row of a tile. Loops without branches, since a tile has a thousand cells.
std::array<Costmap::Weight, Costmap::kTile> Costmap::row_of_weights(std::size_t at, bool blind) const {
  std::array<Weight, kTile> row{};
  for (std::size_t x = 0; x < kTile; ++x) row[x] = weight_at_[squared_[at + x] + kUnknown * unknown_[at + x]];
  const int everywhere = blind ? settings_.blind_weight : 0;
  if (slow_.empty() && everywhere == 0) return row;
  for (std::size_t x = 0; x < kTile; ++x) {
    const int more = everywhere + (slow_.empty() ? 0 : slow_[at + x]);
    row[x] = row[x] == kLethal ? kLethal : static_cast<Weight>(row[x] + more);
  }
  return row;
}

void Costmap::set_weight(Cell c, Weight weight) {
  if (weights_[index(c)] == weight) return;
  weights_[index(c)] = weight;
  const bool left = c.x % kTile == 0;
  const bool below = c.y % kTile == 0;
  restamp(c, left, below, left && below);
}

// A tile has changed and, where that is on a line which they share, the next ones to the left and below.
void Costmap::restamp(Cell c, bool left, bool below, bool corner) {
  const auto renew = [&](Cell at) {
    if (contains(at)) stamps_[tile_of(at)] = new_stamp();
  };
  renew(c);
  if (left) renew({c.x - kTile, c.y});
  if (below) renew({c.x, c.y - kTile});
  if (corner) renew({c.x - kTile, c.y - kTile});
}

void Costmap::open_around(Vec2 point, double radius) {
  const Cell middle = cell(point);
  if (!contains(middle)) return;
  const std::uint8_t least = std::max(squared_[index(middle)], std::uint8_t{1});
  const int reach = static_cast<int>(radius / resolution_) + 1;
  for (int y = middle.y - reach; y <= middle.y + reach; ++y) {
    for (int x = middle.x - reach; x <= middle.x + reach; ++x) {
      const Cell c{x, y};
      if (!contains(c) || weights_[index(c)] != kLethal || squared_[index(c)] < least) continue;
      if (distance(center(c), point) > radius) continue;
      set_weight(c, static_cast<Weight>(kFree + 2 * settings_.near_weight));
      opened_.push_back(c);
    }
  }
}

Cell Costmap::cell(Vec2 point) const {
  return {to_cell((point.x - origin_.x) / resolution_), to_cell((point.y - origin_.y) / resolution_)};
}

Vec2 Costmap::center(Cell c) const {
  return {origin_.x + (c.x + 0.5) * resolution_, origin_.y + (c.y + 0.5) * resolution_};
}

Costmap::Weight Costmap::weight(Cell c) const {
  return contains(c) ? weights_[index(c)] : static_cast<Weight>(kFree + settings_.unknown_weight);
}

double Costmap::clearance(Cell c) const {
  if (!contains(c)) return resolution_ * kMaxDistance;
  return resolution_ * exact::sqrt(static_cast<double>(squared_[index(c)]));
}

double Costmap::line_cost(Vec2 a, Vec2 b) const {
  // samples at the middles of pieces no longer than half a cell
  const double length = distance(a, b);
  const int pieces = std::max(1, static_cast<int>(std::ceil(length / (0.5 * resolution_))));
  const Vec2 from = (1.0 / resolution_) * (a - origin_);
  const Vec2 piece = (1.0 / (resolution_ * pieces)) * (b - a);
  const auto outside = static_cast<Weight>(kFree + settings_.unknown_weight);
  std::int64_t sum = 0;
  for (int i = 0; i < pieces; ++i) {
    const Vec2 p = from + (i + 0.5) * piece;
    const bool inside = p.x >= 0.0 && p.y >= 0.0 && p.x < width_ && p.y < height_;
    const Weight w = inside ? weights_[index({static_cast<int>(p.x), static_cast<int>(p.y)})] : outside;
    if (w == kLethal) return std::numeric_limits<double>::infinity();
    sum += w;
  }
  return static_cast<double>(sum) * length / pieces;
}

}  // namespace threewe::map
