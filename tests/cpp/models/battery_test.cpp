#include "models/battery.hpp"

#include <doctest/doctest.h>

#include <algorithm>

#include "core/rng.hpp"

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
  // a little less than its energy: some of it warms the cells
  const double hot = 1.0 + spec.resistance * spec.idle_power / (7.2 * 7.2);
  CHECK(hours(0.0) * hot == doctest::Approx(spec.capacity / spec.idle_power).epsilon(0.003));
  CHECK(hours(0.4) < spec.capacity / (spec.idle_power + 0.4 / spec.drive_efficiency));
  // driving at 0.5 m/s, the stated two hours
  CHECK(hours(0.37) > 2.0);
  CHECK(hours(0.37) < 2.5);
  CHECK(hours(-5.0) == hours(0.0));
}

TEST_CASE("voltage falls with charge and sags under load") {
  BatterySpec spec = *load_profile("3we_standard_v2").battery;
  BatteryState state = start_battery(spec);
  CHECK(state.charge == 1.0);
  CHECK(state.voltage == doctest::Approx(8.4 - 0.1 * state.current));
  CHECK(state.voltage * state.current == doctest::Approx(10.5));
  BatteryState loaded = state;
  for (int i = 0; i < 10; ++i) drain_battery(spec, 20.0, 0.0, loaded);
  CHECK(loaded.voltage * loaded.current == doctest::Approx(10.5 + 20.0 / 0.4));
  CHECK(loaded.voltage < state.voltage - 0.4);
  CHECK(supply_ratio(spec, loaded) < supply_ratio(spec, state));

  spec.resistance = 0.0;
  CHECK(start_battery(spec).voltage == 8.4);
  CHECK(supply_ratio(spec, {7.2, 1.0, 0.5}) == doctest::Approx(1.0));
  CHECK(supply_ratio(spec, {6.0, 1.0, 0.0}) == 0.0);
}

TEST_CASE("no energy is lost: what leaves the cells is idling, driving and their own heat") {
  const BatterySpec spec = *load_profile("3we_standard_v2").battery;
  const RngKey key{.seed = 8, .stream = Stream::battery};
  BatteryState state = start_battery(spec);
  double spent = 0.0;  // [J]
  for (std::uint64_t i = 0; i < 200'000; ++i) {
    // as a robot drives: a new effort twice a second
    const double drive = 8.0 * std::max(uniform(key, i / 50, 0) - 0.3, 0.0);
    drain_battery(spec, drive, 0.01, state);
    spent += 0.01 * (spec.idle_power + drive / spec.drive_efficiency + state.current * state.current * spec.resistance);
  }
  CHECK((1.0 - state.charge) * spec.capacity * 3600.0 == doctest::Approx(spent).epsilon(1e-3));
  CHECK(spent > 0.1 * spec.capacity * 3600.0);
}

TEST_CASE("a load that the cells cannot feed holds them at half their voltage") {
  BatterySpec spec = *load_profile("3we_standard_v2").battery;
  spec.resistance = 5.0;
  BatteryState state = start_battery(spec);
  for (int i = 0; i < 100; ++i) {
    drain_battery(spec, 1000.0, 0.01, state);
    CHECK(state.voltage > 2.9);
    CHECK(state.current < 0.85);
  }
}
