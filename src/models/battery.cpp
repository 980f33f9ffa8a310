#include "models/battery.hpp"

#include <hwy/highway.h>

#include "models/drive-inl.hpp"

namespace threewe::models {
namespace {

HWY_NAMESPACE::ChargeOf<double> numbers(const BatteryState& state) {
  return {state.voltage, state.current, state.charge};
}

}  // namespace

Battery make_battery(const std::optional<BatterySpec>& spec) {
  if (!spec) return {};
  Battery battery{};
  battery.present = 1.0;
  battery.voltage_empty = spec->voltage_empty;
  battery.voltage_span = spec->voltage_full - spec->voltage_empty;
  battery.per_nominal = 1.0 / (0.5 * (spec->voltage_full + spec->voltage_empty));
  battery.idle_power = spec->idle_power;
  battery.per_efficiency = 1.0 / spec->drive_efficiency;
  battery.per_capacity = 1.0 / (3600.0 * spec->capacity);
  return battery;
}

BatteryState start_battery(const BatterySpec& spec, double charge) {
  BatteryState state;
  state.charge = charge;
  state.voltage = spec.voltage_full;
  for (int i = 0; i < 20; ++i) drain_battery(spec, 0.0, 0.0, state);
  return state;
}

void drain_battery(const BatterySpec& spec, double drive_power, double seconds, BatteryState& state) {
  const auto [voltage, current, charge] =
      HWY_NAMESPACE::drain_battery(make_battery(spec), spec.resistance, drive_power, seconds, numbers(state));
  state = {voltage, current, charge};
}

double supply_ratio(const BatterySpec& spec, const BatteryState& state) {
  return HWY_NAMESPACE::supply_ratio(make_battery(spec), numbers(state));
}

}  // namespace threewe::models
