#include "threewe/core/samples.hpp"

namespace threewe {

std::string_view to_string(SensorType type) {
  switch (type) {
    case SensorType::lidar: return "lidar";
    case SensorType::imu: return "imu";
    case SensorType::odometry: return "odometry";
    case SensorType::battery: return "battery";
    case SensorType::ultrasonic: return "ultrasonic";
    case SensorType::camera: return "camera";
  }
  return "unknown";
}

}  // namespace threewe
