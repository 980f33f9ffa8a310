#include "nav/arc_escape.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <queue>
#include <unordered_map>
#include <utility>

#include "core/exact.hpp"
#include "nav/room_field.hpp"

namespace threewe::nav {
namespace {

constexpr std::array<double, 7> kCurvatures = {0.0, 1.5, -1.5, 4.0, -4.0, 12.0, -12.0};  // [1/m]
constexpr double kStepWay = 0.04;                                                        // [m] of a step, or ...
constexpr double kStepTurn = 0.2;     // [rad] ... of one that turns more sharply
constexpr double kSpacing = 0.02;     // [m] between the poses of a step at which the outline is looked at ...
constexpr double kTurnSpacing = 0.1;  // [rad] ... or so much
constexpr double kCell = 0.02;        // [m] of the lattice
constexpr double kBin = 0.1;          // [rad] of the lattice
constexpr double kReach = 1.2;        // [m] it looks so far
constexpr double kScatter = 3.0;      // deviations of the nearest hit that a turn must leave room for ...
constexpr double kFarEnough = 0.02;   // [m] ... and more, where a plan ends
constexpr double kFree = 0.008;       // [m] kept free: more than the creeping gate does
constexpr double kNotNearer = 0.003;  // [m] what is nearer may come so much nearer, until it touches
constexpr double kThin = 0.015;       // [m] hits nearer to each other than that are one
constexpr double kRaster = 0.02;      // [m] by which the estimate's cells may look narrower than they are
constexpr double kHaste = 1.5;        // times the estimate: plans may be so much slower than the quickest, found sooner
constexpr int kMostExpansions = 10000;

// How quick a step is: as the gate lets a creeping robot go where less than the margin is free, faster elsewhere.
constexpr double kCreep = 0.04;         // [m/s]
constexpr double kCreepCorners = 0.01;  // [m/s] of the corners, by turning
constexpr double kQuick = 0.1;          // [m/s]
constexpr double kQuickTurn = 0.5;      // [rad/s]
constexpr double kChange = 1.0;         // [s] for going back where it went ahead, and the other way round

// One hit of many that lie close together.
std::vector<Vec2> thinned(std::span<const Vec2> hits, double reach) {
  std::vector<Vec2> few;
  for (const Vec2 p : hits) {
    if (dot(p, p) > reach * reach) continue;
    const auto is_same = [&](Vec2 q) { return dot(p - q, p - q) < kThin * kThin; };
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
        hits_(thinned(hits, kReach + planner.ends_at_)),
        field_(hits_, planner.least_room_, planner.ends_at_, kReach) {
    for (const Vec2 p : hits_) {
      const double now = planner_.outline_.clearance(p);
      least_.push_back(std::min(kFree, now > 0.0 ? std::max(now - kNotNearer, 0.0) : now) - tolerance);
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
      if (norm(pose.position()) < kReach) {
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

  static std::uint64_t key(const Pose2D& pose) {
    const auto cell = [](double v, double size) {
      const int number = static_cast<int>(std::floor(v / size + 0.5)) + 1024;
      return static_cast<std::uint64_t>(number);
    };
    return (cell(pose.x, kCell) * 4096 + cell(pose.y, kCell)) * 4096 + cell(pose.theta, kBin);
  }

  void add(const Pose2D& pose, int gear, double cost, int before, int primitive) {
    const auto [known, is_new] = known_.try_emplace(key(pose), static_cast<int>(nodes_.size()));
    if (!is_new) {
      Node& old = nodes_[index(known->second)];
      if (old.closed || old.cost <= cost) return;
      old.closed = true;  // superseded
      known->second = static_cast<int>(nodes_.size());
    }
    const double rest = kHaste * std::min(field_.way_from(pose.position()), 2.0 * kReach) / kQuick;
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
      const double cost = node.cost + planner_.seconds(step, *clear) + (changes ? kChange : 0.0);
      add(node.pose * step.poses.back(), gear, cost, from, static_cast<int>(i));
    }
  }

  // What a step could come near to, in the frame of the pose in which it begins.
  void gather(const Pose2D& pose) {
    near_.clear();
    const double reach = planner_.radius_ + planner_.margin_ + kStepWay;
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
  std::vector<Vec2> hits_;
  RoomField field_;
  std::vector<double> least_;  // [m] how near each may come
  std::vector<Near> near_;
  std::vector<Node> nodes_;
  std::unordered_map<std::uint64_t, int> known_;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open_;
};

ArcEscapePlanner::ArcEscapePlanner(const RobotProfile& profile)
    : outline_(profile.body.footprint),
      radius_(profile.body.footprint.circumscribed_radius()),
      margin_(profile.margin()),
      turns_from_(radius_ + margin_ + kScatter * (profile.lidar ? profile.lidar->sigma : 0.0)),
      ends_at_(turns_from_ + kFarEnough),
      least_room_(profile.body.footprint.inscribed_radius() - kRaster) {
  for (const double gear : {1.0, -1.0}) {
    for (const double curvature : kCurvatures) {
      const double way = std::min(kStepWay, kStepTurn / std::max(std::fabs(curvature), 1e-9));
      add_primitive({gear, 0.0, curvature}, way);
    }
  }
  for (const double turn : {1.0, -1.0}) add_primitive({0.0, 0.0, turn}, kStepTurn);
  if (profile.kinematics() == Kinematics::differential) return;
  const double diagonal = exact::sqrt(0.5);
  for (const double side : {1.0, -1.0}) {
    add_primitive({0.0, side, 0.0}, kStepWay);
    add_primitive({diagonal, side * diagonal, 0.0}, kStepWay);
    add_primitive({-diagonal, side * diagonal, 0.0}, kStepWay);
  }
}

void ArcEscapePlanner::add_primitive(const Velocity& direction, double seconds) {
  Primitive step;
  step.direction = direction;
  step.gear = direction.vx > 0.0 ? 1 : direction.vx < 0.0 ? -1 : 0;
  step.way = exact::hypot(direction.vx, direction.vy) * seconds;
  step.turn = std::fabs(direction.omega) * seconds;
  const int parts = std::max(1, static_cast<int>(std::ceil(std::max(step.way / kSpacing, step.turn / kTurnSpacing))));
  for (int i = 1; i <= parts; ++i) step.poses.push_back(integrate({}, direction, seconds * i / parts));
  primitives_.push_back(std::move(step));
}

double ArcEscapePlanner::seconds(const Primitive& step, double clearance) const {
  const double creep_mode = std::max(step.way / kCreep, step.turn * radius_ / kCreepCorners);
  const double quick = std::max(step.way / kQuick, step.turn / kQuickTurn);
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
  return std::ranges::any_of(hits_in_base, [&](Vec2 p) { return outline_.clearance(p) < margin_ + kStepWay; });
}

std::vector<ArcStep> ArcEscapePlanner::plan(std::span<const Vec2> hits_in_base, double tolerance) const {
  return Search(*this, hits_in_base, tolerance).run();
}

}  // namespace threewe::nav
