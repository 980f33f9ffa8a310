// A battery: its voltage falls with its charge, and sags under load.
#pragma once

#include "threewe/core/samples.hpp"
#include "threewe/hardware/profile.hpp"

namespace threewe::models {

/// A battery under its idle load, by default a full one.
BatteryState start_battery(const BatterySpec& spec, double charge = 1.0);
/// Draws the idle power and what the drive takes to give `drive_power` [W] of mechanical power, for `seconds`. What the
/// current loses in the battery's own resistance is drawn from its charge, too. A drive that brakes gives nothing back.
void drain_battery(const BatterySpec& spec, double drive_power, double seconds, BatteryState& state);
/// The voltage over the nominal one, which is midway between full and empty; 0 once the battery is empty.
double supply_ratio(const BatterySpec& spec, const BatteryState& state);

}  // namespace threewe::models
