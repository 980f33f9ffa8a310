#include "backend/plugin_checks.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "core/names.hpp"
#include "hardware/sample_checks.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::backend {

void check_features(const std::string& name, const Features& features, const RobotProfile& profile) {
  const auto fail = [&name](const std::string& what) {
    throw ContractError(fmt::format("backend '{}': {}", name, what));
  };
  if (features.can_save && !features.lockstep) fail("can be saved, but time runs by itself");
  if (features.kinematics != profile.kinematics()) fail("features and profile differ in their kinematics");
  for (const SensorInfo& sensor : features.sensors) {
    const auto same_name = [&sensor](const SensorInfo& other) { return other.name == sensor.name; };
    if (std::count_if(features.sensors.begin(), features.sensors.end(), same_name) > 1) {
      fail(fmt::format("two sensors are named '{}'", sensor.name));
    }
    if (!std::isfinite(sensor.rate) || sensor.rate <= 0.0) {
      fail(fmt::format("sensor '{}': rate is {} Hz; it must be positive", sensor.name, sensor.rate));
    }
    if (!profile.has(sensor.type))
      fail(fmt::format("sensor '{}': the profile '{}' has none", sensor.name, profile.name));
    if (sensor.type == SensorType::ultrasonic) {
      std::vector<std::string> mounts;
      for (const UltrasonicSpec::Mount& mount : profile.ultrasonics->mounts) mounts.push_back(mount.name);
      if (std::ranges::find(mounts, sensor.name) == mounts.end()) fail(unknown_name("mount", sensor.name, mounts));
    }
  }
}

std::size_t find_sensor(const Features& features, const std::string& name) {
  std::vector<std::string> names;
  names.reserve(features.sensors.size());
  for (const SensorInfo& sensor : features.sensors) names.push_back(sensor.name);
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) throw ContractError(unknown_name("sensor", name, names));
  return static_cast<std::size_t>(found - names.begin());
}

void check_stamp(const PluginReading& reading, Time newest, Time latest) {
  const auto fail = [&](const std::string& what) {
    throw ContractError(
        fmt::format("sensor '{}': measured is {} s, {}", reading.sensor, to_seconds(reading.measured), what));
  };
  if (reading.measured > latest) {
    constexpr Duration kAnotherClock = 10s;  // ahead: no rounding, and no step that is too long
    fail(fmt::format(
        "in the future: now is {} s{}", to_seconds(latest),
        reading.measured < latest + kAnotherClock
            ? ""
            : "; it is probably another clock's time, where robot time begins at 0 s when the world is made "
              "or reset"));
  }
  if (reading.measured <= newest) fail(fmt::format("not after {} s of the reading before", to_seconds(newest)));
}

void check_truth(const PluginTruth& truth) {
  const auto fail = [](const std::string& what) { throw ContractError("truth(): " + what); };
  if (!is_bounded(truth.start)) fail("start is not finite, or farther than 1000 km from the origin");
  if (!is_bounded(truth.pose)) fail("pose is not finite, or farther than 1000 km from the origin");
  if (!is_finite(truth.velocity)) fail("velocity is not finite");
  const auto check_number = [&](const char* name, double value) {
    if (!std::isfinite(value) || value < 0.0) fail(fmt::format("{} is {}; it must be 0 or more", name, value));
  };
  check_number("distance_driven", truth.distance_driven);
  check_number("max_collision_speed", truth.max_collision_speed);
}

}  // namespace threewe::backend
