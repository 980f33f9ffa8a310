// Tuned parameters of the perception of a robot: of the checks of its sensors, of people, sonar and bumps.
#pragma once

#include "core/parameters.hpp"
#include "threewe/core/time.hpp"

namespace threewe::perception {

/// The defaults are those of the reference robot; `params_for` gives a robot's own, as those of the module "health".
struct Params {
  /// When a sensor is at fault, and for how long.
  struct Monitor {
    Duration least_patience = 150ms;
    Duration first_patience = 1s;
    Duration ok_after = 300ms;
    Duration first_penalty = 1s;
    Duration longest_penalty = 8s;
    double contradiction = 4.0;
    double standing = 0.02;
    double standing_turn = 0.05;
    double turning = 0.15;
  };
  /// Of scans that are noisy or shifted.
  struct Scan {
    int fewest_beams = 40;
    double noisy = 3.0;
    double follows = 0.02;
    double shift = 0.10;
    double agree = 0.06;
    double most_beams = 0.4;
    double back = 0.4;
    Duration believed_after = 30s;
  };
  /// Of sectors in which a lidar is blind.
  struct Blind {
    double near = 0.1;
    double bearing = 0.15;
  };
  /// Of the times of samples.
  struct Stamps {
    Duration younger = 50ms;
    Duration older = 200ms;
    int follows = 32;
    int first = 5;
  };
  /// Of readings that repeat themselves.
  struct Repeats {
    int lively = 4;
    int lively_on_way = 6;
    double noise = 0.001;
    double slope = 0.1;
    double steep = 0.02;
    double moves = 0.01;
    double turns = 0.05;
    int quiet = 3;
  };
  /// Of wheels and gyro that do not turn alike.
  struct Turn {
    double window = 0.4;
    double longest_step = 0.25;
    double sigma = 0.006;
    double turn_sigma = 0.01;
    double jerk_sigma = 0.015;
    double push_sigma = 0.015;
    double walk = 1e-5;
    double small = 0.03;
    double learnable = 2.0;
    double twice = 2.0;
    double wear = 1.5;
    double least_scale = 0.02;
    double zero_offset = 0.035;
    double lag = 0.03;
  };
  /// Of wheels that do not turn as commanded.
  struct Drive {
    double speed_off = 0.12;
    double turn_off = 0.3;
    double share_off = 0.3;
    double latest = 3.0;
    int settling = 5;
    double driving = 0.1;
    double driving_turn = 0.3;
    double motor_limit = 0.65;
  };
  /// Of wheels that slip.
  struct Slip {
    double least_way = 0.012;
    double taken_back = 0.25;
    double added = 0.4;
    double significance = 3.0;
  };
  /// Of people, who are two legs in a scan.
  struct People {
    double farthest = 7.0;
    double free_by = 0.25;
    Duration youngest_view = 250ms;
    int views_through = 3;
    double link = 0.10;
    double link_beams = 1.6;
    double widest = 0.8;
    double leg_width = 0.30;
    double stride = 0.42;
    double stands_free = 0.20;
    double leg_radius = 0.06;
    double sigma = 0.08;
    double acceleration = 0.9;
    double first_speed = 1.0;
    double gate = 9.21;
    double unmoved_penalty = 4.0;
    double largest_gate = 0.7;
    int sightings = 4;
    double walked = 0.30;
    double slowest = 0.25;
    int misses = 2;
    Duration unseen = 500ms;
    Duration standing = 3s;
    double same_place = 0.3;
  };
  /// Of sonar returns, after which obstacles are remembered.
  struct Sonar {
    double trusted = 1.5;
    double middle = 0.4;
    double before_arc = 0.075;
    double arc_spacing = 0.02;
    int hit = 12;
    int pass = -5;
    int most = 40;
    int least = -24;
    double explained = 0.15;
    double explained_bearing = 0.1;
    double far = 4.0;
    double near = 1.2;
  };
  /// Of bumps that an accelerometer tells of.
  struct Bump {
    double push = 7.5;
    double outside = 0.02;
    double half_width = 0.05;
  };

  Monitor monitor;
  Scan scan;
  Blind blind;
  Stamps stamps;
  Repeats repeats;
  Turn turn;
  Drive drive;
  Slip slip;
  People people;
  Sonar sonar;
  Bump bump;
};
/// Its fields.
Parameters parameters_of(Params& params);

}  // namespace threewe::perception
