// Newest sample of each sensor.
#pragma once

#include <optional>
#include <vector>

#include "threewe/backend/world.hpp"
#include "threewe/core/samples.hpp"

namespace threewe {

/// The sensors of a type, by their places in the features. Throws HardwareError where there are none.
std::vector<std::size_t> sensors_of(const backend::Features& features, const RobotProfile& profile, SensorType type);

/// The newest samples. Plain data.
class Senses {
 public:
  explicit Senses(std::size_t sensors) : newest_(sensors) {}

  void remember(const Sample& sample) { newest_[sample.sensor] = sample; }
  /// The newest sample of a sensor. Throws HardwareError before its first.
  const Sample& newest(const backend::Features& features, std::size_t sensor) const;
  /// True when every sensor has delivered.
  bool complete() const;

 private:
  std::vector<std::optional<Sample>> newest_;  // by sensor
};

}  // namespace threewe
