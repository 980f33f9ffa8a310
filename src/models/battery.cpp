#include "threewe/models/battery.hpp"

#include <algorithm>

namespace threewe::models {

BatteryState start_battery(const BatterySpec& spec) {
  BatteryState state;
  state.charge = 1.0;
  drain_battery(spec, 0.0, 0.0, state);
  return state;
}

void drain_battery(const BatterySpec& spec, double drive_power, double seconds, BatteryState& state) {
  const double power = spec.idle_power + std::max(drive_power, 0.0) / spec.drive_efficiency;
  state.charge = std::max(state.charge - power * seconds / (3600.0 * spec.capacity), 0.0);
  const double open_circuit = spec.voltage_empty + (spec.voltage_full - spec.voltage_empty) * state.charge;
  state.current = power / open_circuit;
  state.voltage = open_circuit - state.current * spec.resistance;
}

double supply_ratio(const BatterySpec& spec, const BatteryState& state) {
  if (state.charge <= 0.0) return 0.0;
  return state.voltage / (0.5 * (spec.voltage_full + spec.voltage_empty));
}

}  // namespace threewe::models
