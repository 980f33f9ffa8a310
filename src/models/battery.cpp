#include "threewe/models/battery.hpp"

#include <algorithm>

namespace threewe::models {

BatteryState start_battery(const BatterySpec& spec, double charge) {
  BatteryState state;
  state.charge = charge;
  state.voltage = spec.voltage_full;
  for (int i = 0; i < 20; ++i) drain_battery(spec, 0.0, 0.0, state);
  return state;
}

void drain_battery(const BatterySpec& spec, double drive_power, double seconds, BatteryState& state) {
  const double power = spec.idle_power + std::max(drive_power, 0.0) / spec.drive_efficiency;
  const double open_circuit = spec.voltage_empty + (spec.voltage_full - spec.voltage_empty) * state.charge;
  // the power fixes the product of current and voltage; the voltage of the step before is near enough to go on from
  state.current = power / state.voltage;
  // beyond half its voltage a battery gives less power, not more
  if (state.current * spec.resistance > 0.5 * open_circuit) state.current = 0.5 * open_circuit / spec.resistance;
  state.voltage = open_circuit - state.current * spec.resistance;
  state.charge = std::max(state.charge - open_circuit * state.current * seconds / (3600.0 * spec.capacity), 0.0);
}

double supply_ratio(const BatterySpec& spec, const BatteryState& state) {
  if (state.charge <= 0.0) return 0.0;
  return state.voltage / (0.5 * (spec.voltage_full + spec.voltage_empty));
}

}  // namespace threewe::models
