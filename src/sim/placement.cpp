#include "sim/placement.hpp"

#include <algorithm>

namespace threewe::sim {
namespace {

std::vector<Vec2> outline(const Footprint& footprint, const Pose2D& pose) {
  std::vector<Vec2> corners;
  for (const Vec2 corner : footprint.corners()) corners.push_back(pose * corner);
  return corners;
}

// Whether the line through an edge of `a` has all of `b` on its outer side.
bool edge_separates(const std::vector<Vec2>& a, const std::vector<Vec2>& b) {
  for (std::size_t i = 0; i < a.size(); ++i) {
    const Vec2 edge = a[(i + 1) % a.size()] - a[i];
    if (std::ranges::all_of(b, [&](Vec2 point) { return cross(edge, point - a[i]) <= 0.0; })) return true;
  }
  return false;
}

}  // namespace

std::optional<std::string> find_collision(const Model& model, std::size_t robot, const Pose2D& pose) {
  const std::vector<Vec2> corners = outline(model.robots[robot].body.footprint, pose);
  for (const scene::Solid& solid : model.robots[robot].solids) {
    if (!scene::overlaps(solid, corners)) continue;
    if (solid.object < 0) return "a wall";
    return model.scene->objects[static_cast<std::size_t>(solid.object)].name;
  }
  return std::nullopt;
}

bool robots_overlap(const RobotModel& a, const Pose2D& pose_a, const RobotModel& b, const Pose2D& pose_b) {
  const std::vector<Vec2> corners_a = outline(a.body.footprint, pose_a);
  const std::vector<Vec2> corners_b = outline(b.body.footprint, pose_b);
  return !edge_separates(corners_a, corners_b) && !edge_separates(corners_b, corners_a);
}

}  // namespace threewe::sim
