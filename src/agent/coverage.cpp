#include "agent/coverage.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "core/exact.hpp"

namespace threewe::agent {
namespace {

constexpr double kFarthestView = 3.5;  // [m] from which the detector distinguishes things
constexpr double kStandOff = 1.2;      // [m] from what is looked at, if there is room
constexpr double kRayStep = 0.04;      // [rad]

bool occupied(const map::OccupancyGrid& grid, Vec2 point) {
  return grid.at(grid.cell(point)) >= map::OccupancyGrid::kOccupiedThreshold;
}

bool free(const map::OccupancyGrid& grid, Vec2 point) {
  const std::int8_t value = grid.at(grid.cell(point));
  return value >= 0 && value <= map::OccupancyGrid::kFreeThreshold;
}

// Whether a robot can stand there: known to be free, and nothing nearer than `clearance`.
bool roomy(const map::OccupancyGrid& grid, Vec2 point, double clearance) {
  if (!free(grid, point)) return false;
  const int reach = static_cast<int>(clearance / grid.resolution) + 1;
  const map::Cell middle = grid.cell(point);
  for (int dy = -reach; dy <= reach; ++dy) {
    for (int dx = -reach; dx <= reach; ++dx) {
      const map::Cell cell{middle.x + dx, middle.y + dy};
      if (grid.at(cell) >= map::OccupancyGrid::kOccupiedThreshold && norm(grid.center(cell) - point) < clearance)
        return false;
    }
  }
  return true;
}

}  // namespace

Square square_of(Vec2 point) {
  return {static_cast<int>(std::floor(point.x / kSquare)), static_cast<int>(std::floor(point.y / kSquare))};
}

Vec2 center_of(Square square) { return {(square.first + 0.5) * kSquare, (square.second + 0.5) * kSquare}; }

bool in_sight(const map::OccupancyGrid& grid, Vec2 from, Vec2 to) {
  const double length = norm(to - from);
  const auto steps = static_cast<int>(std::ceil(length / grid.resolution));
  for (int i = 0; i < steps; ++i) {
    const double way = i * grid.resolution;
    if (occupied(grid, from + (way / length) * (to - from))) return false;
  }
  return true;
}

Reachable::Reachable(const map::OccupancyGrid& grid, Vec2 from, double clearance) {
  std::set<Square> known{square_of(from)};
  squares_.push_back(square_of(from));
  ways_.push_back(0.0);
  for (std::size_t i = 0; i < squares_.size(); ++i) {
    const auto [x, y] = squares_[i];
    for (const Square& next : std::array<Square, 4>{{{x + 1, y}, {x - 1, y}, {x, y + 1}, {x, y - 1}}}) {
      if (known.contains(next)) continue;
      known.insert(next);
      if (!roomy(grid, center_of(next), clearance)) continue;
      squares_.push_back(next);
      ways_.push_back(ways_[i] + kSquare);
    }
  }
}

std::optional<Vec2> Reachable::nearest(const std::function<bool(Vec2)>& fits) const {
  const auto found = std::ranges::find_if(squares_, [&](Square square) { return fits(center_of(square)); });
  return found == squares_.end() ? std::nullopt : std::optional(center_of(*found));
}

std::optional<Vec2> Reachable::best(const std::function<double(Vec2)>& cost) const {
  return best([&cost](Vec2 point, double) { return cost(point); });
}

std::optional<Vec2> Reachable::best(const std::function<double(Vec2, double)>& cost) const {
  double least = std::numeric_limits<double>::infinity();
  std::optional<Vec2> found;
  for (std::size_t i = 0; i < squares_.size(); ++i) {
    const Vec2 point = center_of(squares_[i]);
    const double here = cost(point, ways_[i]);
    if (here >= least) continue;
    least = here;
    found = point;
  }
  return found;
}

void Coverage::add(const map::OccupancyGrid& grid, const Pose2D& map_from_camera, double field_of_view) {
  const Vec2 from = map_from_camera.position();
  const auto rays = static_cast<int>(field_of_view / kRayStep);
  constexpr auto kPoints = static_cast<int>(2.0 * kFarthestView / kSquare);
  for (int ray = 0; ray <= rays; ++ray) {
    const double bearing = ray * kRayStep - 0.5 * field_of_view;
    const auto [s, c] = exact::sincos(map_from_camera.theta + bearing);
    for (int i = 0; i < kPoints; ++i) {
      const Vec2 point = from + 0.5 * i * kSquare * Vec2{c, s};
      if (!free(grid, point)) break;
      seen_.insert(square_of(point));
    }
  }
}

std::optional<Viewpoint> Coverage::next(const map::OccupancyGrid& grid, const Reachable& reachable,
                                        const std::function<bool(Vec2)>& area,
                                        const std::function<double(Vec2)>& detour) const {
  const auto unseen = reachable.best([&](Vec2 point, double way) {
    if (has(square_of(point)) || (area && !area(point))) return std::numeric_limits<double>::infinity();
    return way - (detour ? detour(point) : 0.0);
  });
  if (!unseen) return {};
  const auto stand = reachable.nearest(
      [&](Vec2 point) { return norm(*unseen - point) < kStandOff + kSquare && in_sight(grid, point, *unseen); });
  const Vec2 look = *unseen - stand.value_or(*unseen);
  return Viewpoint{stand.value_or(*unseen), exact::atan2(look.y, look.x), square_of(*unseen)};
}

}  // namespace threewe::agent
