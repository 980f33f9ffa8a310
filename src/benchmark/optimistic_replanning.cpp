#include "benchmark/optimistic_replanning.hpp"

#include <vector>

#include "benchmark/sight.hpp"

namespace threewe::benchmark {
namespace {

constexpr double kAround = 4.0;          // [m] around the scene that a way can be hoped for in
constexpr double kLongestDrive = 500.0;  // [m] no drive in our scenes is longer

}  // namespace

// Obstacles only ever come in, so that a shortest path stays one for as long as it is open.
ReferenceDrive optimistic_replanning(const scene::SceneTables& tables, const RobotProfile& profile, const Pose2D& start,
                                     Vec2 goal) {
  require_inside(tables, "start", start.position());
  require_inside(tables, "goal", goal);
  Sight sight(tables, profile, kAround);
  Walk walk(start.position());
  std::vector<Vec2> path;
  while (walk.length() < kLongestDrive) {
    sight.look({walk.here().x, walk.here().y, start.theta});
    if (path.empty() || !sight.is_open(path)) path = scene::GeodesicField(sight.open(), goal).path_from(walk.here());
    if (path.size() < 2) break;
    walk.along(path, kStride);
  }
  const bool reached = distance(walk.here(), goal) < 1e-9;
  return {reached, walk.length(), walk.length() / profile.operating_limits.linear};
}

}  // namespace threewe::benchmark
