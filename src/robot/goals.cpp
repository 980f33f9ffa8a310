#include "robot/goals.hpp"

#include <cmath>
#include <string>

#include "threewe/core/errors.hpp"

namespace threewe {
namespace {

template <class... Visitors>
struct Overloaded : Visitors... {
  using Visitors::operator()...;
};

void require_finite(double value, const char* what) {
  if (!std::isfinite(value)) throw ContractError(std::string(what) + " must be finite, not " + std::to_string(value));
}

void require_positive(double value, const char* what) {
  require_finite(value, what);
  if (value <= 0.0) throw ContractError(std::string(what) + " must be positive, not " + std::to_string(value));
}

// Who searches for places farther from the goal than that searches all of the map.
void require_tolerance(double value) {
  constexpr double kMost = 10.0;  // [m]
  require_positive(value, "tolerance");
  if (value > kMost) throw ContractError("tolerance must be at most 10 m, not " + std::to_string(value));
}

void check_place(const nav::MoveTo& goal) {
  require_finite(goal.goal.x, "goal x");
  require_finite(goal.goal.y, "goal y");
  if (goal.theta) require_finite(*goal.theta, "goal theta");
  require_tolerance(goal.tolerance);
  require_positive(goal.angle_tolerance, "angle tolerance");
}

}  // namespace

void check_goal(const nav::Goal& goal) {
  std::visit(Overloaded{
                 [](const nav::MoveTo& g) { check_place(g); },
                 [](const nav::Rotate& g) {
                   require_finite(g.angle, "angle");
                   require_positive(g.angle_tolerance, "angle tolerance");
                 },
                 [](const nav::MoveForward& g) {
                   require_finite(g.distance, "distance");
                   require_tolerance(g.tolerance);
                 },
                 [](const nav::FollowPath& g) {
                   if (g.path.empty()) throw ContractError("path must have at least one point");
                   for (const Vec2 p : g.path) {
                     require_finite(p.x, "path x");
                     require_finite(p.y, "path y");
                   }
                   require_tolerance(g.tolerance);
                 },
                 [](const nav::FollowWaypoints& g) {
                   if (g.waypoints.empty()) throw ContractError("waypoints must have at least one place");
                   for (const nav::MoveTo& place : g.waypoints) check_place(place);
                 },
                 [](const nav::Explore&) {},
             },
             goal);
}

void check_zone(const map::Zone& zone) {
  if (zone.corners.size() < 3) {
    throw ContractError("a zone needs at least 3 corners, not " + std::to_string(zone.corners.size()));
  }
  for (const Vec2 corner : zone.corners) {
    require_finite(corner.x, "a zone's corner x");
    require_finite(corner.y, "a zone's corner y");
  }
  if (zone.speed_limit) require_positive(*zone.speed_limit, "a zone's speed_limit");
}

void check_velocity(const RobotProfile& profile, const Velocity& velocity) {
  require_finite(velocity.vx, "vx");
  require_finite(velocity.vy, "vy");
  require_finite(velocity.omega, "omega");
  if (velocity.vy != 0.0 && profile.kinematics() == Kinematics::differential) {
    throw ContractError("vy must be 0 on the differential base of '" + profile.name + "'");
  }
}

std::optional<double> tolerance_in_map(const nav::Goal& goal) {
  using Tolerance = std::optional<double>;
  return std::visit(Overloaded{
                        [](const nav::MoveTo& g) -> Tolerance { return g.tolerance; },
                        [](const nav::FollowPath& g) -> Tolerance { return g.tolerance; },
                        [](const nav::FollowWaypoints& g) -> Tolerance { return g.waypoints.back().tolerance; },
                        [](const auto&) -> Tolerance { return {}; },
                    },
                    goal);
}

double distance_to_goal(const nav::Goal& goal, const Pose2D& map_from_base, const nav::Progress& progress) {
  const Vec2 here = map_from_base.position();
  return std::visit(Overloaded{
                        [&](const nav::MoveTo& g) { return distance(here, g.goal); },
                        [&](const nav::FollowPath& g) { return distance(here, g.path.back()); },
                        [&](const nav::FollowWaypoints& g) { return distance(here, g.waypoints.back().goal); },
                        [](const nav::Explore&) { return 0.0; },
                        [](const nav::Rotate&) { return 0.0; },
                        [&](const nav::MoveForward&) { return progress.distance_left; },
                    },
                    goal);
}

}  // namespace threewe
