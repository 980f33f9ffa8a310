// Tuned parameters of the navigator, one aggregate for each of its parts. Defaults are those of the reference robot.
#pragma once

#include "core/parameters.hpp"
#include "threewe/core/grid_index.hpp"
#include "threewe/core/time.hpp"

namespace threewe::nav {

/// All parameters of the navigator, in metres, radians and seconds. What each does, and what it grows with, stands in
/// `parameters_of`; `params_for<Params>(profile, "nav")` gives those of a robot.
struct Params {
  /// How fast and how near it moves in tight places.
  struct Creep {
    double speed = 0.04;          ///< [m/s] where less than the margin is free
    double corner_speed = 0.01;   ///< [m/s] of the corners there, by turning
    double margin = 0.004;        ///< [m] kept free there
    double free_speed = 0.1;      ///< [m/s] in a tight place, where the margin is free
    double free_turn_rate = 0.5;  ///< [rad/s] the same
    double progress = 0.01;       ///< [m] less than this, it does not get on
    double encroachment = 0.005;  ///< [m] what is nearer than the margin may come so much nearer, no more
  };
  /// How far from obstacles plans keep.
  struct Clearance {
    double spare = 0.01;    ///< [m] beyond half of the width, in which no path leads
    double caution = 0.25;  ///< [m] beyond that, in which paths are dearer
    int weight = 16;        ///< how much dearer they are at most, in quarters
  };
  /// Plans to goals, and what is remembered of places.
  struct Route {
    int unknown_weight = 2;       ///< how much dearer unknown space is, in quarters
    double sight = 0.75;          ///< of the lidar's range, within which a wall tells where the robot is
    int blind_weight = 6;         ///< how much dearer paths are without a wall in sight, in quarters
    double waypoint = 0.15;       ///< [m] nearer than this a waypoint is passed
    double horizon = 4.0;         ///< [m] beyond the map, where plans end
    double better = 0.85;         ///< share of an open path's cost that a new one must cost to replace it
    double driven_spacing = 0.1;  ///< [m] between the places that the robot remembers to have been at
    double mover_distance = 0.8;  ///< [m] between the outline and a mover that may be what is in the way
    double ahead = 0.25;          ///< [m] along the path to the place that is avoided after a failure
    double entrance = 1.5;        ///< [m] from a place that failed to the unknown space behind it
    int attempts = 3;             ///< failures in one place, then it is given up
    Duration retry = 200ms;       ///< from plan to plan where there is no path
    Duration replan = 1s;         ///< from plan to plan, on the way to a goal
    Duration explore = 600ms;     ///< the same on the way to a frontier
    double near_frontier = 0.25;  ///< [m] from a frontier, plans are made as often as without a path
  };
  /// What a frontier is worth, in metres of way through free space.
  struct Frontier {
    double least_length = 0.3;  ///< [m] smaller ones are not worth a drive
    double gain = 0.5;          ///< of each metre of its length ...
    double longest = 3.0;       ///< [m] ... up to so many
    double stay = 1.0;          ///< [m] for the one that the robot is on the way to
    double claimed = 8.0;       ///< [m] less where another robot comes first
    double claim = 3.0;         ///< [m] around where that is bound for
    double same = 1.0;          ///< [m] around a frontier, what has become of it
    double strip = 0.1;         ///< [m] wide must be the unknown floor behind one, spread along the way there
    double view = 4.0;          ///< times the square of its length is what counts of that
    double slit = 0.1;          ///< [m] to all sides of an unknown cell, where half must be unknown, or it is none
  };
  /// Paths through bottlenecks that may be just wide enough.
  struct Bottleneck {
    double coarseness =
        0.06;  ///< [m] by which cells may make a bottleneck look narrower, and paths keep from walls even so
    double straight = 0.03;         ///< [m] off the line, along which it still is one bottleneck
    double shortest = 0.15;         ///< [m] of half a bottleneck: that of less could be anywhere
    Duration patience = 180s;       ///< to try bottlenecks, and again once one has been passed
    Duration first_patience = 60s;  ///< to try one, and the time to drive there ...
    double ahead = 0.6;             ///< [m] from where the robot got stuck to the bottleneck that is blamed
    Duration hesitation = 800ms;    ///< without coming nearer, before a place ahead is measured
    double passing = 30.0;          ///< [s] to line up, measure, and creep through ...
    double sight = 1.5;             ///< [m] around the robot, hits are cleared of noise
    double flat = 0.08;             ///< [m] around each hit, surfaces are flat: noise is averaged over them
    double before = 0.08;           ///< [m] from where it lines up, the passage begins
  };
  /// When a motion makes no progress.
  struct Progress {
    double nearer = 0.1;       ///< [m] by which the path must have become shorter
    Duration patience = 120s;  ///< for recovery, narrow passages, and people who stand about
    double detour = 2.0;       ///< times what the rest of the path takes
    double mean_speed = 0.4;   ///< share of the speed limit at which a robot covers ground, all in all
  };
  /// When a motion has arrived, is stuck, or cannot be done.
  struct Motion {
    double spare = 0.01;             ///< [m] kept free beyond the safety gate's margin ...
    Duration tight_for = 6s;         ///< ... but not for so long after it got stuck
    double arrived = 0.02;           ///< [m] near enough to a goal to stop
    double path_end = 0.05;          ///< [m] the same, to the end of a path that leads no nearer
    double turned = 0.015;           ///< [rad] the same, of a turn
    double last = 0.2;               ///< [m] before the end, where it may be too tight for sampled plans
    Duration stuck_after = 2500ms;   ///< without having moved ...
    double moved = 0.06;             ///< [m] ... or turned ...
    double moved_turn = 0.3;         ///< [rad] ... by this
    Duration proof = 2500ms;         ///< for so long no plan may exist before it is believed
    Duration lost_patience = 8s;     ///< after having looked round
    Duration courtesy = 15s;         ///< for a mover in the only way to go on
    Duration map_patience = 1s;      ///< for a first scan
    int creep_after = 2;             ///< attempts in one place, one more for who does not see what is next to it
    double person_radius = 0.2;      ///< [m]
    double zone_reaction = 0.2;      ///< [s] from a command to its effect, and some for doubts about the pose
    double border_sight = 2.5;       ///< [m] so near, borders of zones count
    double sweep_angle = 1.0;        ///< [rad] to either side, to which robots without a lidar look
    Duration sweep_period = 4500ms;  ///< of that, there and back
    double prior_time = 3.0;         ///< [s] for which the expected speed counts, among those driven
    double expected_speed = 0.75;    ///< share of the limits
  };
  /// Following a path.
  struct Follower {
    double reaction = 0.12;   ///< [s] from a command to its effect
    double horizon = 1.2;     ///< [s] looked ahead along a motion
    double step = 0.02;       ///< [m] between the poses that are tried; lattices and obstacle fields are as fine
    double thinning = 0.015;  ///< [m] obstacles nearer to each other than that are one
    double faced = 0.3;  ///< [m] along the path, to where a robot turns before it drives, and plans without search lead
    double turn_first = 0.8;        ///< [rad] beyond which it turns on the spot ...
    double turn_done = 0.2;         ///< [rad] ... until the target is this straight ahead
    double turn_blocked = 0.2;      ///< share of its speed, slower than which a turn leads nowhere
    double lookahead = 0.45;        ///< [m] of pure pursuit
    double position_gain = 1.5;     ///< [1/s] speed for each metre off a line or from an end, turn rate likewise
    double heading_gain = 2.5;      ///< [1/s] turn rate for each radian off, along a path ...
    double line_convergence = 0.5;  ///< [m] of way in which a differential base comes back to its line
    double blind_speed = 0.25;      ///< [m/s] of robots without a lidar
    double escape_speed = 0.4;      ///< share of the speed limit when backing off
    double least_speed = 0.03;      ///< share of a velocity, less than which is none
    double least_turn_rate = 0.08;  ///< [rad/s] of a turn on the spot
    double braking = 0.6;           ///< share of what the brakes can do, counted on before obstacles ...
    double gentle_braking = 0.2;    ///< ... used before goals ...
    double gentle_turn_braking = 1.0 / 3.0;  ///< ... and before headings
  };
  /// Recovery behaviours.
  struct Recovery {
    double same_place = 0.4;    ///< [m] attempts, failures and bottlenecks nearer to each other are in the same place
    int attempts = 8;           ///< in one place
    int look_from = 3;          ///< which attempt in one place is the first to look
    Duration clearing = 300ms;  ///< longer than a turn of a lidar takes to arrive
    Duration backing_off = 2500ms;    ///< at most
    Duration arc_escape = 90s;        ///< at most
    Duration looking = 5s;            ///< at most for one direction
    double backing_distance = 0.15;   ///< [m] the first time ...
    double more_each_time = 0.1;      ///< [m] ... and so much more each time
    double look = 0.8;                ///< [rad] to both sides
    double looked = 0.1;              ///< [rad] near enough
    double backtrack_spacing = 0.03;  ///< [m] between the poses of the way it came
    double backtrack_passed = 0.05;   ///< [m] near enough to one of them
  };
  /// Narrow passages.
  struct NarrowPassage {
    double offset = 0.12;         ///< [m] to either side that the middle may be
    double sight = 0.5;           ///< [m] to either side that is looked at
    double turn = 0.6;            ///< [rad] to either side that the direction may be
    double gain = 0.05;           ///< of what a look shows: a scan is looked at five times
    double least_spare = 0.012;   ///< [m] beyond the robot's width without which nothing goes ...
    double most_spare = 0.3;      ///< [m] ... and with which it is no narrow passage
    Duration measuring = 1500ms;  ///< at least
    Duration patience = 5s;       ///< to line up, and without ...
    int attempts = 3;             ///< then it is closed
    double in_line = 0.01;        ///< [m] before it enters
    double aligned = 0.03;        ///< [rad] the same
    double askew = 0.3;           ///< [rad] with which there is no entering
    double room_to_turn = 0.06;   ///< [m] ahead of the robot as it lines up
    double room_before = 0.1;     ///< [m] by which it may begin earlier than the map says
    double convergence = 0.08;    ///< [m] of way in which a differential base comes back to its line
  };
  /// Arcs out of places too tight to turn in.
  struct Arcs {
    double radius = 0.25;           ///< [m] of most arcs; others bend three times as sharply, or a good third
    double reach = 1.2;             ///< [m] it looks so far
    double room = 0.02;             ///< [m] more than a turn takes, where a plan ends
    double encroachment = 0.003;    ///< [m] what is nearer may come so much nearer, until it touches
    double haste = 1.5;             ///< times the estimate: plans may be so much slower than the quickest
    double change = 1.0;            ///< [s] for going back where it went ahead, and the other way round
    int plans = 12;                 ///< at most
    Duration replan = 100ms;        ///< from plan to plan
    double tolerance_step = 0.001;  ///< [m] by which hits may be nearer than what they are of, more each time
    Duration patience = 1500ms;     ///< without ...
    double turned = 0.03;           ///< [rad] ... or this
    double convergence = 0.05;      ///< [m] of way in which a heading is put right
  };
  /// Model predictive path integral control. More samples, or more plans a second, bring a robot nowhere sooner or more
  /// surely (docs/decisions/0014-model-predictive-control.md).
  struct Mppi {
    /// What each critic's price weighs, in units of length and speed that grow with the robot. All prices of a plan
    /// are added up; 1 m of the path that is left costs 3 at each of 14 looks.
    struct Weights {
      double unit_of_length = 1.0;  ///< [m] that prices of places are counted in
      double unit_of_speed = 1.0;   ///< [m/s] that prices of speeds are counted in, and in a second ways ahead
      double path_left = 3.0;       ///< of a unit of the path that is left, and to its end where that is within reach
      double path_offset = 2.0;     ///< of the square of the offset from the path
      double goal_speed = 2.0;      ///< of the square of the speed there
      double obstacle_contact = 60.0;  ///< of an outline nearer than the margin
      double obstacle_depth = 1000.0;  ///< and more, the deeper
      double obstacle_close = 0.1;     ///< of an outline at the margin, none `obstacle_reach` beyond it
      double obstacle_braking =
          160.0;  ///< and more, of a unit that it takes to brake from the speed of its body and corners
      double heading_along = 0.5;      ///< of not facing along the path
      double heading_sideways = 20.0;  ///< of the square of sideways speed beyond `sideways_free`
      double heading_backward = 1.0;   ///< of the square of a speed against the way it is to go
      double heading_turn = 3.0;       ///< [1/rad] of what is left of a turn on the spot
      double smooth_linear = 1.0;      ///< of the square of changes of velocity
      double smooth_angular = 0.1;     ///< [s^2/rad^2] the same
      double people_contact = 100.0;   ///< of a unit of speed where an outline's disc meets one that moves
      double people_close = 1.0;       ///< the same next to it, none `people_reach` beyond it
    };
    int samples = 512;             ///< a multiple of 16 is rolled out: the next one
    double step = 0.05;            ///< [s] of a plan, which has 56
    int periods = 5;               ///< control periods from one plan to the next; it is followed in between
    double temperature = 0.05;     ///< samples that cost so much more count e times less
    double control_cost = 0.02;    ///< of steering away from the plan before, in temperatures
    double linear_noise = 0.15;    ///< [m/s] standard deviation
    double angular_noise = 0.5;    ///< [rad/s] standard deviation
    double sideways_free = 0.15;   ///< [m/s] a mecanum base slips least surely sideways: slowly it may
    double backward_speed = 0.5;   ///< share of its speed that a differential base may drive backwards
    double obstacle_reach = 0.05;  ///< [m] beyond the margin
    double people_reach = 0.25;    ///< [m] beyond contact
    double people_blur = 0.05;     ///< [m] around people, hits are theirs
    double stray = 0.35;           ///< [m] off its path, that a plan may lead and know of obstacles
    Weights weights{};
  };

  Creep creep{};
  Clearance clearance{};
  Clearance sonar_clearance{.spare = 0.04, .caution = 0.35, .weight = 32};  ///< sonar returns are less exact
  Route route{};
  Frontier frontier{};
  Bottleneck bottleneck{};
  Progress progress{};
  Motion motion{};
  Follower follower{};
  Recovery recovery{};
  NarrowPassage narrow_passage{};
  Arcs arcs{};
  Mppi mppi{};
};

Parameters parameters_of(Params::Creep& creep);
Parameters parameters_of(Params::Clearance& clearance);
Parameters parameters_of(Params::Route& route);
Parameters parameters_of(Params::Frontier& frontier);
Parameters parameters_of(Params::Bottleneck& bottleneck);
Parameters parameters_of(Params::Progress& progress);
Parameters parameters_of(Params::Motion& motion);
Parameters parameters_of(Params::Follower& follower);
Parameters parameters_of(Params::Recovery& recovery);
Parameters parameters_of(Params::NarrowPassage& narrow_passage);
Parameters parameters_of(Params::Arcs& arcs);
Parameters parameters_of(Params::Mppi& mppi);
Parameters parameters_of(Params::Mppi::Weights& weights);
/// All of them, as "part.field".
Parameters parameters_of(Params& params);

/// The whole number of cells of size `cell` [m] that is nearest to a length [m].
inline int cells_in(double length, double cell) { return to_cell(length / cell + 0.5); }

}  // namespace threewe::nav
