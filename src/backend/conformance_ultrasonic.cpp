// What a sensor that hears echoes owes.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>

#include "backend/conformance_bench.hpp"
#include "hardware/sample_checks.hpp"

namespace threewe::backend::conformance {

namespace {

Bench with_ultrasonics(const Context& context) {
  Bench bench = context.connected();
  applies_if(bench.has(SensorType::ultrasonic), "the robot has no ultrasonic sensors");
  expect(bench.profile().ultrasonics.has_value(), "features() lists ultrasonic sensors that the profile lacks");
  return bench;
}

/// The pings of all sensors within a few seconds, at rest and turning.
std::vector<Sample> some_pings(Bench& bench) {
  bench.drive({}, 1s);
  bench.drive({0.0, 0.0, bench.turning()}, 1s);
  std::vector<Sample> pings;
  std::ranges::copy_if(bench.samples(), std::back_inserter(pings),
                       [](const Sample& sample) { return std::holds_alternative<RangeData>(sample.data); });
  expect(!pings.empty(), "no range arrived within 2 s");
  return pings;
}

void ultrasonics_are_mounted(const Context& context) {
  Bench bench = with_ultrasonics(context);
  const auto& mounts = bench.profile().ultrasonics->mounts;
  for (const SensorInfo& sensor : bench.features().sensors) {
    if (sensor.type != SensorType::ultrasonic) continue;
    const bool known = std::ranges::find(mounts, sensor.name, &UltrasonicSpec::Mount::name) != mounts.end();
    expect(known, "the profile '{}' does not say where sensor '{}' is mounted", bench.profile().name, sensor.name);
  }
}

void sonar_limits_are_the_profiles(const Context& context) {
  Bench bench = with_ultrasonics(context);
  const UltrasonicSpec& spec = *bench.profile().ultrasonics;
  for (const Sample& sample : some_pings(bench)) {
    const auto& echo = std::get<RangeData>(sample.data);
    expect(echo.range_min == spec.range_min && echo.range_max == spec.range_max,
           "a range from {} to {} m; the profile has {} to {} m", echo.range_min, echo.range_max, spec.range_min,
           spec.range_max);
    expect(std::abs(echo.field_of_view - spec.field_of_view) <= 1e-6, "a cone of {} rad; the profile has {} rad",
           echo.field_of_view, spec.field_of_view);
  }
}

void sonar_ranges_are_valid(const Context& context) {
  Bench bench = with_ultrasonics(context);
  for (const Sample& sample : some_pings(bench)) {
    const auto& echo = std::get<RangeData>(sample.data);
    const bool within =
        echo.range >= echo.range_min - kRangeTolerance && echo.range <= echo.range_max + kRangeTolerance;
    expect(echo.range == 0.0 || within, "{} m is neither 0 (invalid) nor within {} to {} m", echo.range, echo.range_min,
           echo.range_max);
  }
}

void one_ultrasonic_pings_at_a_time(const Context& context) {
  Bench bench = with_ultrasonics(context);
  const Duration interval = bench.profile().ultrasonics->interval;
  std::vector<Time> times;
  for (const Sample& sample : some_pings(bench)) times.push_back(sample.measured);
  std::ranges::sort(times);
  for (std::size_t i = 1; i < times.size(); ++i) {
    expect(times[i] - times[i - 1] >= interval / 2,
           "pings at {} s and {} s: a return of one may reach the other; the profile leaves {} s between them",
           to_seconds(times[i - 1]), to_seconds(times[i]), to_seconds(interval));
  }
}

/// The newest range of each sensor that looks forward, within half a cone; empty where it hears nothing.
std::vector<std::optional<double>> heard_ahead(Bench& bench) {
  const UltrasonicSpec& spec = *bench.profile().ultrasonics;
  std::vector<std::optional<double>> ranges;
  for (std::size_t i = 0; i < bench.features().sensors.size(); ++i) {
    const SensorInfo& sensor = bench.features().sensors[i];
    if (sensor.type != SensorType::ultrasonic) continue;
    const Pose2D mount = bench.profile().base_from_sensor(sensor.type, sensor.name);
    if (std::abs(mount.theta) > 0.5 * spec.field_of_view) continue;
    const std::vector<Sample> samples = bench.of_sensor(i);
    expect(!samples.empty(), "sensor '{}' delivered nothing", sensor.name);
    const double range = std::get<RangeData>(samples.back().data).range;
    const bool heard = range > 0.0 && range < spec.range_max;
    ranges.push_back(heard ? std::optional(range) : std::nullopt);
  }
  return ranges;
}

/// What stands ahead comes nearer by what is driven. One sensor that says so is enough: others may have lost the wall.
void ultrasonics_measure_the_robot_drive_forward(const Context& context) {
  Bench bench = with_ultrasonics(context);
  bench.drive({}, 1s);
  const auto before = heard_ahead(bench);
  const Pose2D start = bench.odometry().pose;
  bench.drive_and_stop({bench.cruise(), 0.0, 0.0}, from_seconds(0.5 / bench.cruise()));
  bench.drive({}, 500ms);
  const auto after = heard_ahead(bench);
  const double driven = (inverse(start) * bench.odometry().pose).x;

  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (before[i] && after[i]) nearest = std::min(nearest, std::abs(*before[i] - *after[i] - driven));
  }
  applies_if(std::isfinite(nearest), "no sensor measures anything ahead of the robot");
  expect(nearest <= 0.1, "driving {:.2f} m forward changed no range ahead by that: the best is off by {:.2f} m", driven,
         nearest);
}

constexpr Check kUltrasonicChecks[] = {
    {"ultrasonics_are_mounted", ultrasonics_are_mounted},
    {"sonar_limits_are_the_profiles", sonar_limits_are_the_profiles},
    {"sonar_ranges_are_valid", sonar_ranges_are_valid},
    {"one_ultrasonic_pings_at_a_time", one_ultrasonic_pings_at_a_time},
    {"ultrasonics_measure_the_robot_drive_forward", ultrasonics_measure_the_robot_drive_forward},
};

}  // namespace

std::span<const Check> ultrasonic_checks() { return kUltrasonicChecks; }

}  // namespace threewe::backend::conformance
