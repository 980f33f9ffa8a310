// Parameters of localization and mapping: every tuned number, with the reference robot's values.
#pragma once

#include <memory>

#include "core/exact.hpp"
#include "core/parameters.hpp"
#include "threewe/core/time.hpp"

namespace threewe::slam {

/// Values are those of `3we_standard_v2`; `parameters_of` says what each means and what it grows with.
struct Params {
  double map_resolution = 0.05;  // [m]
  /// Cells of maps of few scans, metres apart: wide enough for two hits of one of them.
  double coarse_resolution() const { return 2.0 * map_resolution; }

  /// DeadReckoning.
  struct DeadReckoning {
    Duration sample_age = 100ms;
    Duration extrapolation = 300ms;
    double disagreement = 0.004;         // [rad]
    double turning_disagreement = 0.02;  // [rad/rad]
    int standing_samples = 10;
  };
  DeadReckoning dead_reckoning;

  /// PoseFilter: random errors of dead reckoning beyond its systematic ones.
  struct Filter {
    double forward_slip = 0.015 * 0.015;  // [m^2/m]
    double lateral_slip = 0.03 * 0.03;    // [m^2/m]
    double turn_slip = 0.01;              // [m/sqrt(rad)]
    double gyro_scale = 0.002;            // [rad/sqrt(rad)]
    double wheel_turn = 0.05;             // [rad/sqrt(rad)]
    double scale_walk = 1e-4;             // [1/sqrt(m)]
    double range_walk = 1e-4 * 1e-4;      // [m^2/m]
    double scan_position = 0.0005;        // [m]
    double scan_heading = 0.0002;         // [rad]
    double bias_creep = 0.004;            // [rad/s]
    double bias_jump = 5.0;               // standard deviations
  };
  Filter filter;

  /// Scan matcher.
  struct Matching {
    double residual = 0.025;         // [m]
    double robust_width = 0.06;      // [m]
    double usual_noise = 0.012;      // [m]
    double reach = 3.0;              // times the scatter
    double spot_size = 0.015;        // [m]
    double surface_distance = 0.10;  // [m]
    double viewing_angle = 0.3;      // [rad]
    double observed = 10.0;          // times
    double free_position = 0.3;      // [m]
    double free_heading = 0.1;       // [rad]
    double free_bias = 0.001;        // [m]
  };
  Matching matching;

  /// What a scan is made of.
  struct Beams {
    double free_no_return = 4.0;  // [m]
    double narrow = 0.12;         // [m]
    double behind = 0.15;         // [m]
    double in_front = 0.05;       // [m]
    double most_spacing = 1.0;    // [m]
    double flat = 0.06;           // [m]
  };
  Beams beams;

  /// FrontEnd: search around the prediction, and whether a scan fits.
  struct Registration {
    double poor_agreement = 0.6;
    double good_agreement = 0.7;
    double least_agreement = 0.45;
    int few_hits = 30;
    double known_share = 0.5;
    double few_known_share = 0.2;
    double through_walls = 0.35;
    double before_wall = 0.25;     // [m]
    double search_position = 0.3;  // [m]
    double search_heading = 0.15;  // [rad]
    double widest_position = 0.6;  // [m]
    double widest_heading = 0.35;  // [rad]
    double unsure_heading = 0.05;  // [rad]
    double better_poor = 0.15;
    double better = 0.02;
    double pushed = 0.04;       // [m]
    double pushed_turn = 0.02;  // [rad]
    double fading = 0.02;
    double poor_lidar = 1.2;     // times
    double least_noise = 0.005;  // [m]
  };
  Registration registration;

  /// When the map takes a scan.
  struct Mapping {
    double distance = 0.08;  // [m]
    double turn = 0.07;      // [rad]
    Duration age = 1s;
    double free_range = 8.0;  // [m]
  };
  Mapping mapping;

  /// OdometryCheck: a robot goes on about as it did. A step of the odometry that differs by more is doubted, and if it
  /// would take speeds that no robot between walls has, nothing but a scan that fits there makes it believed.
  struct OdometryCheck {
    double jump = 1.0;            // [m]
    double turn_jump = 0.8;       // [rad]
    double most_speed = 5.0;      // [m/s]
    double most_turn_rate = 6.0;  // [rad/s]
    Duration shortest_interval = 500ms;
    double most_extrapolation = 2.0;  // times the interval before
    double steady_distance = 0.05;    // [m]
    double steady_turn = 0.06;        // [rad]
    double steady_share = 0.5;
    double moved = 0.02;   // [m]
    double turned = 0.01;  // [rad]
    double moved_chi = 25.0;
    double frozen_distance = 0.3;  // [m]
    double frozen_turn = 0.2;      // [rad]
    double usual_share = 0.1;
    double least_of_usual = 0.65;
    int most_misfits = 3;
    double compared_distance = 0.5;  // [m]
    double scale_distance = 5.0;     // [m]
    double scaled = 0.1;
  };
  OdometryCheck odometry_check;

  /// LocalMap.
  struct LocalMap {
    double length = 20.0;  // [m]
    double overlap = 5.0;  // [m]
  };
  LocalMap local_map;

  /// Localizer: when the pose is lost, and how well it is known at first.
  struct Localization {
    Duration blind_after = 500ms;
    Duration start = 1s;
    Duration lost_after = 2s;
    Duration lost_at_once_after = 1s;
    double lost_agreement = 0.35;
    double doubtful_prior = 0.75;
    double certain_prior = 0.80;
    double doubt_share = 0.05;
    double initial_position = 0.25;  // [m]
    double initial_heading = 0.15;   // [rad]
    double found_position = 0.1;     // [m]
    double found_heading = 0.05;     // [rad]
    double redrawn_position = 0.02;  // [m]
    double redrawn_heading = 0.004;  // [rad]
    double prior_position = 0.02;    // [m]
    double prior_heading = 0.006;    // [rad]
  };
  Localization localization;

  /// OnlineMap: what a closed loop has drawn anew.
  struct OnlineMap {
    double redraw_distance = 0.025;  // [m]
    double redraw_arm = 5.0;         // [m]
  };
  OnlineMap online_map;

  /// MapUncertainty. Fitted to ten-minute drives in all scenes, with plain and with bad sensors, by verify_trajectory
  /// on seeds from 1000000 on: so that mean squared errors over these covariances are as alike as may be.
  struct MapUncertainty {
    double propagated = 2.65;
    double position = 0.003;  // [m]
    double heading = 0.0009;  // [rad]
    double stretch = 0.0005;
    double first_view = 0.3;        // [m]
    double usual_noise = 0.0115;    // [m]
    double least_noise = 0.5;       // times usual_noise
    double motion_position = 0.04;  // [m]
    double motion_heading = 0.006;  // [rad]
    double apart = 1.0;             // [m]
    double near = 1.5;              // [m]
    double way = 4.0;               // [m]
  };
  MapUncertainty map_uncertainty;

  /// KeyframeGraph. In the surveys of `threewe slam synth` the front end drifts by 5 mm and 1.5 mrad from keyframe to
  /// keyframe, by 50 mm and 2 mrad over 40 m; with real scanners, whose scans were a metre apart, by 60 mm and 11 mrad
  /// over 10 m, and by 120 mrad over the 180 m of a first loop. Who expects less does not look where the robot is.
  struct Graph {
    double drift = 0.020 * 0.020;      // [m^2/m]
    double turn_drift = 0.0050;        // [rad/sqrt(m)]
    double least_drift = 0.004;        // [m]
    double least_turn_drift = 0.0015;  // [rad]
    double keyframe_distance = 1.0;    // [m]
    double keyframe_turn = 0.7;        // [rad]
    double turning = 0.3;              // [m/rad]
    double scan_distance = 0.3;        // [m]
    double scan_turn = 0.2;            // [rad]
    double submap_length = 10.0;       // [m]
    double free_range = 4.0;           // [m]
    double resumed_position = 0.5;     // [m]
    double resumed_heading = 0.2;      // [rad]
    double solve_distance = 10.0;      // [m]
    double solve_chi = 4.0;
    double same_way = 1.0;          // [m]
    double same_way_heading = 0.8;  // [rad]
    int ways = 5;
  };
  Graph graph;

  /// Where KeyframeGraph looks for loops.
  struct Loops {
    double near = 3.0;            // [m]
    double far = 20.0;            // [m]
    double try_again = 3.0;       // [m]
    double view_length = 4.0;     // [m]
    double view_distance = 0.9;   // [m]
    double unsure = 1.0;          // [m]
    double same_position = 0.1;   // [m]
    double same_heading = 0.02;   // [rad]
    double found_position = 0.2;  // [m]
    double found_heading = 0.07;  // [rad]
  };
  Loops loops;

  /// LoopCloser: what makes a loop closure.
  struct LoopCloser {
    double least_reach = 0.3;   // [m]
    double most_reach = 10.0;   // [m]
    double least_turn = 0.1;    // [rad]
    double least_score = 0.55;  // Hess et al. 2016
    double distinct = 0.85;
    double agreement = 0.80;
    int known_hits = 40;
    double most_deviation = 0.05;  // [m]
    double most_chi = 16.0;
    double floor = 0.02;        // [m]
    double turn_floor = 0.003;  // [rad]
  };
  LoopCloser loop_closer;

  /// GlobalLocalizer and BranchAndBoundMatcher.
  struct GlobalSearch {
    double view_distance = 0.3;  // [m]
    double view_turn = 0.5;      // [rad]
    double good_score = 0.65;
    double least_score = 0.50;
    double lead = 0.10;
    double elsewhere_position = 0.5;             // [m]
    double elsewhere_heading = exact::kPi / 12;  // [rad]
    double confirm_position = 0.2;               // [m]
    double confirm_heading = 0.1;                // [rad]
    int confirmations = 3;
    Duration period = 200ms;
    Duration longest_pause = 4s;
  };
  GlobalSearch global_search;

  /// ObstaclePoints.
  struct Obstacles {
    double blur = 0.03;           // [m]
    double neighbourhood = 0.08;  // [m]
    double same = 0.01;           // [m]
  };
  Obstacles obstacles;
};

/// All of them, as "matching.residual" and so on.
Parameters parameters_of(Params& params);

/// A resolution [m] of 5 cm times a power of two, since costs and costmaps go by cells: two thirds to four thirds of
/// the one that was asked for. Within the limits of a map's cells.
double rounded_resolution(double resolution);

/// Shared, since many parts of a localizer have the same.
using SharedParams = std::shared_ptr<const Params>;
/// Those of the reference robot.
SharedParams reference_params();

}  // namespace threewe::slam
