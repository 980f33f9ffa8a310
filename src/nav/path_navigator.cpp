// The navigator: where to go next, a way there, and the tracker that drives it.
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "nav/polyline.hpp"
#include "threewe/nav/frontiers.hpp"
#include "threewe/nav/mind.hpp"
#include "threewe/nav/planner.hpp"
#include "threewe/nav/tracker.hpp"
#include "threewe/slam/scan_matching_localizer.hpp"

namespace threewe::nav {
namespace {

constexpr double kMargin = 0.04;        // [m] kept free around the robot, more than the safety gate keeps
constexpr double kTightMargin = 0.025;  // [m] after it got stuck, for kTightFor
constexpr Duration kTightFor = 6s;
constexpr double kArrived = 0.05;       // [m] near enough to a goal to stop
constexpr double kTurned = 0.015;       // [rad]
constexpr Duration kReplanPeriod = 1s;  // plans are renewed so often while the map changes
constexpr Duration kExplorePeriod = 600ms;
constexpr Duration kStuckAfter = 2500ms;  // without having moved, plan anew with what the lidar sees ...
constexpr double kMoved = 0.06;           // [m] ... or turned by kMovedTurn
constexpr double kMovedTurn = 0.3;        // [rad]
constexpr int kMaxRecoveries = 8;         // recoveries in a row before the motion is given up
constexpr Duration kRecovery = 1500ms;    // how long to back off
constexpr Duration kProof = 2500ms;       // for so long no plan may exist before it is believed
constexpr Duration kLostPatience = 5s;
constexpr Duration kMapPatience = 1s;      // how long to wait for a first scan
constexpr double kWaypointPassed = 0.15;   // [m]
constexpr std::uint16_t kMinFrontier = 8;  // [cells] smaller frontiers are not worth a drive
constexpr double kHorizon = 4.0;           // [m] plans end so far outside of the map: all is unknown there
constexpr double kBetter = 0.85;           // a new path replaces an open one when it costs less than this share of it

map::Costmap::Settings costmap_settings(const RobotProfile& profile) {
  // robots move along x, so that half their width passes where they pass
  double half_width = 0.0;
  for (const Vec2 c : profile.body.footprint.corners()) half_width = std::max(half_width, std::fabs(c.y));
  map::Costmap::Settings s;
  s.lethal_radius = std::max(profile.body.footprint.inscribed_radius(), half_width) + 0.01;
  s.caution_radius = s.lethal_radius + 0.35;
  return s;
}

// The point itself or, for one far outside of the map, the nearest within the horizon: beyond it nothing is in the way.
Vec2 within_horizon(const map::OccupancyGrid& map, Vec2 point) {
  const Vec2 low = map.origin - Vec2{kHorizon, kHorizon};
  const Vec2 high = map.origin + Vec2{map.width * map.resolution + kHorizon, map.height * map.resolution + kHorizon};
  return {std::clamp(point.x, low.x, high.x), std::clamp(point.y, low.y, high.y)};
}

class PathNavigator final : public Navigator {
 public:
  explicit PathNavigator(const RobotProfile& profile)
      : costmap_(costmap_settings(profile)),
        tracker_(profile),
        body_radius_(profile.body.footprint.circumscribed_radius()),
        has_lidar_(profile.lidar.has_value()) {}

  void start(const Goal& goal, const Observation& observation) override;
  Decision step(const Observation& observation) override;
  Progress progress() const override { return progress_; }
  std::span<const Vec2> path() const override { return path_; }
  std::unique_ptr<Navigator> clone() const override { return std::make_unique<PathNavigator>(*this); }

 private:
  enum class Plan : std::uint8_t { ready, none, complete };

  Decision drive(const MoveTo& goal, const Observation& seen);
  Decision drive(const Rotate& goal, const Observation& seen);
  Decision drive(const MoveForward& goal, const Observation& seen);
  Decision drive(const FollowPath& goal, const Observation& seen);
  Decision drive(const Explore& goal, const Observation& seen);

  Decision travel(const Observation& seen, Vec2 goal, double tolerance);
  Decision finish(Reason reason, std::string_view detail = {});
  void note(const Observation& seen);
  bool plan_due(const Observation& seen) const;
  void renew_costmap(const Observation& seen);
  Plan plan_route(const Observation& seen, double tolerance);
  Plan plan_exploration(const Observation& seen);
  bool passed_waypoint() const;
  void note_closure();
  void adopt(std::vector<Vec2> path);
  Decision follow();
  Decision wait();
  bool stuck(const Observation& seen);
  Decision recover(const Observation& seen);

  map::Costmap costmap_;
  Planner planner_;
  Tracker tracker_;
  double body_radius_;
  bool has_lidar_;

  Goal goal_;
  Progress progress_;
  Pose2D start_;  // in `map`, at the start of the motion
  Time started_{};
  Time now_{};
  std::vector<Vec2> path_;
  std::vector<Vec2> route_;                // waypoints still to pass, the last is the goal
  std::vector<std::size_t> corners_from_;  // for each of them, how many corners of the path lie from there on
  bool straight_legs_ = false;             // follow the straight lines between waypoints where they are free
  double gap_ = 0.0;                       // [m] from the end of the path to the goal
  bool turning_to_heading_ = false;
  double turned_ = 0.0;  // [rad] since the start
  bool has_plan_ = false;
  Time planned_{};
  std::uint64_t planned_version_ = 0;
  bool replan_ = true;
  Time unplannable_since_{};
  bool unplannable_ = false;
  Pose2D last_moved_;  // where and when the robot last got on
  Time last_moved_at_{};
  std::vector<Vec2> avoided_;   // [m] in `map`: the planner saw a way here, the tracker did not
  std::vector<Vec2> closures_;  // [m] in `map`: where a path that was followed turned out to be blocked
  int recoveries_ = 0;
  Vec2 recovered_at_;
  Time recovering_until_{};
  Velocity recovery_;
  Time tight_until_{};
  bool lost_ = false;
  Time lost_since_{};
  std::vector<Vec2> in_base_;
  std::vector<std::uint16_t> frontiers_;
};

void PathNavigator::start(const Goal& goal, const Observation& seen) {
  goal_ = goal;
  progress_ = {};
  progress_.pose = seen.pose.map_from_base();
  start_ = progress_.pose;
  started_ = seen.now;
  now_ = seen.now;
  path_.clear();
  route_.clear();
  corners_from_.clear();
  straight_legs_ = false;
  gap_ = 0.0;
  turning_to_heading_ = false;
  turned_ = 0.0;
  has_plan_ = false;
  replan_ = true;
  unplannable_ = false;
  last_moved_ = start_;
  last_moved_at_ = seen.now;
  avoided_.clear();
  closures_.clear();
  recoveries_ = 0;
  tracker_.forget_turn();
  recovering_until_ = seen.now;
  tight_until_ = seen.now;
  lost_ = false;
  if (const auto* move = std::get_if<MoveTo>(&goal)) route_ = {move->goal};
  if (const auto* follow = std::get_if<FollowPath>(&goal)) {
    route_ = follow->path;
    straight_legs_ = true;
  }
}

// One period: note what is seen, keep still without a map or a place in it, else drive.
Decision PathNavigator::step(const Observation& seen) {
  note(seen);
  if (has_lidar_ && seen.map_version == 0) {
    if (seen.now - started_ < kMapPatience) return {};
    return finish(Reason::fault, "no scan has arrived");
  }
  if (seen.pose.lost) {
    if (!lost_) lost_ = true, lost_since_ = seen.now;
    return seen.now - lost_since_ > kLostPatience ? finish(Reason::lost) : Decision{};
  }
  lost_ = false;
  return std::visit([&](const auto& goal) { return drive(goal, seen); }, goal_);
}

void PathNavigator::note(const Observation& seen) {
  const Pose2D pose = seen.pose.map_from_base();
  progress_.distance_driven += distance(pose.position(), progress_.pose.position());
  turned_ += wrap_angle(pose.theta - progress_.pose.theta);
  progress_.pose = pose;
  now_ = seen.now;

  const Pose2D base_from_odom = inverse(seen.pose.odom_from_base);
  const auto [s, c] = exact::sincos(base_from_odom.theta);
  in_base_.clear();
  for (const Vec2 p : seen.obstacles) {
    in_base_.push_back({base_from_odom.x + c * p.x - s * p.y, base_from_odom.y + s * p.x + c * p.y});
  }
  tracker_.see(in_base_, seen.now < tight_until_ ? kTightMargin : kMargin);
}

Decision PathNavigator::drive(const MoveTo& goal, const Observation& seen) {
  const double away = distance(progress_.pose.position(), goal.goal);
  if (!turning_to_heading_) {
    const Decision decision = travel(seen, goal.goal, goal.tolerance);
    if (decision.reason != Reason::reached || !goal.theta) return decision;
    turning_to_heading_ = true;
    last_moved_ = progress_.pose;
    last_moved_at_ = seen.now;
  }

  // there: only the heading is left
  progress_.distance_left = away;
  const double angle = wrap_angle(*goal.theta - progress_.pose.theta);
  if (std::fabs(angle) <= std::min(kTurned * 2, goal.angle_tolerance)) return finish(Reason::reached);
  if (stuck(seen)) {
    return std::fabs(angle) <= goal.angle_tolerance ? finish(Reason::reached)
                                                    : finish(Reason::blocked, "no room to turn to the heading");
  }
  return {tracker_.turn(angle)};
}

Decision PathNavigator::drive(const Rotate& goal, const Observation& seen) {
  const double left = goal.angle - turned_;
  progress_.distance_left = 0.0;
  if (std::fabs(left) <= kTurned) return finish(Reason::reached);
  if (stuck(seen)) return finish(Reason::blocked, "no room to turn");
  return {tracker_.turn(left)};
}

Decision PathNavigator::drive(const MoveForward& goal, const Observation& seen) {
  // where the robot is along and beside the line that it started on
  const Pose2D along = inverse(start_) * progress_.pose;
  const double left = goal.distance - along.x;
  progress_.distance_left = std::fabs(left);
  const bool passed = goal.distance >= 0.0 ? left <= 0.01 : left >= -0.01;
  if (passed) return finish(Reason::reached);
  if (stuck(seen)) return finish(Reason::blocked, "something stands in the way");
  return {tracker_.straight(left, -along.y, -along.theta)};
}

Decision PathNavigator::drive(const FollowPath& goal, const Observation& seen) {
  if (route_.empty()) return finish(Reason::reached);
  while (route_.size() > 1 && passed_waypoint()) {
    route_.erase(route_.begin());
    if (!corners_from_.empty()) corners_from_.erase(corners_from_.begin());
  }
  return travel(seen, goal.path.back(), goal.tolerance);
}

Decision PathNavigator::drive(const Explore&, const Observation& seen) {
  if (seen.now < recovering_until_) return {tracker_.safe(recovery_)};
  if (stuck(seen)) return recover(seen);

  const bool due = replan_ || !has_plan_ || seen.now - planned_ >= kExplorePeriod ||
                   distance(progress_.pose.position(), path_.back()) < 0.25;
  if (due && (replan_ || !has_plan_ || seen.now - planned_ >= 200ms)) {
    switch (plan_exploration(seen)) {
      case Plan::complete:
        if (!unplannable_) unplannable_ = true, unplannable_since_ = seen.now;
        return seen.now - unplannable_since_ < kProof ? wait() : finish(Reason::reached);
      case Plan::none: break;
      case Plan::ready: unplannable_ = false; break;
    }
  }
  if (!has_plan_) return wait();
  return follow();
}

// Near the next waypoint, or past it along the path.
bool PathNavigator::passed_waypoint() const {
  if (distance(progress_.pose.position(), route_.front()) < kWaypointPassed) return true;
  return has_plan_ && !corners_from_.empty() && path_.size() <= corners_from_.front();
}

// Towards the end of the route: reached, given up, or on the way along a plan that is kept fresh.
Decision PathNavigator::travel(const Observation& seen, Vec2 goal, double tolerance) {
  const double away = distance(progress_.pose.position(), goal);
  const bool last_leg = route_.size() <= 1;
  if (last_leg && away <= kArrived) return finish(Reason::reached);
  if (last_leg && has_plan_ && gap_ > 0.0 && away <= std::max(0.0, tolerance - 0.05) &&
      distance(progress_.pose.position(), path_.back()) <= kArrived) {
    return finish(Reason::reached);
  }

  if (seen.now < recovering_until_) return {tracker_.safe(recovery_)};
  if (stuck(seen)) {
    if (last_leg && away <= tolerance - 0.05) return finish(Reason::reached);
    return recover(seen);
  }
  if (plan_due(seen)) {
    Plan plan = plan_route(seen, tolerance);
    if (plan == Plan::none && !avoided_.empty()) {
      avoided_.clear();
      plan = plan_route(seen, tolerance);
    }
    if (plan == Plan::none) {
      if (!unplannable_) unplannable_ = true, unplannable_since_ = seen.now;
      if (seen.now - unplannable_since_ > kProof)
        return finish(Reason::no_path, "everything within reach was searched");
    } else {
      unplannable_ = false;
    }
  }
  if (!has_plan_) return wait();
  return follow();
}

Decision PathNavigator::finish(Reason reason, std::string_view detail) {
  path_.clear();
  has_plan_ = false;
  return {{}, reason, detail};
}

bool PathNavigator::plan_due(const Observation& seen) const {
  if (replan_ || !has_plan_) return seen.now - planned_ >= 200ms || replan_;
  return seen.map_version != planned_version_ && seen.now - planned_ >= kReplanPeriod;
}

void PathNavigator::renew_costmap(const Observation& seen) {
  // what the lidar sees now counts too, where the map may not have it yet
  std::vector<Vec2> obstacles = avoided_;
  for (const Vec2 p : seen.obstacles) obstacles.push_back(seen.pose.map_from_odom * p);
  std::vector<Vec2> include = {progress_.pose.position()};
  for (const Vec2 waypoint : route_) include.push_back(within_horizon(seen.map, waypoint));
  costmap_.update(seen.map, obstacles, include);
  costmap_.open_around(progress_.pose.position(), body_radius_ + 0.1);
  planned_ = seen.now;
  planned_version_ = seen.map_version;
  replan_ = false;
}

PathNavigator::Plan PathNavigator::plan_route(const Observation& seen, double tolerance) {
  renew_costmap(seen);

  // leg by leg; straight where the user drew a line that is free
  std::vector<Vec2> path = {progress_.pose.position()};
  std::vector<std::size_t> ends;  // how many corners lead to each waypoint
  double gap = 0.0;
  for (const Vec2 ordered : route_) {
    const Vec2 waypoint = within_horizon(seen.map, ordered);
    const bool drawn = straight_legs_ && std::isfinite(costmap_.line_cost(path.back(), waypoint));
    if (drawn) {
      path.push_back(waypoint);
      ends.push_back(path.size());
      continue;
    }
    const PlannedPath leg = planner_.plan(costmap_, path.back(), waypoint, tolerance);
    gap = leg.points.empty() ? std::numeric_limits<double>::infinity() : leg.gap;
    if (gap > tolerance - 0.05 && gap > 0.0) {
      has_plan_ = false;
      path_.clear();
      return Plan::none;
    }
    path.insert(path.end(), leg.points.begin() + 1, leg.points.end());
    ends.push_back(path.size());
  }

  // an open path is kept unless the new one is clearly better, so that the robot does not waver
  const double cost = path_cost(costmap_, path);
  if (has_plan_) {
    const double rest_cost = path_cost(costmap_, path_);
    if (!std::isfinite(rest_cost)) note_closure();
    const bool same_end = path_.back() == path.back();
    if (std::isfinite(rest_cost) && same_end && cost > kBetter * rest_cost) return Plan::ready;
  }
  gap_ = gap;
  corners_from_.clear();
  for (const std::size_t end : ends) corners_from_.push_back(path.size() - end + 1);
  adopt(std::move(path));
  return Plan::ready;
}

// The path is blocked. A place that looked open from afar twice and was not is avoided from then on.
void PathNavigator::note_closure() {
  constexpr double kSamePlace = 0.4;  // [m]
  const PathPoint start{0, path_.front()};
  const double length = path_length(path_);
  for (double ahead = 0.0; ahead < length; ahead += 0.05) {
    const Vec2 p = point_after(path_, start, ahead);
    if (costmap_.weight(costmap_.cell(p)) != map::Costmap::kLethal) continue;
    const auto same = [p](Vec2 other) { return distance(p, other) < kSamePlace; };
    const auto times = std::count_if(closures_.begin(), closures_.end(), same);
    (times >= 1 ? avoided_ : closures_).push_back(p);
    return;
  }
}

// To the nearest frontier by the cost of the way there.
PathNavigator::Plan PathNavigator::plan_exploration(const Observation& seen) {
  renew_costmap(seen);
  find_frontiers(costmap_, frontiers_);
  const map::Cell here = costmap_.cell(progress_.pose.position());
  const SearchResult found = planner_.search().to_any(
      costmap_, here, [&](std::uint32_t index) { return frontiers_[index] >= kMinFrontier; },
      [&](std::uint32_t index) { return costmap_.unknown()[index] != 0; });
  if (!found.found) {
    has_plan_ = false;
    path_.clear();
    return Plan::complete;
  }
  adopt(Planner::straighten(costmap_, found.path, progress_.pose.position(), costmap_.center(found.path.back())));
  return Plan::ready;
}

void PathNavigator::adopt(std::vector<Vec2> path) {
  path_ = std::move(path);
  has_plan_ = true;
}

// Along the path, forgetting what lies behind.
Decision PathNavigator::follow() {
  const PathPoint here = nearest_on_path(path_, progress_.pose.position());
  path_.erase(path_.begin(), path_.begin() + static_cast<std::ptrdiff_t>(here.piece));
  path_.front() = here.point;
  progress_.distance_left = path_length(path_);
  return {tracker_.follow(path_, costmap_, progress_.pose)};
}

// Stands still on purpose, which is not being stuck.
Decision PathNavigator::wait() {
  last_moved_ = progress_.pose;
  last_moved_at_ = now_;
  return {};
}

// Has the robot stayed where it is for too long?
bool PathNavigator::stuck(const Observation& seen) {
  const bool moved = distance(progress_.pose.position(), last_moved_.position()) > kMoved ||
                     std::fabs(wrap_angle(progress_.pose.theta - last_moved_.theta)) > kMovedTurn;
  if (moved) {
    last_moved_ = progress_.pose;
    last_moved_at_ = seen.now;
  }
  return tracker_.trapped() || seen.now - last_moved_at_ > kStuckAfter;
}

// Backs off in the direction with most room, then plans another way; gives up after a few times in the same place.
Decision PathNavigator::recover(const Observation& seen) {
  if (distance(progress_.pose.position(), recovered_at_) > 0.5) recoveries_ = 0;
  recovered_at_ = progress_.pose.position();
  if (++recoveries_ > kMaxRecoveries) return finish(Reason::blocked, "recoveries did not help");

  // the planner shall not try the same way again nor, after a second failure, explore the same place
  constexpr double kAhead = 0.25;  // [m]
  if (has_plan_ && !tracker_.trapped() && path_length(path_) > kAhead) {
    avoided_.push_back(point_after(path_, {0, path_.front()}, kAhead));
    if (recoveries_ >= 2 && std::holds_alternative<Explore>(goal_)) avoided_.push_back(path_.back());
  }

  // stuck for as long again before the next recovery
  last_moved_ = progress_.pose;
  last_moved_at_ = seen.now + kRecovery;
  tight_until_ = seen.now + kRecovery + kTightFor;
  tracker_.see(in_base_, kTightMargin);
  tracker_.forget_turn();
  recovery_ = tracker_.most_room();
  recovering_until_ = seen.now + kRecovery;
  replan_ = true;
  has_plan_ = false;
  return {recovery_};
}

}  // namespace

std::unique_ptr<Navigator> make_navigator(const RobotProfile& profile) {
  return std::make_unique<PathNavigator>(profile);
}

std::string_view to_string(Reason reason) {
  switch (reason) {
    case Reason::running: return "running";
    case Reason::reached: return "reached";
    case Reason::no_path: return "no_path";
    case Reason::blocked: return "blocked";
    case Reason::timeout: return "timeout";
    case Reason::cancelled: return "cancelled";
    case Reason::estop: return "estop";
    case Reason::lost: return "lost";
    case Reason::fault: return "fault";
  }
  return "unknown";
}

}  // namespace threewe::nav

namespace threewe::slam {

std::unique_ptr<Localizer> make_localizer(const RobotProfile& profile, const Pose2D& map_from_start) {
  SensorModel sensors;
  const double uniform = 1.0 / exact::sqrt(3.0);  // deviation of what is uniform in [-1, 1]
  if (profile.lidar) {
    sensors.base_from_lidar = profile.lidar->base_from_lidar;
    sensors.range_bias_sigma = uniform * profile.lidar->bias;
  }
  if (profile.imu) {
    sensors.gyro_sigma = profile.imu->gyro_sigma;
    sensors.gyro_bias_sigma = uniform * profile.imu->gyro_bias;
    sensors.gyro_bias_walk = profile.imu->gyro_bias_walk;
  }
  const OdometrySpec& wheels = profile.odometry;
  sensors.forward_scale_sigma = uniform * wheels.wheel_scale;
  sensors.lateral_scale = 0.5 * (wheels.lateral_scale_min + wheels.lateral_scale_max);
  sensors.lateral_scale_sigma = uniform * 0.5 * (wheels.lateral_scale_max - wheels.lateral_scale_min);
  return make_scan_matching_localizer(sensors, map_from_start);
}

}  // namespace threewe::slam
