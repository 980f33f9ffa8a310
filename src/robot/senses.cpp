#include "robot/senses.hpp"

#include <algorithm>
#include <string>

#include "threewe/core/errors.hpp"

namespace threewe {

const Sample& Senses::newest(const backend::Features& features, const RobotProfile& profile, SensorType type) const {
  for (std::size_t i = 0; i < features.sensors.size(); ++i) {
    if (features.sensors[i].type != type) continue;
    if (newest_[i]) return *newest_[i];
    throw HardwareError("sensor '" + features.sensors[i].name + "' has not delivered anything yet");
  }
  throw HardwareError("robot '" + profile.name + "' has no sensor '" + std::string(to_string(type)) + "'");
}

bool Senses::complete() const {
  return std::all_of(newest_.begin(), newest_.end(), [](const auto& sample) { return sample.has_value(); });
}

}  // namespace threewe
