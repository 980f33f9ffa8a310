#include "nav/path_navigator.hpp"
#include "core/exact.hpp"
#include "safety/params.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <variant>

#include "hardware/parameters.hpp"

namespace threewe::nav {
namespace {

// [m] Robots move along x, so that this passes where they pass.
double half_width(const RobotProfile& profile) {
  double most = 0.0;
  for (const Vec2 c : profile.body.footprint.corners()) most = std::max(most, std::fabs(c.y));
  return most;
}

bool has_free_cell(const map::OccupancyGrid& map) {
  return std::ranges::any_of(map.data, [](std::int8_t value) {
    return value != map::OccupancyGrid::kUnknown && value <= map::OccupancyGrid::kFreeThreshold;
  });
}

// Which time in one place a robot creeps on instead of avoiding the place: sooner where it sees what is beside it.
int creep_after(const RobotProfile& profile, const Params::Motion& params) {
  const bool sees_sides = profile.lidar && profile.lidar->range_min < half_width(profile);
  return params.creep_after + (sees_sides ? 0 : 1);
}

map::Costmap::Settings costmap_settings(const RobotProfile& profile, const Params& params) {
  const Params::Clearance& clearance = profile.lidar ? params.clearance : params.sonar_clearance;
  map::Costmap::Settings s;
  s.lethal_radius = std::max(profile.body.footprint.inscribed_radius(), half_width(profile)) + clearance.spare;
  s.caution_radius = s.lethal_radius + clearance.caution;
  s.near_weight = clearance.weight;
  s.unknown_weight = params.route.unknown_weight;
  if (profile.lidar) s.sight = params.route.sight * profile.lidar->range_max;
  s.blind_weight = params.route.blind_weight;
  return s;
}

}  // namespace

PathNavigator::PathNavigator(const RobotProfile& profile)
    : PathNavigator(profile, params_for<Params>(profile, "nav")) {}

PathNavigator::PathNavigator(const RobotProfile& profile, const Params& params)
    : params_(params),
      route_(costmap_settings(profile, params), profile, params),
      limits_(profile.operating_limits),
      body_radius_(profile.body.footprint.circumscribed_radius()),
      margin_(safety::margin_of(profile)),
      creep_after_(creep_after(profile, params.motion)),
      follower_(profile, params),
      recovery_(profile, params),
      narrow_passage_(profile, params),
      monitor_(profile.operating_limits.linear, params) {
  if (profile.lidar) lidar_ = profile.lidar->base_from_lidar.position(), range_min_ = profile.lidar->range_min;
}

void PathNavigator::start(const Goal& goal, const Observation& seen) {
  goal_ = goal;
  now_ = seen.now;
  progress_ = {};
  progress_.pose = seen.pose.map_from_base();
  motion_ = {};
  motion_.start = odom_from_base_ = seen.pose.odom_from_base;
  motion_.started = seen.now;

  const auto* move = std::get_if<MoveTo>(&goal);
  const auto* follow = std::get_if<FollowPath>(&goal);
  if (const auto* visit = std::get_if<FollowWaypoints>(&goal)) return begin_waypoint(*visit, 0);
  begin_leg(move ? std::vector{move->goal} : follow ? follow->path : std::vector<Vec2>{}, follow != nullptr);
}

// What was found out on the way so far says nothing of this one.
void PathNavigator::begin_leg(std::vector<Vec2> points, bool along) {
  motion_.last_moved = progress_.pose;
  motion_.last_moved_at = motion_.tight_until = now_;
  follower_.forget_turn();
  recovery_.reset();
  narrow_passage_.end();
  monitor_.begin(now_);
  route_.begin(std::move(points), along);
}

void PathNavigator::begin_waypoint(const FollowWaypoints& goal, std::size_t number) {
  Motion next;
  next.start = motion_.start;
  next.started = motion_.started;
  next.turned = motion_.turned;
  next.waypoint = number;
  for (std::size_t i = number + 1; i < goal.waypoints.size(); ++i) {
    next.rest += distance(goal.waypoints[i - 1].goal, goal.waypoints[i].goal);
  }
  motion_ = next;
  begin_leg({goal.waypoints[number].goal}, false);
}

Progress PathNavigator::progress() const {
  Progress progress = progress_;
  progress.distance_left += motion_.rest;
  return progress;
}

// One period: note what is seen, decide, and keep to the limits of zones.
Decision PathNavigator::step(const Observation& observed) {
  Observation seen = observed;
  const std::vector<Vec2> more = blind_surface(observed);
  std::vector<Vec2> obstacles;
  if (!more.empty()) {
    obstacles.assign(observed.obstacles.begin(), observed.obstacles.end());
    obstacles.insert(obstacles.end(), more.begin(), more.end());
    seen.obstacles = obstacles;
  }
  note(seen);
  Decision decision = decide(seen);
  decision.velocity = within_zones(decision.velocity);
  estimate_time_left();
  return decision;
}

// Keep still without a map, look round without a place in it, else drive.
Decision PathNavigator::decide(const Observation& seen) {
  if (lidar_ && seen.map_version == 0) {
    return now_ - motion_.started < params_.motion.map_patience ? Decision{}
                                                                : finish(Reason::fault, "no scan has arrived");
  }
  const bool relative = std::holds_alternative<Rotate>(goal_) || std::holds_alternative<MoveForward>(goal_);
  if (!relative && (seen.pose.lost() || motion_.lost)) return find_itself(seen);
  if (!relative && monitor_.stalled(now_)) return finish(Reason::blocked, and_who_is_near("it makes no progress"));
  if (recovery_.active()) return recover(seen);
  recovery_.remember(odom_from_base_);
  return std::visit([&](const auto& goal) { return drive(goal, seen); }, goal_);
}

void PathNavigator::set_zones(const std::vector<map::Zone>& zones) {
  zones_ = zones;
  route_.set_zones(zones, limits_.linear);
}

// So slow that the body enters no zone faster than is allowed there.
Velocity PathNavigator::within_zones(const Velocity& velocity) const {
  double most = limits_.linear;
  for (const map::Zone& zone : zones_) {
    if (!zone.speed_limit) continue;
    const double reaction = params_.motion.zone_reaction * limits_.linear;
    const double away = std::max(0.0, zone.distance_to(progress_.pose.position()) - body_radius_ - reaction);
    const double limit = *zone.speed_limit;
    most = std::min(most,
                    exact::sqrt(limit * limit + 2.0 * params_.follower.gentle_braking * limits_.linear_braking * away));
  }
  const double speed = exact::hypot(velocity.vx, velocity.vy);
  const double share = speed > most ? most / speed : 1.0;
  return {share * velocity.vx, share * velocity.vy, share * velocity.omega};
}

void PathNavigator::note(const Observation& seen) {
  const Pose2D pose = seen.pose.map_from_base();
  progress_.distance_driven += distance(pose.position(), progress_.pose.position());
  motion_.turned += wrap_angle(seen.pose.odom_from_base.theta - odom_from_base_.theta);
  odom_from_base_ = seen.pose.odom_from_base;
  progress_.pose = pose;
  progress_.recovery = RecoveryState::driving;
  now_ = seen.now;

  const Pose2D base_from_odom = inverse(odom_from_base_);
  const auto [s, c] = exact::sincos(base_from_odom.theta);
  in_base_.clear();
  for (const Vec2 p : seen.obstacles) {
    in_base_.push_back({base_from_odom.x + c * p.x - s * p.y, base_from_odom.y + s * p.x + c * p.y});
  }
  monitor_.update(now_, pose.position(), progress_.distance_left);
  remember_movers(seen);
  follower_.update(in_base_, recovery_.active() || now_ < motion_.tight_until ? 0.0 : params_.motion.spare);
}

// At the pace of this motion so far, to begin with at a share of the speed limit.
void PathNavigator::estimate_time_left() {
  const double prior = params_.motion.prior_time;
  const double share = params_.motion.expected_speed;
  const double elapsed = to_seconds(now_ - motion_.started);
  const double mean_speed = (progress_.distance_driven + prior * share * limits_.linear) / (elapsed + prior);
  progress_.time_left =
      (progress_.distance_left + motion_.rest) / mean_speed + motion_.turn_left / (share * limits_.angular);
}

Decision PathNavigator::drive(const MoveTo& goal, const Observation& seen) {
  if (!motion_.at_goal) {
    if (goal.theta) motion_.turn_left = std::fabs(wrap_angle(*goal.theta - progress_.pose.theta));
    const Decision decision = travel(seen, goal.goal, goal.tolerance);
    if (decision.reason != Reason::reached || !goal.theta) return decision;
    motion_.at_goal = true;
    mark_moved();
  }

  // there: only the heading is left
  progress_.distance_left = distance(progress_.pose.position(), goal.goal);
  const double angle = wrap_angle(*goal.theta - progress_.pose.theta);
  motion_.turn_left = std::fabs(angle);
  if (std::fabs(angle) <= std::min(2.0 * params_.motion.turned, goal.angle_tolerance)) return finish(Reason::reached);
  if (!stuck()) return {follower_.turn(angle)};
  if (std::fabs(angle) <= goal.angle_tolerance) return finish(Reason::reached);
  return finish(Reason::blocked, "no room to turn to the heading");
}

Decision PathNavigator::drive(const Rotate& goal, const Observation&) {
  const double left = goal.angle - motion_.turned;
  progress_.distance_left = 0.0;
  motion_.turn_left = std::fabs(left);
  if (motion_.turn_left <= std::min(params_.motion.turned, goal.angle_tolerance)) return finish(Reason::reached);
  if (stuck()) {
    return motion_.turn_left <= goal.angle_tolerance ? finish(Reason::reached)
                                                     : finish(Reason::blocked, "no room to turn");
  }
  return {follower_.turn(left)};
}

Decision PathNavigator::drive(const MoveForward& goal, const Observation&) {
  // where the robot is along and beside the line that it started on
  const Pose2D along = inverse(motion_.start) * odom_from_base_;
  const double left = goal.distance - along.x;
  progress_.distance_left = std::fabs(left);
  const double there = std::min(0.5 * params_.motion.arrived, goal.tolerance);
  if (goal.distance >= 0.0 ? left <= there : left >= -there) return finish(Reason::reached);
  if (stuck()) {
    return std::fabs(left) <= goal.tolerance ? finish(Reason::reached)
                                             : finish(Reason::blocked, "something stands in the way");
  }
  return {follower_.straight(left, -along.y, -along.theta)};
}

Decision PathNavigator::drive(const FollowPath& goal, const Observation& seen) {
  if (goal.path.empty()) return finish(Reason::reached);
  return travel(seen, goal.path.back(), goal.tolerance);
}

// As one motion to each.
Decision PathNavigator::drive(const FollowWaypoints& goal, const Observation& seen) {
  const std::size_t number = motion_.waypoint, count = goal.waypoints.size();
  Decision decision = drive(goal.waypoints[number], seen);
  if (decision.reason == Reason::running) return decision;
  if (decision.reason == Reason::reached) {
    if (number + 1 == count) return decision;
    begin_waypoint(goal, number + 1);
    return {};
  }
  decision.detail = "waypoint " + std::to_string(number + 1) + " of " + std::to_string(count) + ": " + decision.detail;
  return decision;
}

// From frontier to frontier, until for some time none has been left.
Decision PathNavigator::drive(const Explore& goal, const Observation& seen) {
  if (narrow_passage_.active()) return pass(seen);
  if (stuck()) return get_unstuck();

  // from near a frontier more is seen than from afar
  const bool near =
      route_.has_path() && distance(progress_.pose.position(), route_.path().back()) < params_.route.near_frontier;
  const bool due = route_.age(now_) >= (near || !route_.has_path() ? params_.route.retry : params_.route.explore);
  if (due && !route_.bottleneck()) {  // a way through a gap is driven until something comes of it
    const bool explored = holds(motion_.no_path, !route_.plan_to_frontier(seen, goal));
    if (explored && !explore_through_gaps(seen, goal)) {
      if (!has_free_cell(seen.map)) return finish(Reason::blocked, "nothing around the robot has been seen to be free");
      return finish(Reason::reached, route_.left_some() ? "what is left to see is not worth the way: see `thorough`"
                                                        : "nothing that can be reached is left to see");
    }
  }
  return route_.has_path() ? follow(seen) : wait();
}

// Towards the end of the route: reached, given up, or on the way along a plan that is kept fresh.
Decision PathNavigator::travel(const Observation& seen, Vec2 goal, double tolerance) {
  const Vec2 here = progress_.pose.position();
  const bool last_leg = route_.on_last_leg();
  const double left = last_leg ? distance(here, goal) : std::numeric_limits<double>::infinity();
  if (left <= std::min(params_.motion.arrived, 0.5 * tolerance)) return finish(Reason::reached);
  const bool at_end = route_.has_path() && distance(here, route_.path().back()) <= params_.motion.path_end;
  if (left <= tolerance - params_.motion.path_end && route_.gap() > 0.0 && at_end) return finish(Reason::reached);

  if (narrow_passage_.active()) return pass(seen);
  if (stuck()) return left <= tolerance - params_.motion.arrived ? finish(Reason::reached) : get_unstuck();
  if (route_.is_stale(seen, params_.route.replan)) {
    const bool found = route_.plan_to_goal(seen, tolerance);
    const bool proven = holds(motion_.no_path, !found);
    if (holds(motion_.no_gap, proven && !plan_through_gaps(seen, tolerance))) {
      return leaves_first(seen) ? Decision{} : give_up_path(seen, tolerance);
    }
    if (found) plan_shortcut(seen, tolerance);
  }
  return route_.has_path() ? follow(seen) : wait();
}

Decision PathNavigator::follow(const Observation& seen) {
  route_.advance(progress_.pose.position());
  progress_.distance_left = path_length(route_.path());
  if (is_before_bottleneck()) return begin_passage(seen);
  if (hesitates() && finds_passage(seen)) return wait();
  const std::vector<Vec2> way = way_to_bottleneck();
  const std::span<const Vec2> path = way.empty() ? route_.path() : way;
  // where it may be too tight for what the noise of plans finds
  const bool at_end = distance(progress_.pose.position(), path.back()) < params_.motion.last;
  if (lidar_ && !at_end) return {follow_by_plan(seen, path)};
  const double aside = lidar_ ? 0.0 : sweep_angle();
  return {follower_.pursue(path, route_.costmap(), progress_.pose, aside)};
}

// Round what the lidar sees and zones to keep out of, away from people and other robots.
Velocity PathNavigator::follow_by_plan(const Observation& seen, std::span<const Vec2> path) {
  const Pose2D odom_from_map = inverse(seen.pose.map_from_odom);
  std::vector<Vec2> obstacles = transformed(odom_from_map, borders_near(progress_.pose.position()));
  obstacles.insert(obstacles.begin(), seen.obstacles.begin(), seen.obstacles.end());

  std::vector<MovingDisc> moving;
  for (const perception::TrackedPerson& person : seen.people)
    moving.push_back({person.position, person.velocity, params_.motion.person_radius});
  for (const Peer& peer : seen.peers) {
    const Pose2D at = odom_from_map * peer.map_from_base;
    moving.push_back({at.position(), rotate({peer.velocity.vx, peer.velocity.vy}, at.theta), peer.radius});
  }
  return follower_.follow(transformed(odom_from_map, path), {now_, odom_from_base_, seen.commanded, obstacles, moving});
}

// [rad] A robot that senses in a few directions only looks about as it drives, from side to side: sensors a quarter
// turn apart then detect all that is ahead. The heading lags behind, so that this is a little more than half of the
// gap.
double PathNavigator::sweep_angle() const {
  const Duration period = params_.motion.sweep_period;
  const double phase = to_seconds((now_ - motion_.started) % period) / to_seconds(period);
  const double triangle = phase < 0.25 ? phase : phase < 0.75 ? 0.5 - phase : phase - 1.0;  // -0.25 to 0.25
  return 4.0 * params_.motion.sweep_angle * triangle;
}

// Points on the borders of zones to keep out of, in `map`.
std::vector<Vec2> PathNavigator::borders_near(Vec2 robot) const {
  std::vector<Vec2> points;
  for (const map::Zone& zone : zones_) {
    if (zone.speed_limit) continue;
    for (std::size_t i = 0; i < zone.corners.size(); ++i) {
      const Vec2 a = zone.corners[i];
      const Vec2 side = zone.corners[(i + 1) % zone.corners.size()] - a;
      const int parts = 1 + static_cast<int>(norm(side) / params_.follower.step);
      for (int k = 0; k < parts; ++k) {
        const Vec2 p = a + (static_cast<double>(k) / parts) * side;
        if (distance(p, robot) <= params_.motion.border_sight) points.push_back(p);
      }
    }
  }
  return points;
}

// Stands still on purpose, which is not being stuck.
Decision PathNavigator::wait() {
  mark_moved();
  return {};
}

void PathNavigator::mark_moved() {
  motion_.last_moved = progress_.pose;
  motion_.last_moved_at = now_;
}

Decision PathNavigator::finish(Reason reason, std::string detail) {
  route_.drop();
  return {{}, reason, std::move(detail)};
}

// No path is a proof only of what does not move: who stands in the way may leave.
Decision PathNavigator::give_up_path(const Observation& seen, double tolerance) {
  const std::optional<Mover> mover = route_.mover_in_the_way(seen, tolerance);
  if (!mover) return finish(Reason::no_path, "everything within reach was searched");
  if (now_ - motion_.no_path.since <= params_.motion.courtesy) return wait();
  return finish(Reason::blocked, to_string(*mover) + " stands in the only way");
}

// Peers where they say that they are, and all that moves where it was last seen to: a peer, too, may have left its mark
// in the map.
void PathNavigator::remember_movers(const Observation& seen) {
  for (const Peer& peer : seen.peers) route_.note_mover({peer.name, peer.map_from_base.position(), peer.radius, now_});
  const double radius = params_.motion.person_radius;
  for (const perception::TrackedPerson& person : seen.people) {
    const Vec2 position = seen.pose.map_from_odom * person.position;
    route_.note_mover({"moving obstacle " + std::to_string(person.id), position, radius, now_,
                       free_cells_near(seen.map, position, (1.0 + kFarthestGone) * radius)});
  }
}

std::string PathNavigator::and_who_is_near(std::string_view reason) const {
  std::string text(reason);
  const Mover* mover =
      mover_near(progress_.pose.position(), route_.movers(), params_.route.mover_distance + body_radius_);
  return mover == nullptr ? text : text + "; near it is " + to_string(*mover);
}

// One look may be wrong: what is so must have been so for a while.
bool PathNavigator::holds(Claim& claim, bool now) const {
  if (now && !claim.made) claim.since = now_;
  claim.made = now;
  return now && now_ - claim.since > params_.motion.proof;
}

// Has the robot stayed where it is for too long?
bool PathNavigator::stuck() {
  const bool moved = distance(progress_.pose.position(), motion_.last_moved.position()) > params_.motion.moved ||
                     std::fabs(wrap_angle(progress_.pose.theta - motion_.last_moved.theta)) > params_.motion.moved_turn;
  if (moved) mark_moved();
  return follower_.trapped() || now_ - motion_.last_moved_at > params_.motion.stuck_after;
}

// Not the same way again nor, after a second failure, to explore the same place; a blocked turn blames no place.
Decision PathNavigator::get_unstuck() {
  recovery_.begin(now_, odom_from_base_, progress_.pose.position());
  progress_.recovery = recovery_.state();
  if (recovery_.state() == Recovery::State::given_up)
    return finish(Reason::blocked, and_who_is_near(recovery_.reason()));
  const bool exploring = std::holds_alternative<Explore>(goal_);
  const bool end_too = exploring && recovery_.attempts() >= 2;
  const bool again = lidar_ && !exploring && recovery_.attempts() >= creep_after_;
  const bool tight = again && route_.squeeze_ahead(progress_.pose.position());
  if (!tight && !follower_.trapped() && route_.avoid_ahead(end_too)) recovery_.forget_attempts();
  route_.drop();
  follower_.forget_turn();
  return {};
}

Decision PathNavigator::recover(const Observation& seen) {
  const Velocity velocity = step_recovery(seen);
  const bool creep_mode = lidar_ && recovery_.creep_mode();
  if (recovery_.state() != Recovery::State::replanning) return {velocity, Reason::running, {}, creep_mode};
  recovery_.end();
  mark_moved();
  motion_.tight_until = now_ + params_.motion.tight_for;
  return {};
}

// Turns round itself to look; what has been recognised until some time after that, or has not, decides.
Decision PathNavigator::find_itself(const Observation& seen) {
  if (!motion_.lost) recovery_.look_round(now_, odom_from_base_);
  motion_.lost = seen.pose.lost();
  if (!seen.pose.lost()) {
    recovery_.end();
    route_.drop();
    return wait();
  }
  if (recovery_.state() == Recovery::State::replanning) recovery_.end(), motion_.looked_round = now_;
  if (recovery_.active()) return {step_recovery(seen)};
  if (now_ - motion_.looked_round <= params_.motion.lost_patience) return wait();
  return finish(Reason::lost, "no place in the map fits what is seen");
}

}  // namespace threewe::nav
