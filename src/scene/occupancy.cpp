#include "scene/occupancy.hpp"
#include "core/exact.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace threewe::scene {
namespace {

// A wall that ends where a cell begins, but for rounding, does not overlap it.
constexpr double kRounding = 1e-9;  // [m]

constexpr float kFar = std::numeric_limits<float>::infinity();

bool is_along_axes(const Solid& solid) {
  return solid.shape == Solid::Shape::box &&
         (solid.corners[0].x == solid.corners[1].x || solid.corners[0].y == solid.corners[1].y);
}

// Marks the cells that one solid overlaps.
void mark(CellSet& occupied, const Solid& solid) {
  const GridFrame& frame = occupied.frame;
  const double h = 0.5 * frame.resolution;
  const auto [lowest, highest] = bounds(solid);
  const bool along_axes = is_along_axes(solid);
  const CellIndex low = frame.cell(lowest);
  const CellIndex high = frame.cell(highest);
  for (int y = std::max(low.y, 0); y <= std::min(high.y, frame.height - 1); ++y) {
    for (int x = std::max(low.x, 0); x <= std::min(high.x, frame.width - 1); ++x) {
      if (occupied[{x, y}]) continue;
      const Vec2 c = frame.center({x, y});
      if (along_axes) {
        const double deep =
            std::min({highest.x - (c.x - h), c.x + h - lowest.x, highest.y - (c.y - h), c.y + h - lowest.y});
        occupied[{x, y}] = deep > kRounding ? 1 : 0;
        continue;
      }
      const std::array<Vec2, 4> square = {
          Vec2{c.x - h, c.y - h}, {c.x + h, c.y - h}, {c.x + h, c.y + h}, {c.x - h, c.y + h}};
      occupied[{x, y}] = overlaps(solid, square, kRounding) ? 1 : 0;
    }
  }
}

// Distances in cells, up and down a column, to the nearest cell of the set in that column.
CellGrid<float> column_distances(const CellSet& set) {
  const GridFrame& frame = set.frame;
  CellGrid<float> distance(frame, kFar);
  for (int y = 0; y < frame.height; ++y) {
    for (int x = 0; x < frame.width; ++x) {
      const float below = y > 0 ? distance[{x, y - 1}] + 1.0F : kFar;
      distance[{x, y}] = set[{x, y}] ? 0.0F : below;
    }
  }
  for (int y = frame.height - 2; y >= 0; --y) {
    for (int x = 0; x < frame.width; ++x) {
      distance[{x, y}] = std::min(distance[{x, y}], distance[{x, y + 1}] + 1.0F);
    }
  }
  return distance;
}

// The lower envelope of the parabolas (x - i)^2 + heights[i]^2, evaluated at every x of a row: squared distances.
class ParabolaEnvelope {
 public:
  explicit ParabolaEnvelope(std::size_t width) : height_(width), middle_(width), from_(width) {}

  void transform(float* row) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < height_.size(); ++i) {
      if (row[i] == kFar) continue;
      height_[i] = static_cast<double>(row[i]) * static_cast<double>(row[i]);
      double from = -std::numeric_limits<double>::infinity();
      // parabolas that the new one hides drop out
      while (count > 0 && (from = crossing(middle_[count - 1], i)) <= from_[count - 1]) --count;
      middle_[count] = i;
      from_[count] = from;
      ++count;
    }
    if (count == 0) return;
    for (std::size_t x = 0, k = 0; x < height_.size(); ++x) {
      while (k + 1 < count && from_[k + 1] < static_cast<double>(x)) ++k;
      const double d = static_cast<double>(x) - static_cast<double>(middle_[k]);
      row[x] = static_cast<float>(d * d + height_[middle_[k]]);
    }
  }

 private:
  // where the parabola of j > i becomes the lower one
  double crossing(std::size_t i, std::size_t j) const {
    const auto a = static_cast<double>(i);
    const auto b = static_cast<double>(j);
    return ((height_[j] + b * b) - (height_[i] + a * a)) / (2.0 * (b - a));
  }

  std::vector<double> height_;
  std::vector<std::size_t> middle_;
  std::vector<double> from_;
};

}  // namespace

GridFrame grid_over(const Scene& scene) {
  constexpr int kMargin = 2;
  const auto cells_below = [](double x) { return static_cast<int>(std::floor(x / kCellSize)) - kMargin; };
  const auto cells_above = [](double x) { return static_cast<int>(std::ceil(x / kCellSize)) + kMargin; };
  const int x = cells_below(scene.min.x);
  const int y = cells_below(scene.min.y);
  return {{x * kCellSize, y * kCellSize}, kCellSize, cells_above(scene.max.x) - x, cells_above(scene.max.y) - y};
}

CellSet occupied_cells(const GridFrame& frame, std::span<const Solid> solids) {
  CellSet occupied(frame, 0);
  for (const Solid& solid : solids) mark(occupied, solid);
  return occupied;
}

CellGrid<float> distance_field(const CellSet& set) {
  CellGrid<float> distance = column_distances(set);
  const GridFrame& frame = distance.frame;
  ParabolaEnvelope envelope(static_cast<std::size_t>(frame.width));
  for (int y = 0; y < frame.height; ++y) envelope.transform(&distance[{0, y}]);
  for (float& d : distance.cells) d = static_cast<float>(frame.resolution) * exact::sqrt(d);
  return distance;
}

CellSet cells_with_clearance(const Obstacles& obstacles, const CellGrid<float>& distance_to_occupied, double radius) {
  // the nearest solid reaches into the nearest occupied cell, so the true distance is known to half a diagonal;
  // only where that leaves the question open is it measured
  const GridFrame& frame = distance_to_occupied.frame;
  const double slack = 0.5 * std::numbers::sqrt2 * frame.resolution + 1e-6;
  CellSet clear(frame, 0);
  for (std::size_t i = 0; i < frame.size(); ++i) {
    const auto d = static_cast<double>(distance_to_occupied.cells[i]);
    const bool open = d >= radius - slack && d < radius + slack;
    clear.cells[i] = (open ? obstacles.clearance(frame.center(frame.cell(i))) >= radius : d >= radius) ? 1 : 0;
  }
  return clear;
}

CellSet connected_cells(const CellSet& set, Vec2 seed) {
  CellSet connected(set.frame, 0);
  const auto is_open = [&](int x, int y) { return set[{x, y}] != 0 && connected[{x, y}] == 0; };
  std::vector<CellIndex> starts;
  if (set.value_or(set.frame.cell(seed), 0) != 0) starts.push_back(set.frame.cell(seed));
  while (!starts.empty()) {
    const CellIndex start = starts.back();
    starts.pop_back();
    if (!is_open(start.x, start.y)) continue;

    // all of a row that hangs together at once
    int first = start.x;
    int last = start.x;
    while (first > 0 && is_open(first - 1, start.y)) --first;
    while (last + 1 < set.frame.width && is_open(last + 1, start.y)) ++last;
    for (int x = first; x <= last; ++x) connected[{x, start.y}] = 1;

    // and the beginning of every such stretch in the rows beside it
    for (const int y : {start.y - 1, start.y + 1}) {
      if (y < 0 || y >= set.frame.height) continue;
      for (int x = first; x <= last; ++x) {
        if (is_open(x, y) && (x == first || !is_open(x - 1, y))) starts.push_back({x, y});
      }
    }
  }
  return connected;
}

}  // namespace threewe::scene
