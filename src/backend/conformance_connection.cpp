// Before, while and after being connected.
#include <algorithm>
#include <cmath>

#include "backend/conformance_bench.hpp"

namespace threewe::backend::conformance {

namespace {

void features_are_readable_before_connecting(const Context& context) {
  Bench bench = context.fresh();
  expect(!bench.features().sensors.empty(), "features() lists no sensor");
  expect(bench.has(SensorType::odometry), "features() lists no odometry, which every robot has");
  expect(!bench.profile().name.empty(), "profile() has no name");
}

void features_do_not_change(const Context& context) {
  Bench bench = context.fresh();
  const Features before = bench.features();
  bench.port().connect();
  bench.drive({}, 100ms);
  const Features& after = bench.features();
  const auto same_sensor = [](const SensorInfo& a, const SensorInfo& b) {
    return a.name == b.name && a.type == b.type && a.rate == b.rate;
  };
  expect(
      std::equal(before.sensors.begin(), before.sensors.end(), after.sensors.begin(), after.sensors.end(), same_sensor),
      "connecting changed the list of sensors");
  expect(before.kinematics == after.kinematics && before.lockstep == after.lockstep &&
             before.deterministic == after.deterministic && before.can_reset == after.can_reset &&
             before.can_save == after.can_save,
         "connecting changed the features");
}

void features_match_the_profile(const Context& context) {
  Bench bench = context.fresh();
  const RobotProfile& profile = bench.profile();
  expect(bench.features().kinematics == profile.kinematics(), "features() and profile() differ in their kinematics");
  for (const SensorInfo& sensor : bench.features().sensors) {
    expect(profile.has(sensor.type), "sensor '{}': the profile '{}' has no {}", sensor.name, profile.name,
           to_string(sensor.type));
  }
}

void sensor_names_are_unique(const Context& context) {
  Bench bench = context.fresh();
  std::vector<std::string> names;
  for (const SensorInfo& sensor : bench.features().sensors) names.push_back(sensor.name);
  std::sort(names.begin(), names.end());
  const auto twice = std::adjacent_find(names.begin(), names.end());
  expect(twice == names.end(), "two sensors are named '{}'", twice == names.end() ? "" : *twice);
  expect(std::find(names.begin(), names.end(), "") == names.end(), "a sensor has no name");
}

void sensor_rates_are_positive(const Context& context) {
  Bench bench = context.fresh();
  for (const SensorInfo& sensor : bench.features().sensors) {
    expect(std::isfinite(sensor.rate) && sensor.rate > 0.0, "sensor '{}' has a rate of {} Hz", sensor.name,
           sensor.rate);
  }
}

void poll_before_connecting_is_refused(const Context& context) {
  Bench bench = context.fresh();
  expect_throws<ConnectionError>([&] { bench.port().poll(); }, "poll() before connect()", "ConnectionError");
}

void poll_after_disconnecting_is_refused(const Context& context) {
  Bench bench = context.connected();
  bench.drive({}, 100ms);
  bench.port().disconnect();
  expect_throws<ConnectionError>([&] { bench.port().poll(); }, "poll() after disconnect()", "ConnectionError");
}

void connecting_twice_does_nothing(const Context& context) {
  Bench bench = context.connected();
  bench.drive({}, 500ms);
  const Time before = bench.now();
  const auto sequence_before = bench.of(SensorType::odometry).size();
  bench.port().connect();
  expect(!bench.features().lockstep || bench.now() == before, "the second connect() moved time");
  bench.drive({}, 500ms);
  const std::vector<Sample> odometry = bench.of(SensorType::odometry);
  expect(odometry.size() > sequence_before, "no odometry arrived after the second connect()");
  expect(odometry.back().sequence + 1 == odometry.size(), "the second connect() restarted the odometry's sequence");
}

void disconnecting_twice_does_nothing(const Context& context) {
  Bench bench = context.connected();
  bench.drive({}, 100ms);
  bench.port().disconnect();
  bench.port().disconnect();
}

void connecting_again_works(const Context& context) {
  Bench bench = context.connected();
  bench.drive({}, 100ms);
  bench.port().disconnect();
  bench.port().connect();
  bench.forget();
  bench.drive({}, 500ms);
  expect(!bench.of(SensorType::odometry).empty(), "no odometry arrived after connect(), disconnect(), connect()");
}

constexpr Check kConnectionChecks[] = {
    {"features_are_readable_before_connecting", features_are_readable_before_connecting},
    {"features_do_not_change", features_do_not_change},
    {"features_match_the_profile", features_match_the_profile},
    {"sensor_names_are_unique", sensor_names_are_unique},
    {"sensor_rates_are_positive", sensor_rates_are_positive},
    {"poll_before_connecting_is_refused", poll_before_connecting_is_refused},
    {"poll_after_disconnecting_is_refused", poll_after_disconnecting_is_refused},
    {"connecting_twice_does_nothing", connecting_twice_does_nothing},
    {"disconnecting_twice_does_nothing", disconnecting_twice_does_nothing},
    {"connecting_again_works", connecting_again_works},
};

}  // namespace

std::span<const Check> connection_checks() { return kConnectionChecks; }

}  // namespace threewe::backend::conformance
