// Tuned parameters of the safety gate.
#pragma once

#include "core/parameters.hpp"
#include "threewe/core/time.hpp"
#include "threewe/hardware/profile.hpp"

namespace threewe::safety {

/// The defaults are those of the reference robot; `params_for` gives a robot's own.
struct Params {
  /// Of the collision monitor and the watchdog.
  struct Gate {
    double margin = 0.02;
    Duration sensor_timeout = 500ms;
    double sweep_step = 0.005;
  };
  /// Of creep mode.
  struct Creep {
    double margin = 0.003;
    double speed = 0.04;
    double corner_speed = 0.05;
    double sight = 0.5;
    double flat = 0.08;
  };
  /// Of sectors in which no beam is valid.
  struct Unseen {
    double thin = 0.03;
    double step = 0.02;
  };
  /// Of what comes nearer.
  struct Approach {
    Duration since = 150ms;
    Duration until = 350ms;
    double least_speed = 0.2;
    double fastest = 0.6;
    double bearing = 0.0436332313;
    int together = 3;
  };
  Gate gate;
  Creep creep;
  Unseen unseen;
  Approach approach;
};
/// Its fields.
Parameters parameters_of(Params& params);

/// [m] that the gate keeps free around a robot's footprint: a lidar that measures everything a little too far away must
/// not touch either.
double margin_of(const RobotProfile& profile);

}  // namespace threewe::safety
