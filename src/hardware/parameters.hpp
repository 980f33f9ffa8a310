// Parameters of the autonomy stack for a robot: those of the reference robot, scaled by its profile, then overridden.
#pragma once

#include <string_view>

#include "core/parameters.hpp"
#include "threewe/hardware/profile.hpp"

namespace threewe {

/// How a robot compares with the reference robot, `3we_standard_v2`. What a profile has not, such as the noise of a
/// lidar that has none, is taken to be the reference's.
Scales scales_of(const RobotProfile& profile);

/// Sets what the profile overrides of a module's parameters. Throws ConfigError at the place of an override that names
/// no parameter, with the nearest one that there is, or whose value has another sign or is no count.
void override_parameters(const Parameters& parameters, std::string_view module, const RobotProfile& profile);

/// The parameters of a module ("nav", "slam", "health" or "safety") for a robot, in metres and seconds. `Params` is an
/// aggregate whose defaults are those of the reference robot, with a function `parameters_of(Params&)`.
template <typename Params>
Params params_for(const RobotProfile& profile, std::string_view module) {
  Params params;
  const Parameters fields = parameters_of(params);
  scale_parameters(fields, scales_of(profile));
  override_parameters(fields, module, profile);
  return params;
}

}  // namespace threewe
