#include "scene/scene_tables.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "scene/episodes.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::scene {
namespace {

constexpr double kElbowRoom = 0.05;  // [m] around the footprint where robots are put

// A convex polygon is narrowest across one of its edges.
double half_least_width(const Footprint& footprint) {
  const auto& corners = footprint.corners();
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec2 edge = corners[(i + 1) % corners.size()] - corners[i];
    double width = 0.0;
    for (const Vec2 corner : corners) width = std::max(width, cross(edge, corner - corners[i]) / norm(edge));
    least = std::min(least, width);
  }
  return 0.5 * least;
}

}  // namespace

SceneTables::SceneTables(std::shared_ptr<const Scene> scene, Footprint footprint, double robot_height)
    : scene_(std::move(scene)),
      footprint_(std::move(footprint)),
      passing_radius_(half_least_width(footprint_)),
      obstacles_(scene_->solids_between(0.0, robot_height)),
      occupied_(occupied_cells(grid_over(*scene_), obstacles_.solids())) {
  const CellGrid<float> distance = distance_field(occupied_);
  passable_ = cells_with_clearance(obstacles_, distance, passing_radius_);
  reachable_ = connected_cells(passable_, scene_->starts.front().position());
  const CellSet free = cells_with_clearance(obstacles_, distance, footprint_.circumscribed_radius() + kElbowRoom);
  for (std::size_t i = 0; i < free.cells.size(); ++i) {
    if (free.cells[i] && reachable_.cells[i]) roomy_.push_back(i);
  }
  if (roomy_.empty()) {
    throw ConfigError(fmt::format("scene '{}' has no room for a robot of radius {:.2f} m at its start", scene_->name,
                                  footprint_.circumscribed_radius()));
  }
}

double SceneTables::geodesic(Vec2 from, Vec2 to) const { return geodesic_field(to).length_from(from); }

GeodesicField SceneTables::geodesic_field(Vec2 target, double limit) const { return {passable_, target, limit}; }

Pose2D SceneTables::sample_free_pose(std::uint64_t seed) const {
  return sample_roomy_pose(*this, {.seed = seed, .sensor = 1, .stream = Stream::sampler}, 0);
}

}  // namespace threewe::scene
