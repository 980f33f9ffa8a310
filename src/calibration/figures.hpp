// The figures of a profile that a calibration fits.
#pragma once

#include <functional>
#include <vector>

#include "threewe/hardware/profile.hpp"

namespace threewe::calibration {

struct Knob {
  const char* name;  ///< of its field below `body`
  double low;        ///< it stays within these, in the profile's unit
  double high;
  double doubt;  ///< how far off what is assumed beforehand may be: standard deviation
  std::function<double(const Body&)> get;
  std::function<void(Body&, double)> set;
};

/// Those that a robot of these kinematics has.
std::vector<Knob> knobs(const RobotProfile& profile);

/// The profile with a `traction`: its own, or what follows from its dimensions.
RobotProfile with_traction(RobotProfile profile);

}  // namespace threewe::calibration
