// Percepts: how a robot's sensors are and who walks around it, as far as its own samples tell.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "threewe/core/pose.hpp"
#include "threewe/core/time.hpp"

namespace threewe::perception {

/// What may be wrong with a sensor.
enum class SensorFault : std::uint8_t {
  none,
  silent,        ///< nothing has arrived for too long
  frozen,        ///< the same reading again and again, while the robot moves
  implausible,   ///< a reading that no such sensor can make: not a number, or out of its range
  wrong_stamps,  ///< times that run backwards, or come from the future
  late,          ///< readings arrive much later than they used to
  noisy,         ///< readings are noisier than they used to be
  shifted,       ///< all ranges are too long or too short by the same
  blind,         ///< so many beams are invalid side by side that the robot would fit between two that are not
  contradicted   ///< others say otherwise
};
/// In words, as in "the sensor is silent".
std::string_view to_string(SensorFault fault);

/// How one sensor is.
struct SensorHealth {
  std::string name;                       ///< of the sensor, as in `Features`
  SensorFault fault = SensorFault::none;  ///< `none` while it is ok
  std::string detail;                     ///< says more; may be empty
  Time since{};                           ///< when the fault was noticed, or was over
  bool needed = false;                    ///< the robot stands still while this sensor is at fault
  /// Whether it may be used.
  bool ok() const { return fault == SensorFault::none; }
};

/// A person who walks, or has just stopped. In the robot's `odom`.
struct TrackedPerson {
  std::uint32_t id = 0;               ///< the same as long as the person is in sight
  Vec2 position;                      ///< [m]
  Vec2 velocity;                      ///< [m/s]
  std::array<double, 16> covariance;  ///< of (x, y, vx, vy), row-major
  friend bool operator==(const TrackedPerson&, const TrackedPerson&) = default;
};

}  // namespace threewe::perception
