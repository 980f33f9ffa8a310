#include "wall_plan.hpp"

#include <algorithm>
#include <cmath>

namespace threewe::scene {
namespace {

constexpr double kSmallestPiece = 1e-3;  // [m] of a wall, left over beside a door

// How much longer [m] a wall is made at its ends.
struct Extension {
  double before_a = 0.0;
  double after_b = 0.0;
};

// Where walls meet end to end at an angle, the first of them is made longer to fill the corner.
std::vector<Extension> close_corners(const std::vector<WallPlan>& plan) {
  std::vector<Extension> extensions(plan.size());
  for (std::size_t i = 0; i < plan.size(); ++i) {
    const Wall& wall = plan[i].wall;
    for (std::size_t j = i + 1; j < plan.size(); ++j) {
      const Wall& next = plan[j].wall;
      if (parallel(wall, next)) continue;
      if (wall.a == next.a || wall.a == next.b) extensions[i].before_a = 0.5 * next.thickness;
      if (wall.b == next.a || wall.b == next.b) extensions[i].after_b = 0.5 * next.thickness;
    }
  }
  return extensions;
}

// Adds the pieces that doorways leave of a wall.
void cut_doorways(const WallPlan& plan, const Extension& extension, std::vector<Wall>& pieces) {
  const Wall& wall = plan.wall;
  const double length = distance(wall.a, wall.b);
  const Vec2 along = (1.0 / length) * (wall.b - wall.a);
  double from = -extension.before_a;
  const auto add_piece = [&](double to) {
    if (to - from < kSmallestPiece) return;
    Wall piece = wall;
    piece.a = wall.a + from * along;
    piece.b = wall.a + to * along;
    pieces.push_back(piece);
  };
  std::vector<Doorway> doorways = plan.doorways;
  std::ranges::sort(doorways, {}, &Doorway::at);
  for (const Doorway& doorway : doorways) {
    add_piece(doorway.at - 0.5 * doorway.width);
    from = doorway.at + 0.5 * doorway.width;
  }
  add_piece(length + extension.after_b);
}

}  // namespace

bool parallel(const Wall& a, const Wall& b) {
  const Vec2 u = a.b - a.a;
  const Vec2 v = b.b - b.a;
  return std::fabs(cross(u, v)) < 1e-6 * norm(u) * norm(v);
}

void Scene::build_walls() {
  walls.clear();
  doors.clear();
  const std::vector<Extension> extensions = close_corners(plan);
  for (std::size_t i = 0; i < plan.size(); ++i) {
    const Wall& wall = plan[i].wall;
    const double length = distance(wall.a, wall.b);
    cut_doorways(plan[i], extensions[i], walls);
    for (const Doorway& doorway : plan[i].doorways) {
      doors.push_back({doorway.name, wall.a + (doorway.at / length) * (wall.b - wall.a), doorway.width});
    }
  }

  min = max = walls.front().a;
  for (const Wall& wall : walls) {
    const auto [low, high] = bounds(solid_of(wall));
    min = {std::min(min.x, low.x), std::min(min.y, low.y)};
    max = {std::max(max.x, high.x), std::max(max.y, high.y)};
  }
}

}  // namespace threewe::scene
