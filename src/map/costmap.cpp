#include "threewe/map/costmap.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace threewe::map {

// Distances along columns first, then the least of dx^2 + column^2 along rows. Plain loops over int16, which compilers
// vectorise.
void squared_distances(std::span<const std::uint8_t> occupied, int width, int height,
                       std::vector<std::int16_t>& squared) {
  const auto w = static_cast<std::size_t>(width);
  const auto h = static_cast<std::size_t>(height);
  constexpr std::int16_t kFar = kMaxDistance;
  squared.resize(w * h);

  for (std::size_t i = 0; i < w * h; ++i) squared[i] = occupied[i] != 0 ? std::int16_t{0} : kFar;
  const auto relax = [w, &squared](std::size_t row, std::size_t from) {
    std::int16_t* target = &squared[row * w];
    const std::int16_t* source = &squared[from * w];
    for (std::size_t x = 0; x < w; ++x) {
      target[x] = std::min(target[x], static_cast<std::int16_t>(source[x] + 1));
    }
  };
  for (std::size_t y = 1; y < h; ++y) relax(y, y - 1);
  for (std::size_t y = h; y-- > 1;) relax(y - 1, y);

  // a row with room on both sides, so that the inner loop has no edges
  std::vector<std::int16_t> row(w + 2 * std::size_t{kMaxDistance}, std::int16_t{kFar * kFar});
  for (std::size_t y = 0; y < h; ++y) {
    std::int16_t* out = &squared[y * w];
    bool near = false;
    for (std::size_t x = 0; x < w; ++x) {
      row[x + kMaxDistance] = static_cast<std::int16_t>(out[x] * out[x]);
      near = near || out[x] < kFar;
    }
    for (std::size_t x = 0; x < w; ++x) out[x] = row[x + kMaxDistance];
    if (!near) continue;
    for (std::size_t dx = 1; dx < kMaxDistance; ++dx) {
      const std::int16_t* left = &row[kMaxDistance - dx];
      const std::int16_t* right = &row[kMaxDistance + dx];
      const auto add = static_cast<std::int16_t>(dx * dx);
      for (std::size_t x = 0; x < w; ++x) {
        const std::int16_t nearer = std::min(left[x], right[x]);
        out[x] = std::min(out[x], static_cast<std::int16_t>(nearer + add));
      }
    }
  }
}

Costmap::Costmap(const Settings& settings) : settings_(settings) {}

void Costmap::update(const OccupancyGrid& grid, std::span<const Vec2> obstacles, std::span<const Vec2> include,
                     int rim) {
  // the map's cells and those of `include`, in the map's own raster, and a rim
  resolution_ = grid.resolution;
  Cell low{0, 0};
  Cell high{grid.width - 1, grid.height - 1};
  for (const Vec2 p : include) {
    const Cell c = grid.cell(p);
    const Cell lower{std::min(low.x, c.x), std::min(low.y, c.y)};
    const Cell upper{std::max(high.x, c.x), std::max(high.y, c.y)};
    if (!fits_a_grid(upper.x - lower.x + 1, upper.y - lower.y + 1)) continue;
    low = lower, high = upper;
  }
  width_ = high.x - low.x + 1 + 2 * rim;
  height_ = high.y - low.y + 1 + 2 * rim;
  const Cell offset{rim - low.x, rim - low.y};
  origin_ = {grid.origin.x - offset.x * resolution_, grid.origin.y - offset.y * resolution_};

  const std::size_t size = static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
  occupied_.assign(size, 0);
  unknown_.assign(size, 1);
  for (int y = 0; y < grid.height; ++y) {
    const std::int8_t* source = grid.data.data() + grid.index({0, y});
    std::uint8_t* occupied = &occupied_[index({offset.x, y + offset.y})];
    std::uint8_t* unknown = &unknown_[index({offset.x, y + offset.y})];
    for (int x = 0; x < grid.width; ++x) {
      occupied[x] = source[x] >= OccupancyGrid::kOccupiedThreshold ? 1 : 0;
      unknown[x] = source[x] < 0 ? 1 : 0;
    }
  }
  for (const Vec2 p : obstacles) {
    const Cell c = cell(p);
    if (contains(c)) occupied_[index(c)] = 1;
  }
  squared_distances(occupied_, width_, height_, squared_);

  // weights by squared distance
  std::array<Weight, static_cast<std::size_t>(kMaxDistance) * kMaxDistance + 1> table{};
  for (std::size_t i = 0; i < table.size(); ++i) {
    const double d = resolution_ * exact::sqrt(static_cast<double>(i));
    const double t =
        std::clamp((settings_.caution_radius - d) / (settings_.caution_radius - settings_.lethal_radius), 0.0, 1.0);
    table[i] = d < settings_.lethal_radius ? kLethal : static_cast<Weight>(kFree + settings_.near_weight * t * t);
  }
  weights_.resize(size);
  for (std::size_t i = 0; i < size; ++i) {
    const Weight w = table[static_cast<std::size_t>(squared_[i])];
    weights_[i] = w != kLethal && unknown_[i] != 0 ? static_cast<Weight>(w + settings_.unknown_weight) : w;
  }
}

void Costmap::open_around(Vec2 point, double radius) {
  const Cell middle = cell(point);
  if (!contains(middle)) return;
  const std::int16_t least = std::max(squared_[index(middle)], std::int16_t{1});
  const int reach = static_cast<int>(radius / resolution_) + 1;
  for (int y = middle.y - reach; y <= middle.y + reach; ++y) {
    for (int x = middle.x - reach; x <= middle.x + reach; ++x) {
      const Cell c{x, y};
      if (!contains(c) || weights_[index(c)] != kLethal || squared_[index(c)] < least) continue;
      if (distance(center(c), point) <= radius) {
        weights_[index(c)] = static_cast<Weight>(kFree + 2 * settings_.near_weight);
      }
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
  double sum = 0.0;
  for (int i = 0; i < pieces; ++i) {
    const Weight w = weight(cell(a + ((i + 0.5) / pieces) * (b - a)));
    if (w == kLethal) return std::numeric_limits<double>::infinity();
    sum += w;
  }
  return sum * length / pieces;
}

}  // namespace threewe::map
