// Every parameter of the autonomy stack for a robot: its value, and where that comes from.
#pragma once

#include <string>
#include <vector>

#include "core/parameters.hpp"
#include "threewe/hardware/profile.hpp"

namespace threewe {

/// A parameter as a robot has it.
struct AutonomyParameter {
  std::string name;        ///< with its module, such as "nav.recovery.same_place"
  double value = 0.0;      ///< in `unit`; times in seconds
  std::string unit;        ///< such as "m"; empty for a share or a count
  double reference = 0.0;  ///< the value of the reference robot, `3we_standard_v2`
  Scale scale{};           ///< what it grows with from robot to robot
  std::string origin;      ///< "default", "size x 0.69", or the place in the profile that overrides it
  std::string meaning;     ///< what it does, in a line
  bool is_count = false;   ///< a whole number
  friend bool operator==(const AutonomyParameter&, const AutonomyParameter&) = default;
};

/// All of them, module by module. Throws ConfigError where an override of the profile is wrong.
std::vector<AutonomyParameter> autonomy_parameters(const RobotProfile& profile);

}  // namespace threewe
