// Our navigator: what is asked for, a route to it, and the tracker that drives the route.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "nav/narrow_passage.hpp"
#include "nav/params.hpp"
#include "nav/path_follower.hpp"
#include "nav/progress_monitor.hpp"
#include "nav/recovery.hpp"
#include "nav/route.hpp"
#include "threewe/hardware/profile.hpp"
#include "threewe/nav/navigator.hpp"

namespace threewe::nav {

class PathNavigator final : public Navigator {
 public:
  /// With the parameters of the profile.
  explicit PathNavigator(const RobotProfile& profile);

  void start(const Goal& goal, const Observation& seen) override;
  Decision step(const Observation& observed) override;
  Progress progress() const override;
  std::span<const Vec2> path() const override { return route_.path(); }
  void set_zones(const std::vector<map::Zone>& zones) override;
  std::optional<SampledPlan> plan() const override { return route_.has_path() ? follower_.plan(now_) : std::nullopt; }
  std::unique_ptr<Navigator> clone() const override { return std::make_unique<PathNavigator>(*this); }

 private:
  /// Something that is believed once it has been so for a while.
  struct Claim {
    bool made = false;
    Time since{};
  };

  PathNavigator(const RobotProfile& profile, const Params& params);

  Decision decide(const Observation& seen);
  Decision drive(const MoveTo& goal, const Observation& seen);
  Decision drive(const Rotate& goal, const Observation& seen);
  Decision drive(const MoveForward& goal, const Observation& seen);
  Decision drive(const FollowPath& goal, const Observation& seen);
  Decision drive(const FollowWaypoints& goal, const Observation& seen);
  Decision drive(const Explore& goal, const Observation& seen);

  void begin_leg(std::vector<Vec2> points, bool along);
  void begin_waypoint(const FollowWaypoints& goal, std::size_t number);
  void note(const Observation& seen);
  void estimate_time_left();
  Velocity within_zones(const Velocity& velocity) const;
  Decision travel(const Observation& seen, Vec2 goal, double tolerance);
  Decision follow(const Observation& seen);
  std::vector<Vec2> blind_surface(const Observation& seen) const;
  std::vector<Vec2> smoothed_hits(const Observation& seen, double sight) const;
  bool plan_through_gaps(const Observation& seen, double tolerance);
  bool explore_through_gaps(const Observation& seen, const Explore& goal);
  double way_in(double seconds) const { return seconds * params_.motion.expected_speed * limits_.linear; }
  void plan_shortcut(const Observation& seen, double tolerance);
  Observation without_noise(const Observation& seen, std::vector<Vec2>& hits) const;
  std::vector<Vec2> way_to_bottleneck() const;
  Velocity follow_by_plan(const Observation& seen, std::span<const Vec2> path);
  bool is_before_bottleneck() const;
  bool hesitates();
  bool finds_passage(const Observation& seen);
  Decision begin_passage(const Observation& seen);
  Decision pass(const Observation& seen);
  std::vector<Vec2> borders_near(Vec2 robot) const;
  double sweep_angle() const;
  Decision wait();
  void mark_moved();
  Decision finish(Reason reason, std::string detail = {});
  Decision give_up_path(const Observation& seen, double tolerance);
  void remember_movers(const Observation& seen);
  std::string and_who_is_near(std::string_view reason) const;
  bool holds(Claim& claim, bool now) const;
  bool stuck();
  Decision get_unstuck();
  Decision recover(const Observation& seen);
  Velocity step_recovery(const Observation& seen);
  std::vector<Vec2> hits_around(const Observation& seen) const;
  bool leaves_first(const Observation& seen);
  Decision find_itself(const Observation& seen);

  /// What belongs to one motion.
  struct Motion {
    Pose2D start;  // in `odom`: no correction of the map is a motion
    Time started{};
    double turned = 0.0;     // [rad] since then
    double turn_left = 0.0;  // [rad] to turn at the end, as far as is known
    bool at_goal = false;    // only the heading is left
    std::size_t waypoint = 0;
    double rest = 0.0;  // [m] from this waypoint on, in straight lines
    Claim no_path;      // that keeps its distance
    Claim no_gap;       // leads on, either
    bool lost = false;
    Time looked_round{};  // when it had, lost
    Pose2D last_moved;    // where and when the robot last got on
    Time last_moved_at{};
    double least_left = 0.0;  // [m] of the path, since it was planned anew; and when that was
    Time least_left_at{};
    bool departed = false;  // from a tight place, before the proof that there is no path
    Time tight_until{};     // a smaller margin is enough until then
  };

  Params params_;
  Route route_;
  Limits limits_;
  double body_radius_;  // [m] of a disc around the body
  double margin_;       // [m] that the safety gate keeps free
  int creep_after_;     // attempts in one place
  std::vector<map::Zone> zones_;
  PathFollower follower_;
  Recovery recovery_;
  NarrowPassage narrow_passage_;
  ProgressMonitor monitor_;
  std::optional<Vec2> lidar_;  // [m] in the base frame
  double range_min_ = 0.0;     // [m] of the lidar
  Goal goal_;
  Motion motion_;
  Progress progress_;
  Time now_{};
  Pose2D odom_from_base_;
  std::vector<Vec2> in_base_;  // what the lidar sees
};

}  // namespace threewe::nav
