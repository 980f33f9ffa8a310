#include "threewe/models/battery.hpp"

#include <doctest/doctest.h>

using namespace threewe;
using namespace threewe::models;

TEST_CASE("a battery lasts as long as its energy, and drives empty it faster") {
  const BatterySpec spec = *load_profile("3we_standard_v2").battery;
  const auto hours = [&](double drive_power) {
    BatteryState state = start_battery(spec);
    double seconds = 0.0;
    while (state.charge > 0.0) {
      drain_battery(spec, drive_power, 1.0, state);
      seconds += 1.0;
    }
    return seconds / 3600.0;
  };
  CHECK(hours(0.0) == doctest::Approx(spec.capacity / spec.idle_power).epsilon(0.001));
  CHECK(hours(0.4) == doctest::Approx(spec.capacity / (spec.idle_power + 0.4 / spec.drive_efficiency)).epsilon(0.001));
  // driving at 0.5 m/s, the stated two hours
  CHECK(hours(0.37) > 2.0);
  CHECK(hours(0.37) < 2.5);
  CHECK(hours(-5.0) == hours(0.0));
}

TEST_CASE("voltage falls with charge and sags under load") {
  BatterySpec spec = *load_profile("3we_standard_v2").battery;
  BatteryState state = start_battery(spec);
  CHECK(state.charge == 1.0);
  CHECK(state.current == doctest::Approx(10.5 / 8.4));
  CHECK(state.voltage == doctest::Approx(8.4 - 0.1 * 10.5 / 8.4));
  BatteryState loaded = state;
  drain_battery(spec, 20.0, 0.0, loaded);
  CHECK(loaded.voltage < state.voltage - 0.4);
  CHECK(supply_ratio(spec, loaded) < supply_ratio(spec, state));

  spec.resistance = 0.0;
  CHECK(start_battery(spec).voltage == 8.4);
  CHECK(supply_ratio(spec, {7.2, 1.0, 0.5}) == doctest::Approx(1.0));
  CHECK(supply_ratio(spec, {6.0, 1.0, 0.0}) == 0.0);
}
