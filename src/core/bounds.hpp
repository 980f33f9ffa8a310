// Bounds of robots, sensors and maps: numbers beyond are refused where they come in, by an API or a file. So cells can
// be counted in 32 bits and angles keep their digits, whatever a caller or a recording holds.
#pragma once

#include <cstddef>
#include <string_view>

#include "threewe/core/pose.hpp"
#include "threewe/core/samples.hpp"

namespace threewe {

/// How far from the origin of its frame a place may be, and how long a range may be [m].
inline constexpr double kMaxCoordinate = 1e6;
/// How large an angle may be [rad], on either side of 0: up to here `exact::sincos` keeps its digits.
inline constexpr double kMaxAngle = 1e5;
/// How fast anything moves or turns [m/s], [rad/s]: a pose that changes faster has jumped.
inline constexpr double kMaxSpeed = 1e3;
/// How long one scan may take [s], and of how many beams it may be.
inline constexpr double kMaxSweep = 10.0;
inline constexpr std::size_t kMaxBeams = 16384;

/// False for NaN, too.
constexpr bool is_within(double value, double low, double high) { return value >= low && value <= high; }
constexpr bool is_bounded(double coordinate) { return is_within(coordinate, -kMaxCoordinate, kMaxCoordinate); }
constexpr bool is_bounded(Vec2 place) { return is_bounded(place.x) && is_bounded(place.y); }
constexpr bool is_bounded(const Pose2D& pose) {
  return is_bounded(pose.position()) && is_within(pose.theta, -kMaxAngle, kMaxAngle);
}

/// Throws ContractError naming the argument unless a place, or a pose, is within these bounds.
void check_bounds(std::string_view name, Vec2 place);
void check_bounds(std::string_view name, const Pose2D& pose);
/// Throws ContractError naming the field unless a lidar could have measured a scan.
void check_bounds(const LaserScan& scan);

}  // namespace threewe
