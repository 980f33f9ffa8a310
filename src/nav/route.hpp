// The way to where the robot wants to be, kept up to date while the map grows.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "map/costmap.hpp"
#include "nav/grid_search.hpp"
#include "nav/mover.hpp"
#include "nav/params.hpp"
#include "nav/planner.hpp"
#include "nav/route_memory.hpp"
#include "threewe/hardware/profile.hpp"
#include "threewe/nav/navigator.hpp"

namespace threewe::nav {

/// Where a path is too narrow for plans that keep their distance: it leads along the x axis of `map_from_middle`, half
/// of it [m] on either side.
struct Bottleneck {
  Pose2D map_from_middle;
  double half_length = 0.0;
};

/// Waypoints, a path through them, and what was learned about places that cannot be passed. All in `map`.
class Route {
 public:
  Route(const map::Costmap::Settings& costmap, const RobotProfile& profile, const Params& params);

  /// Begins anew, through `waypoints`; along the straight lines between them where those are free, if `drawn`.
  void begin(std::vector<Vec2> waypoints, bool drawn);

  /// A peer or a moving obstacle is here. What closes near it is open again when it has gone: that is held against no
  /// place.
  void note_mover(Mover mover) { memory_.note_mover(std::move(mover)); }
  /// Where movers have been in this motion, the newest last.
  std::span<const Mover> movers() const { return memory_.movers(); }
  /// Where plans may not lead, or better not, at a speed [m/s] elsewhere.
  void set_zones(const std::vector<map::Zone>& zones, double speed);
  /// Plans through the waypoints that are left, to within `tolerance` [m] of each. False: everything within reach was
  /// searched. A path that is open is kept unless a new one is clearly better, so that the robot does not waver.
  bool plan_to_goal(const Observation& seen, double tolerance);
  /// The same, once there is no other way, through gaps that may be just wide enough, on a path of at most `longest`
  /// [m]: cells are too coarse to tell.
  bool plan_through_gaps(const Observation& seen, double tolerance,
                         double longest = std::numeric_limits<double>::infinity());
  /// A path has turned out to be blocked, and the one planned instead may be longer by more than `detour` [m].
  bool is_detour(double detour) const;
  /// The same where that is so. False: the path stays what it was.
  bool plan_shortcut(const Observation& seen, double tolerance, double detour);
  /// The first of these on a path to the goal that would be open without them; empty where there is no path then
  /// either.
  std::optional<Mover> mover_in_the_way(const Observation& seen, double tolerance) const;
  /// The first such gap of the path.
  const std::optional<Bottleneck>& bottleneck() const { return bottleneck_; }
  /// Plans to the frontier that is most worth it: by the cost of the way there, how much there is to see, what the goal
  /// says that the place is worth, and what other robots are about to see; not to another one than before unless that
  /// is clearly better. Ways that turned out to be closed more than once are tried again when there is nothing else.
  /// Unless it is `thorough`, those that are not worth the way are left out (nav/frontier_worth.hpp). False: none can
  /// be reached that is.
  bool plan_to_frontier(const Observation& seen, const Explore& goal);
  /// The same along ways through bottlenecks, as `plan_through_gaps` finds them, where it is worth a detour of that
  /// length [m] too.
  bool plan_to_frontier_through_gaps(const Observation& seen, const Explore& goal, double detour);
  /// The last plan to a frontier has left some out.
  bool left_some() const { return left_some_; }
  /// The robot could not go on, more than once. True where it is before a gap of the path: from now on that counts as
  /// a bottleneck.
  bool squeeze_ahead(Vec2 robot);
  /// The tight place of the path just ahead of the robot, unless it has been found closed.
  std::optional<Bottleneck> tight_place_ahead(Vec2 robot) const;
  /// It has been passed as far as it was straight; where it is still narrow it goes on.
  void leave_bottleneck(Vec2 robot);
  /// The bottleneck turned out to be none.
  void clear_bottleneck();
  /// It turned out to be closed. Is it too narrow, or has that been so too often, no plan of this motion leads there
  /// any more.
  void close_bottleneck(bool too_narrow);
  /// Forgets the path, so that the next plan is due at once.
  void drop();
  /// Forgets what lies behind the robot, waypoints included.
  void advance(Vec2 robot);
  /// The robot could not go on: plans avoid the place before it and, if `end_too`, the end of the path. Where it failed
  /// a few times to enter unknown space, or to come to a frontier, no plan of this motion leads any more; true when
  /// that has been decided.
  bool avoid_ahead(bool end_too);

  bool has_path() const { return !path_.empty(); }
  std::span<const Vec2> path() const { return path_; }
  /// [m] from the end of the path to the goal.
  double gap() const { return gap_; }
  bool on_last_leg() const { return waypoints_.size() <= 1; }
  const map::Costmap& costmap() const { return clear_.costmap; }

  /// There is no path, or the map has changed for `period` since the last plan.
  bool is_stale(const Observation& seen, Duration period) const;
  /// [ns] since the last plan; long before the first.
  Duration age(Time now) const { return planned_once_ ? now - planned_ : Duration::max(); }

 private:
  /// A costmap, and what belongs to it.
  struct Layer {
    map::Costmap costmap;
    Planner planner;
    std::optional<std::uint64_t> version;  // of our map, where the costmap has that alone
  };

  std::vector<Vec2> relevant_places(const Observation& seen) const;
  bool try_plan(Layer& layer, const Observation& seen, double tolerance);
  bool try_frontier(Layer& layer, const Observation& seen, const Explore& goal, double detour);
  template <class Plan>
  bool squeeze(const Observation& seen, double longest, Plan plan);
  int bonus_of_frontier(std::uint32_t index, const Observation& seen, const Explore& goal) const;
  void renew(Layer& layer, const Observation& seen);
  void take_map(Layer& layer, const Observation& seen, const std::vector<Vec2>& obstacles,
                const std::vector<Vec2>& include);
  double clearance(Vec2 place) const;
  double tight_clearance() const;
  bool is_lethal(Vec2 place) const;
  std::optional<Vec2> first_lethal() const;
  Time patience_with(const Bottleneck& neck, Time now);
  std::optional<Bottleneck> known_bottleneck() const;
  template <class Narrow>
  Bottleneck bottleneck_about(Vec2 place, Narrow narrow) const;
  bool avoid(Vec2 place);
  bool is_near_mover(Vec2 place) const;
  bool passed_waypoint(Vec2 robot) const;
  void note_closure();

  Params::Route params_;
  Params::Frontier frontier_params_;
  Params::Bottleneck bottleneck_params_;
  Layer clear_;            // of paths that keep their distance
  Layer squeezed_;         // of those through gaps
  GridSearch search_;      // for frontiers
  double body_radius_;     // [m] of a disc around the robot, where it evidently fits
  double margin_;          // [m] that the safety gate keeps free
  double approach_speed_;  // [m/s] at which it comes to bottlenecks, all in all
  double path_end_;        // [m] a path ends so much within the tolerance, for the robot may stop before its end
  double people_blur_;     // [m] around movers, hits are theirs
  double creep_speed_;     // [m/s] of movers that are not seen to move

  std::vector<Vec2> waypoints_;  // still to pass, the last is the goal
  bool drawn_ = false;
  std::vector<Vec2> path_;                 // from the robot on; empty while there is none
  std::vector<std::size_t> corners_from_;  // for each waypoint, how many corners of the path lie from there on
  double gap_ = 0.0;
  bool squeezed_path_ = false;  // it leads through gaps that other paths do not enter
  std::optional<Bottleneck> bottleneck_;
  bool planned_once_ = false;
  Time planned_{};
  std::uint64_t planned_version_ = 0;
  map::OccupancyGrid shared_;  // with what peers have mapped
  RouteMemory memory_;
  Time bottlenecks_until_{};  // they are tried
  std::vector<std::uint16_t> frontiers_;
  std::optional<Vec2> frontier_;  // [m] that it is on the way to
  bool left_some_ = false;        // frontiers that are not worth the way
};

}  // namespace threewe::nav
