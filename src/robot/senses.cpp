#include "robot/senses.hpp"

#include <algorithm>
#include <string>

#include "threewe/core/errors.hpp"

namespace threewe {

std::vector<std::size_t> sensors_of(const backend::Features& features, const RobotProfile& profile, SensorType type) {
  std::vector<std::size_t> sensors;
  for (std::size_t i = 0; i < features.sensors.size(); ++i) {
    if (features.sensors[i].type == type) sensors.push_back(i);
  }
  if (!sensors.empty()) return sensors;
  const std::string sensor = "sensor '" + std::string(to_string(type)) + "'";
  if (profile.has(type)) {
    throw HardwareError("this backend does not deliver " + sensor + ", which robot '" + profile.name + "' has");
  }
  throw HardwareError("robot '" + profile.name + "' has no " + sensor);
}

const Sample& Senses::newest(const backend::Features& features, std::size_t sensor) const {
  if (newest_[sensor]) return *newest_[sensor];
  throw HardwareError("sensor '" + features.sensors[sensor].name + "' has not delivered anything yet");
}

bool Senses::complete() const {
  return std::all_of(newest_.begin(), newest_.end(), [](const auto& sample) { return sample.has_value(); });
}

}  // namespace threewe
