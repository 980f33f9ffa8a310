// The smallest world that a mind can be tested in: walls, one robot, brute-force rays. No simulator of ours is
// involved.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/exact.hpp"
#include "core/rng.hpp"
#include "threewe/core/footprint.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/core/samples.hpp"
#include "threewe/core/time.hpp"

namespace threewe::testing {

/// A straight wall without thickness.
struct TinyWall {
  Vec2 a;
  Vec2 b;
};

/// The four walls of a rectangle.
inline void add_box(std::vector<TinyWall>& walls, Vec2 low, Vec2 high) {
  walls.push_back({low, {high.x, low.y}});
  walls.push_back({{high.x, low.y}, high});
  walls.push_back({high, {low.x, high.y}});
  walls.push_back({{low.x, high.y}, low});
}

/// Range [m] along a ray to the nearest wall, or `range_max`.
inline double tiny_range(const std::vector<TinyWall>& walls, Vec2 origin, double angle, double range_max) {
  const auto [s, c] = exact::sincos(angle);
  const Vec2 d{c, s};
  double nearest = range_max;
  for (const TinyWall& w : walls) {
    const Vec2 e = w.b - w.a;
    const double det = cross(d, e);
    if (det == 0.0) continue;
    const double t = cross(w.a - origin, e) / det;
    const double u = cross(w.a - origin, d) / det;
    if (t > 0.0 && u >= 0.0 && u <= 1.0) nearest = std::min(nearest, t);
  }
  return nearest;
}

/// What is wrong with the sensors.
struct TinyErrors {
  double forward_scale = 1.0;  ///< true over measured motion
  double lateral_scale = 1.0;
  double gyro_bias = 0.0;    ///< [rad/s]
  double gyro_sigma = 0.0;   ///< [rad/s]
  double range_sigma = 0.0;  ///< [m]
  double range_bias = 0.0;   ///< [m]
};

/// A robot that drives as it is told, with a first-order lag. 50 Hz odometry, 100 Hz gyro, a clockwise lidar that turns
/// at 10 Hz and whose scans arrive 20 ms after the turn.
class TinyWorld {
 public:
  TinyWorld(std::vector<TinyWall> walls, const Pose2D& pose, const TinyErrors& errors, std::uint64_t seed)
      : walls_(std::move(walls)), pose_(pose), errors_(errors), seed_(seed) {}

  const Pose2D& pose() const { return pose_; }
  Time now() const { return now_; }
  std::vector<TinyWall>& walls() { return walls_; }

  /// Somebody puts the robot down elsewhere.
  void teleport(const Pose2D& pose) {
    pose_ = pose;
    velocity_ = {};
  }

  /// One control period at a commanded velocity; returns what arrives at its end.
  std::vector<Sample> tick(const Velocity& command) {
    std::vector<Sample> samples;
    for (int i = 0; i < kSteps; ++i) step(command, samples);
    samples.push_back(make(2, now_, wheels_));
    if (!scan_.ranges.empty() && now_ >= scan_end_ + 20ms) {
      samples.push_back(make(0, scan_end_, scan_));
      scan_.ranges.clear();
    }
    return samples;
  }

  /// The least distance [m] from the footprint to a wall.
  double clearance(const Footprint& footprint) const {
    double least = 1e9;
    for (const TinyWall& w : walls_) {
      for (double t = 0.0; t <= 1.0; t += 0.01) {
        const Vec2 p = w.a + t * (w.b - w.a);
        if (distance(p, pose_.position()) > 1.0) continue;
        least = std::min(least, footprint.signed_distance(inverse(pose_) * p));
      }
    }
    return least;
  }

 private:
  static constexpr int kSteps = 10;  // of 2 ms in a period
  static constexpr int kBeams = 360;
  static constexpr double kRangeMax = 12.0;

  Sample make(std::uint16_t sensor, Time measured, SampleData data) const {
    return {sensor, 0, measured, now_, std::move(data)};
  }

  void step(const Velocity& command, std::vector<Sample>& samples) {
    constexpr double kDt = 0.002;
    const double gain = kDt / 0.05;
    velocity_ = {velocity_.vx + gain * (command.vx - velocity_.vx), velocity_.vy + gain * (command.vy - velocity_.vy),
                 velocity_.omega + gain * (command.omega - velocity_.omega)};
    if (command == Velocity{} &&
        std::fabs(velocity_.vx) + std::fabs(velocity_.vy) + std::fabs(velocity_.omega) < 1e-4) {
      velocity_ = {};
    }
    pose_ = integrate(pose_, velocity_, kDt);
    const Velocity measured{velocity_.vx / errors_.forward_scale, velocity_.vy / errors_.lateral_scale,
                            velocity_.omega};
    wheels_ = {integrate(wheels_.pose, measured, kDt), measured};
    now_ += 2ms;
    ++steps_;

    // the device turns clockwise: beam 359 comes first, beam 0 last
    constexpr int kPerTurn = 50;
    const int phase = static_cast<int>((steps_ - 1) % kPerTurn);
    if (phase == 0) turn_.assign(kBeams, 0.0F);
    for (int i = kBeams * phase / kPerTurn; i < kBeams * (phase + 1) / kPerTurn; ++i) {
      const int beam = kBeams - 1 - i;
      const double angle = pose_.theta - exact::kPi + beam * kIncrement;
      double range = tiny_range(walls_, pose_.position(), angle, kRangeMax);
      if (range < kRangeMax) {
        const RngKey key{seed_, 0, 0, 0, Stream::lidar};
        range += errors_.range_bias + errors_.range_sigma * normal(key, static_cast<std::uint64_t>(steps_),
                                                                   static_cast<std::uint32_t>(beam));
      }
      turn_[static_cast<std::size_t>(beam)] = static_cast<float>(range);
    }
    if (phase == kPerTurn - 1) {
      scan_ = {-exact::kPi, kIncrement, -0.1 / kBeams, 0.02, kRangeMax, turn_};
      scan_end_ = now_;
    }
    if (steps_ % 5 == 0) {
      const RngKey key{seed_, 0, 0, 0, Stream::imu};
      IMUData imu;
      imu.angular_velocity[2] =
          velocity_.omega + errors_.gyro_bias + errors_.gyro_sigma * normal(key, static_cast<std::uint64_t>(steps_));
      samples.push_back(make(1, now_, imu));
    }
  }

  static constexpr double kIncrement = 2.0 * exact::kPi / kBeams;
  std::vector<TinyWall> walls_;
  Pose2D pose_;
  TinyErrors errors_;
  std::uint64_t seed_;
  Velocity velocity_;
  Odometry wheels_;
  Time now_{};
  std::int64_t steps_ = 0;
  std::vector<float> turn_;
  LaserScan scan_;
  Time scan_end_{};
};

}  // namespace threewe::testing
