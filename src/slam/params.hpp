// Parameters of localization and mapping: every tuned number, with the reference robot's values.
#pragma once

#include <memory>

#include "core/parameters.hpp"
#include "threewe/core/time.hpp"

namespace threewe::slam {

/// Values are those of `3we_standard_v2`; `parameters_of` says what each means and what it grows with.
struct Params {
  double map_resolution = 0.05;  // [m]

  /// DeadReckoning.
  struct DeadReckoning {
    Duration gyro_age = 100ms;
    Duration extrapolation = 300ms;
    Duration silence = 100ms;
    double disagreement = 0.004;         // [rad]
    double turning_disagreement = 0.02;  // [rad/rad]
    int standing_samples = 10;
  };
  DeadReckoning dead_reckoning;

  /// PoseFilter: random errors of dead reckoning beyond its systematic ones.
  struct Filter {
    double forward_slip = 0.015;    // [m/sqrt(m)]
    double lateral_slip = 0.03;     // [m/sqrt(m)]
    double turn_slip = 0.01;        // [m/sqrt(rad)]
    double gyro_scale = 0.002;      // [rad/sqrt(rad)]
    double wheel_turn = 0.05;       // [rad/sqrt(rad)]
    double scale_walk = 1e-4;       // [1/sqrt(m)]
    double range_walk = 1e-4;       // [m/sqrt(m)]
    double scan_position = 0.0005;  // [m]
    double scan_heading = 0.0002;   // [rad]
    double bias_creep = 0.004;      // [rad/s]
    double bias_jump = 5.0;         // standard deviations
  };
  Filter filter;

  /// Scan matcher.
  struct Matching {
    double residual = 0.025;         // [m]
    double robust_width = 0.06;      // [m]
    double usual_noise = 0.012;      // [m]
    double spot_size = 0.015;        // [m]
    double surface_distance = 0.10;  // [m]
    double viewing_angle = 0.3;      // [rad]
    double observed = 10.0;          // times
  };
  Matching matching;

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
    double better = 0.1;
    double moved = 0.02;   // [m]
    double turned = 0.01;  // [rad]
    double moved_chi = 25.0;
    double free_position = 0.3;    // [m]
    double free_heading = 0.1;     // [rad]
    double free_bias = 0.001;      // [m]
    double frozen_distance = 0.3;  // [m]
    double frozen_turn = 0.2;      // [rad]
    int most_misfits = 3;
  };
  OdometryCheck odometry_check;

  /// LocalMap.
  struct LocalMap {
    double resolution = 0.10;  // [m]
    double free_range = 4.0;   // [m]
    double length = 20.0;      // [m]
    double overlap = 5.0;      // [m]
  };
  LocalMap local_map;

  /// Localizer: when the pose is lost, and how well it is known at first.
  struct Localization {
    Duration blind_after = 500ms;
    Duration start = 1s;
    Duration lost_after = 2s;
    Duration lost_at_once_after = 1s;
    double lost_agreement = 0.35;
    double doubtful_prior = 0.45;
    double certain_prior = 0.55;
    double doubt_share = 0.05;
    double better = 0.15;
    double told_position = 0.25;     // [m]
    double told_heading = 0.15;      // [rad]
    double found_position = 0.1;     // [m]
    double found_heading = 0.05;     // [rad]
    double redrawn_position = 0.02;  // [m]
    double redrawn_heading = 0.004;  // [rad]
    double prior_position = 0.02;    // [m]
    double prior_heading = 0.006;    // [rad]
  };
  Localization localization;

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

/// Shared, since many parts of a localizer have the same.
using SharedParams = std::shared_ptr<const Params>;
/// Those of the reference robot.
SharedParams reference_params();

}  // namespace threewe::slam
