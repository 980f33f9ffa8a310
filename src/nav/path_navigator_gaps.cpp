// The path navigator before gaps that are hardly wider than the robot, and in them.
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "map/blind_surface.hpp"
#include "map/scan_hits.hpp"
#include "nav/path_navigator.hpp"
#include "nav/polyline.hpp"

namespace threewe::nav {

// Walls beside the robot that are too near for its lidar, in `odom`.
std::vector<Vec2> PathNavigator::blind_surface(const Observation& seen) const {
  if (!lidar_) return {};
  return map::blind_surface(seen.obstacles, seen.pose.odom_from_base * *lidar_, range_min_);
}

// What is nearer than `sight` [m], in `odom`.
std::vector<Vec2> PathNavigator::smoothed_hits(const Observation& seen, double sight) const {
  return map::smoothed_near(odom_from_base_.position(), sight, seen.obstacles, odom_from_base_ * *lidar_,
                            params_.bottleneck.flat);
}

// Noise of the lidar would close a gap. The observation refers to `hits`.
Observation PathNavigator::without_noise(const Observation& seen, std::vector<Vec2>& hits) const {
  hits = smoothed_hits(seen, params_.bottleneck.sight);  // beyond, the map is good enough
  Observation smooth = seen;
  smooth.obstacles = hits;
  return smooth;
}

bool PathNavigator::plan_through_gaps(const Observation& seen, double tolerance) {
  if (!lidar_) return false;
  std::vector<Vec2> hits;
  return route_.plan_through_gaps(without_noise(seen, hits), tolerance);
}

// A gap that is tried in vain may take its whole patience.
bool PathNavigator::explore_through_gaps(const Observation& seen, const Explore& goal) {
  if (!lidar_) return false;
  const double detour = way_in(to_seconds(params_.bottleneck.first_patience));
  std::vector<Vec2> hits;
  return route_.plan_to_frontier_through_gaps(without_noise(seen, hits), goal, detour);
}

// A gap is worth the time that it takes where the way round takes longer.
void PathNavigator::plan_shortcut(const Observation& seen, double tolerance) {
  const double detour = way_in(params_.bottleneck.passing);
  if (!lidar_ || !route_.is_detour(detour)) return;
  std::vector<Vec2> hits;
  route_.plan_shortcut(without_noise(seen, hits), tolerance, detour);
}

// The path as far as the place from which the robot lines up for the first gap; empty where there is none.
std::vector<Vec2> PathNavigator::way_to_bottleneck() const {
  const std::optional<Bottleneck>& neck = route_.bottleneck();
  if (!neck) return {};
  const double step = route_.costmap().resolution();
  const Vec2 entry = neck->map_from_middle * Vec2{narrow_passage_.entry(neck->half_length), 0.0};
  const double before = distance(entry, neck->map_from_middle.position());
  std::vector<Vec2> way = {route_.path().front()};
  PathPoint at{0, way.front()};
  const int steps = static_cast<int>(progress_.distance_left / step);
  for (int i = 0; i < steps; ++i) {
    at = place_after(route_.path(), at, step);
    if (distance(at.point, neck->map_from_middle.position()) < before + step) break;
    way.push_back(at.point);
  }
  way.push_back(entry);
  return way;
}

bool PathNavigator::is_before_bottleneck() const {
  const std::optional<Bottleneck>& neck = route_.bottleneck();
  if (!neck) return false;
  const Vec2 in_neck = inverse(neck->map_from_middle) * progress_.pose.position();
  return std::fabs(in_neck.y) < params_.bottleneck.before &&
         in_neck.x > narrow_passage_.entry(neck->half_length) - params_.bottleneck.before && in_neck.x < 0.0;
}

// On its path, without coming nearer to the end of it. A path that has become longer is another one.
bool PathNavigator::hesitates() {
  const double left = progress_.distance_left;
  const bool nearer = left < motion_.least_left - params_.motion.arrived;
  const bool replanned = left > motion_.least_left + params_.bottleneck.ahead;
  if (nearer || replanned) motion_.least_left = left, motion_.least_left_at = now_;
  return now_ - motion_.least_left_at > params_.bottleneck.hesitation;
}

// What keeps the robot from going on is a passage: as wide as the body, and narrower than plans need.
bool PathNavigator::finds_passage(const Observation& seen) {
  if (!lidar_ || route_.bottleneck() || std::holds_alternative<Explore>(goal_)) return false;
  const Vec2 here = progress_.pose.position();
  const std::optional<Bottleneck> place = route_.tight_place_ahead(here);
  if (!place) return false;
  const Pose2D odom_from_middle = inverse(seen.pose.map_from_odom) * place->map_from_middle;
  const std::vector<Vec2> hits = smoothed_hits(seen, params_.bottleneck.sight);
  if (!narrow_passage_.fits({odom_from_middle, place->half_length, 0.0}, hits)) return false;
  route_.squeeze_ahead(here);
  route_.drop();
  return true;
}

Decision PathNavigator::begin_passage(const Observation& seen) {
  const Bottleneck& neck = *route_.bottleneck();
  const Pose2D odom_from_map = inverse(seen.pose.map_from_odom);
  narrow_passage_.begin(now_, odom_from_base_, odom_from_map * neck.map_from_middle, neck.half_length,
                        smoothed_hits(seen, params_.bottleneck.sight));
  return pass(seen);
}

// What is near without its scatter, and zones to keep out of, in the base frame.
std::vector<Vec2> PathNavigator::hits_around(const Observation& seen) const {
  std::vector<Vec2> hits = in_base_;
  if (lidar_) hits = transformed(inverse(odom_from_base_), smoothed_hits(seen, params_.bottleneck.sight));
  const std::vector<Vec2> borders = transformed(inverse(progress_.pose), borders_near(progress_.pose.position()));
  hits.insert(hits.end(), borders.begin(), borders.end());
  return hits;
}

// A manoeuvre may come as near to what is around as in a gap.
Velocity PathNavigator::step_recovery(const Observation& seen) {
  const std::vector<Vec2> hits = hits_around(seen);
  if (lidar_ && recovery_.state() == RecoveryState::arc_escape) follower_.update(hits, params_.creep.margin - margin_);
  const Velocity velocity = recovery_.step(now_, odom_from_base_, hits, follower_);
  progress_.recovery = recovery_.state();
  return velocity;
}

// From within a tight place the cells around look closed: that there is no path is said from outside of it, or once the
// robot has tried to leave.
bool PathNavigator::leaves_first(const Observation& seen) {
  if (motion_.departed || recovery_.can_turn(hits_around(seen))) return false;
  motion_.departed = true;
  motion_.no_path = motion_.no_gap = {};
  recovery_.leave(now_, odom_from_base_);
  return true;
}

// Through a gap, with less room than the gate keeps elsewhere.
Decision PathNavigator::pass(const Observation& seen) {
  mark_moved();  // it is patient by itself
  const std::vector<Vec2> hits = smoothed_hits(seen, std::numbers::sqrt2 * params_.narrow_passage.sight);
  follower_.update(transformed(inverse(odom_from_base_), hits), params_.creep.margin - margin_);

  const Velocity velocity = narrow_passage_.step(now_, odom_from_base_, hits, follower_);
  switch (narrow_passage_.state()) {
    case NarrowPassage::State::through: route_.leave_bottleneck(progress_.pose.position()); break;
    case NarrowPassage::State::closed: route_.close_bottleneck(false); break;
    case NarrowPassage::State::too_narrow: route_.close_bottleneck(true); break;
    case NarrowPassage::State::wide: route_.clear_bottleneck(); break;
    default: break;
  }
  const bool creep_mode = narrow_passage_.creep_mode();
  if (!route_.has_path()) narrow_passage_.end();
  return {velocity, Reason::running, {}, creep_mode};
}

}  // namespace threewe::nav
