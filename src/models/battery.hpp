// Battery model: its voltage falls with its charge, and sags under load.
#pragma once

#include <optional>

#include "threewe/core/samples.hpp"
#include "threewe/hardware/profile.hpp"

namespace threewe::models {

/// What a battery is made of, worked out beforehand. V is double, or a vector of doubles: one robot's in each lane.
template <class V>
struct BatteryOf {
  V present;         ///< 1, or 0 where there is none
  V voltage_empty;   ///< [V]
  V voltage_span;    ///< [V] from empty to full
  V per_nominal;     ///< [1/V]
  V idle_power;      ///< [W]
  V per_efficiency;  ///< electrical power over mechanical power of the drive
  V per_capacity;    ///< [1/J]
};

using Battery = BatteryOf<double>;

/// Without a battery its motors always have their nominal voltage.
Battery make_battery(const std::optional<BatterySpec>& spec);

/// A battery under its idle load, by default a full one.
BatteryState start_battery(const BatterySpec& spec, double charge = 1.0);
/// Draws the idle power and what the drive takes to give `drive_power` [W] of mechanical power, for `seconds`. What the
/// current loses in the battery's own resistance is drawn from its charge, too. A drive that brakes gives nothing back.
void drain_battery(const BatterySpec& spec, double drive_power, double seconds, BatteryState& state);
/// The voltage over the nominal one, which is midway between full and empty; 0 once the battery is empty.
double supply_ratio(const BatterySpec& spec, const BatteryState& state);

}  // namespace threewe::models
