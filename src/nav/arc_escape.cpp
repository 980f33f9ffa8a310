#include "nav/arc_escape.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <queue>
#include <unordered_map>
#include <utility>

#include "core/exact.hpp"
#include "nav/room_field.hpp"
#include "safety/params.hpp"

namespace threewe::nav {
namespace {

constexpr double kTurnStep = 0.2;  // [rad] of a step that turns more sharply; the lattice's bins are half of it
constexpr double kSigmas = 3.0;    // of the nearest hit's noise, that a turn must leave room for
constexpr int kMostExpansions = 10000;

// One hit of many that lie close together.
std::vector<Vec2> thinned(std::span<const Vec2> hits, double reach, double spacing) {
  std::vector<Vec2> few;
  for (const Vec2 p : hits) {
    if (dot(p, p) > reach * reach) continue;
    const auto is_same = [&](Vec2 q) { return dot(p - q, p - q) < spacing * spacing; };
    if (std::ranges::none_of(few, is_same)) few.push_back(p);
  }
  return few;
}

}  // namespace

/// Weighted A* (Pohl 1970); the estimate is the way of a disc within the outline.
class ArcEscapePlanner::Search {
 public:
  Search(const ArcEscapePlanner& planner, std::span<const Vec2> hits, double tolerance)
      : planner_(planner),
        params_(planner.params_),
        hits_(thinned(hits, params_.reach + planner.ends_at_, planner.thinning_)),
        field_(hits_, planner_.step_, planner.least_room_, planner.ends_at_, params_.reach) {
    const double free = 2.0 * planner_.creep_.margin;  // more than the creeping gate keeps
    for (const Vec2 p : hits_) {
      const double now = planner_.outline_.clearance(p);
      least_.push_back(std::min(free, now > 0.0 ? std::max(now - params_.encroachment, 0.0) : now) - tolerance);
    }
  }

  std::vector<ArcStep> run() {
    add({}, 0, 0.0, -1, -1);
    std::optional<int> on;  // the quickest way a metre on
    int widest = 0;
    for (int i = 0; i < kMostExpansions && !open_.empty(); ++i) {
      const int node = open_.top().second;
      open_.pop();
      if (nodes_[index(node)].closed) continue;
      nodes_[index(node)].closed = true;
      const Pose2D pose = nodes_[index(node)].pose;
      const double room = room_at(pose);
      if (room >= planner_.ends_at_) return steps_to(node);
      if (room > room_at(nodes_[index(widest)].pose)) widest = node;
      if (norm(pose.position()) < params_.reach) {
        expand(node);
      } else if (!on) {
        on = node;
      }
    }
    if (on) return steps_to(*on);
    return open_.empty() ? std::vector<ArcStep>{} : steps_to(widest);
  }

 private:
  struct Node {
    Pose2D pose;
    int gear = 0;
    double cost = 0.0;  // [s]
    int before = -1;
    int primitive = -1;
    bool closed = false;
  };
  static std::size_t index(int i) { return static_cast<std::size_t>(i); }

  double room_at(const Pose2D& pose) const { return planner_.room(hits_, pose.position()); }

  std::uint64_t key(const Pose2D& pose) const {
    const auto cell = [](double v, double size) {
      const int number = static_cast<int>(std::floor(v / size + 0.5)) + 1024;
      return static_cast<std::uint64_t>(number);
    };
    const double side = 0.5 * planner_.step_;
    return (cell(pose.x, side) * 4096 + cell(pose.y, side)) * 4096 + cell(pose.theta, 0.5 * kTurnStep);
  }

  void add(const Pose2D& pose, int gear, double cost, int before, int primitive) {
    const auto [known, is_new] = known_.try_emplace(key(pose), static_cast<int>(nodes_.size()));
    if (!is_new) {
      Node& old = nodes_[index(known->second)];
      if (old.closed || old.cost <= cost) return;
      old.closed = true;  // superseded
      known->second = static_cast<int>(nodes_.size());
    }
    const double rest =
        params_.haste * std::min(field_.way_from(pose.position()), 2.0 * params_.reach) / planner_.creep_.free_speed;
    open_.emplace(cost + rest, static_cast<int>(nodes_.size()));
    nodes_.push_back({pose, gear, cost, before, primitive});
  }

  void expand(int from) {
    const Node node = nodes_[index(from)];
    gather(node.pose);
    for (std::size_t i = 0; i < planner_.primitives_.size(); ++i) {
      const Primitive& step = planner_.primitives_[i];
      const std::optional<double> clear = clearance_along(step);
      if (!clear) continue;
      const bool changes = node.gear * step.gear < 0;
      const int gear = step.gear != 0 ? step.gear : node.gear;
      const double cost = node.cost + planner_.seconds(step, *clear) + (changes ? params_.change : 0.0);
      add(node.pose * step.poses.back(), gear, cost, from, static_cast<int>(i));
    }
  }

  // What a step could come near to, in the frame of the pose in which it begins.
  void gather(const Pose2D& pose) {
    near_.clear();
    const double reach = planner_.radius_ + planner_.margin_ + planner_.step_;
    const auto [s, c] = exact::sincos(pose.theta);
    for (std::size_t i = 0; i < hits_.size(); ++i) {
      const Vec2 d = hits_[i] - pose.position();
      if (dot(d, d) < reach * reach) near_.push_back({{c * d.x + s * d.y, c * d.y - s * d.x}, least_[i]});
    }
  }

  // [m] the least on the way, at most the margin; nothing where the step comes too near to a hit.
  std::optional<double> clearance_along(const Primitive& step) const {
    double least = planner_.margin_;
    for (const Pose2D& pose : step.poses) {
      const auto [s, c] = exact::sincos(pose.theta);
      for (const Near& it : near_) {
        const Vec2 d = it.at - pose.position();
        const double clear = planner_.outline_.clearance({c * d.x + s * d.y, c * d.y - s * d.x});
        if (clear < it.least) return {};
        least = std::min(least, clear);
      }
    }
    return least;
  }

  std::vector<ArcStep> steps_to(int node) const {
    std::vector<ArcStep> steps;
    for (int i = node; nodes_[index(i)].primitive >= 0; i = nodes_[index(i)].before) {
      steps.push_back({planner_.primitives_[index(nodes_[index(i)].primitive)].direction, nodes_[index(i)].pose});
    }
    std::ranges::reverse(steps);
    return steps;
  }

  struct Near {
    Vec2 at;
    double least;
  };
  using Entry = std::pair<double, int>;  // expected cost, node

  const ArcEscapePlanner& planner_;
  const Params::Arcs& params_;
  std::vector<Vec2> hits_;
  RoomField field_;
  std::vector<double> least_;  // [m] how near each may come
  std::vector<Near> near_;
  std::vector<Node> nodes_;
  std::unordered_map<std::uint64_t, int> known_;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open_;
};

ArcEscapePlanner::ArcEscapePlanner(const RobotProfile& profile, const Params& params)
    : params_(params.arcs),
      creep_(params.creep),
      thinning_(params.follower.thinning),
      step_(2.0 * params.follower.step),
      outline_(profile.body.footprint),
      radius_(profile.body.footprint.circumscribed_radius()),
      margin_(safety::margin_of(profile)),
      turns_from_(radius_ + margin_ + kSigmas * (profile.lidar ? profile.lidar->sigma : 0.0)),
      ends_at_(turns_from_ + params_.room),
      least_room_(profile.body.footprint.inscribed_radius() - 0.5 * step_) {
  for (const double gear : {1.0, -1.0}) {
    add_primitive({gear, 0.0, 0.0}, step_);
    for (const double bend : {0.375, 1.0, 3.0}) {
      const double curvature = bend / params_.radius;
      const double way = std::min(step_, kTurnStep / curvature);
      for (const double side : {1.0, -1.0}) add_primitive({gear, 0.0, side * curvature}, way);
    }
  }
  for (const double turn : {1.0, -1.0}) add_primitive({0.0, 0.0, turn}, kTurnStep);
  if (profile.kinematics() == Kinematics::differential) return;
  const double diagonal = exact::sqrt(0.5);
  for (const double side : {1.0, -1.0}) {
    add_primitive({0.0, side, 0.0}, step_);
    add_primitive({diagonal, side * diagonal, 0.0}, step_);
    add_primitive({-diagonal, side * diagonal, 0.0}, step_);
  }
}

void ArcEscapePlanner::add_primitive(const Velocity& direction, double seconds) {
  Primitive step;
  step.direction = direction;
  step.gear = direction.vx > 0.0 ? 1 : direction.vx < 0.0 ? -1 : 0;
  step.way = exact::hypot(direction.vx, direction.vy) * seconds;
  step.turn = std::fabs(direction.omega) * seconds;
  // the outline is looked at twice in a whole step
  const double share = std::max(step.way / step_, step.turn / kTurnStep);
  const int parts = std::max(1, static_cast<int>(std::ceil(2.0 * share)));
  for (int i = 1; i <= parts; ++i) step.poses.push_back(integrate({}, direction, seconds * i / parts));
  primitives_.push_back(std::move(step));
}

double ArcEscapePlanner::seconds(const Primitive& step, double clearance) const {
  const double creep_mode = std::max(step.way / creep_.speed, step.turn * radius_ / creep_.corner_speed);
  const double quick = std::max(step.way / creep_.free_speed, step.turn / creep_.free_turn_rate);
  const double share = std::clamp(clearance / margin_, 0.0, 1.0);
  return share * quick + (1.0 - share) * creep_mode;
}

// [m] from a place to the nearest hit, at most what a plan ends with.
double ArcEscapePlanner::room(std::span<const Vec2> hits, Vec2 place) const {
  double least = ends_at_ * ends_at_;
  for (const Vec2 p : hits) least = std::min(least, dot(p - place, p - place));
  return exact::sqrt(least);
}

bool ArcEscapePlanner::is_tight(std::span<const Vec2> hits_in_base) const {
  return std::ranges::any_of(hits_in_base, [&](Vec2 p) { return outline_.clearance(p) < margin_ + step_; });
}

std::vector<ArcStep> ArcEscapePlanner::plan(std::span<const Vec2> hits_in_base, double tolerance) const {
  return Search(*this, hits_in_base, tolerance).run();
}

}  // namespace threewe::nav
