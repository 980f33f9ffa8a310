// The `link:` section of a robot profile: how the real robot is reached.
#pragma once

#include "core/config.hpp"
#include "threewe/hardware/profile.hpp"

namespace threewe {

/// Reads the section. `profile` has its sensors already. Throws ConfigError.
LinkSpec read_link(ConfigNode node, const RobotProfile& profile);

}  // namespace threewe
