// A small honest backend: an ideal robot in an empty room, run by a thread of its own. What tests break.
#pragma once

#include <cstring>
#include <functional>
#include <memory>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "backend/plugin.hpp"
#include "core/exact.hpp"
#include "core/rng.hpp"
#include "threewe/backend/registry.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::backend::testing {

/// A room from (-2, -2) to (4, 3); the robot starts at the origin and obeys at once.
class ToyRobot {
 public:
  ToyRobot(RobotProfile profile, NoiseLevel noise, std::uint64_t seed)
      : profile_(std::move(profile)), sigma_(noise == NoiseLevel::ideal ? 0.0 : 0.01), state_{.seed = seed} {}

  static Features features(const RobotProfile& profile) {
    Features features{.sensors = {{"lidar", SensorType::lidar, 10.0},
                                  {"imu", SensorType::imu, 100.0},
                                  {"odometry", SensorType::odometry, 50.0},
                                  {"battery", SensorType::battery, 1.0}},
                      .kinematics = profile.kinematics(),
                      .lockstep = true,
                      .deterministic = true,
                      .can_reset = true,
                      .can_save = true};
    if (profile.ultrasonics) {
      for (const auto& mount : profile.ultrasonics->mounts) {
        features.sensors.push_back(
            {mount.name, SensorType::ultrasonic, 1.0 / to_seconds(profile.ultrasonics->period())});
      }
    }
    return features;
  }

  PluginReply operator()(const PluginRequest& request) {
    using Call = PluginRequest::Call;
    switch (request.call) {
      case Call::connect: return {};
      case Call::disconnect: return {};
      case Call::step: return {.readings = step(request.t, request.velocity), .state = {}};
      case Call::reset:
        start_ = request.pose.value_or(Pose2D{});
        state_ = {.seed = request.seed};
        return {};
      case Call::save: return {.readings = {}, .state = bytes()};
      case Call::restore: std::memcpy(&state_, request.state.data(), sizeof state_); return {};
      case Call::truth: return {};  // never asked: no view of it is given to the world
    }
    return {};
  }

 private:
  struct State {  // no padding: saved as bytes
    std::uint64_t seed = 0;
    std::int64_t millisecond = 0;
    Pose2D pose{};
    Velocity velocity{};
  };

  std::vector<PluginReading> step(Time t, const Velocity& velocity) {
    std::vector<PluginReading> readings;
    for (Time next = (state_.millisecond + 1) * 1ms; next <= t; next += 1ms) {
      state_.millisecond = next / 1ms;
      state_.pose = integrate(state_.pose, velocity, 0.001);
      state_.velocity = velocity;
      if (state_.millisecond % 100 == 0) readings.push_back({"lidar", next, scan()});
      if (state_.millisecond % 10 == 0) readings.push_back({"imu", next, imu()});
      if (state_.millisecond % 20 == 0) readings.push_back({"odometry", next, Odometry{state_.pose, velocity}});
      if (state_.millisecond % 1000 == 0) readings.push_back({"battery", next, battery()});
      if (profile_.ultrasonics && next % profile_.ultrasonics->interval == 0ms) {
        const auto& mounts = profile_.ultrasonics->mounts;
        const auto turn = static_cast<std::size_t>(next / profile_.ultrasonics->interval) % mounts.size();
        readings.push_back({mounts[turn].name, next, echo(mounts[turn].base_from_ultrasonic)});
      }
    }
    return readings;
  }

  // [m] along a ray to the walls.
  static double to_wall(Vec2 from, double angle) {
    const auto [sin, cos] = exact::sincos(angle);
    const double to_x = cos == 0.0 ? 1e9 : ((cos > 0.0 ? 4.0 : -2.0) - from.x) / cos;
    const double to_y = sin == 0.0 ? 1e9 : ((sin > 0.0 ? 3.0 : -2.0) - from.y) / sin;
    return std::min(to_x, to_y);
  }

  // The nearest of a fan of rays: every wall of this room sends sound back.
  RangeData echo(const Pose2D& base_from_ultrasonic) const {
    const UltrasonicSpec& spec = *profile_.ultrasonics;
    const Pose2D sensor = in_room() * base_from_ultrasonic;
    double nearest = spec.range_max;
    for (int i = -5; i <= 5; ++i) {
      nearest = std::min(nearest, to_wall(sensor.position(), sensor.theta + 0.1 * i * spec.field_of_view));
    }
    const double range = nearest < spec.range_min ? 0.0 : nearest;
    return {spec.field_of_view, spec.range_min, spec.range_max, range};
  }

  LaserScan scan() const {
    const LidarSpec& spec = *profile_.lidar;
    LaserScan scan{.angle_min = -exact::kPi,
                   .angle_increment = 2.0 * exact::kPi / spec.beams,
                   .time_increment = 0.0,
                   .range_min = spec.range_min,
                   .range_max = spec.range_max,
                   .ranges = std::vector<float>(static_cast<std::size_t>(spec.beams))};
    const Pose2D lidar = in_room() * spec.base_from_lidar;
    const RngKey key{.seed = state_.seed, .stream = Stream::lidar};
    for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
      const double angle = lidar.theta + scan.angle_min + static_cast<double>(i) * scan.angle_increment;
      const double noise =
          sigma_ * normal(key, static_cast<std::uint64_t>(state_.millisecond), static_cast<std::uint32_t>(i));
      scan.ranges[i] =
          static_cast<float>(std::clamp(to_wall(lidar.position(), angle) + noise, spec.range_min, spec.range_max));
    }
    return scan;
  }
  IMUData imu() const { return {{0.0, 0.0, state_.velocity.omega}, {0.0, 0.0, 9.81}}; }
  BatteryState battery() const { return {8.0, 1.0, 1.0 - static_cast<double>(state_.millisecond) / 7'200'000.0}; }
  std::vector<std::byte> bytes() const {
    const auto* begin = reinterpret_cast<const std::byte*>(&state_);
    return {begin, begin + sizeof state_};
  }

  Pose2D in_room() const { return start_ * state_.pose; }

  RobotProfile profile_;
  double sigma_;  // [m] of each range
  Pose2D start_{};
  State state_;
};

using Handler = std::function<PluginReply(const PluginRequest&)>;

/// Answers requests until the world is gone. What `handler` throws is the plug-in raising.
inline void serve(PluginLink& link, const Handler& handler) {
  while (const auto request = link.take()) {
    try {
      link.answer(handler(*request));
    } catch (const std::exception& error) {
      link.fail(error.what());
    }
  }
}

/// A world whose plug-in is `handler`, in a thread that ends with the world.
inline std::unique_ptr<World> plugin_world(Features features, RobotProfile profile, Handler handler,
                                           Duration patience = 2s) {
  static std::vector<std::jthread> threads;  // joined when the program ends
  auto link = std::make_shared<PluginLink>("toy", std::move(features), std::move(profile), patience);
  auto world = std::make_unique<PluginWorld>(link);
  threads.emplace_back([link, handler = std::move(handler)] { serve(*link, handler); });
  return world;
}

inline std::unique_ptr<World> toy_world(const WorldOptions& options) {
  const RobotProfile profile = load_profile(options.robots.front());
  return plugin_world(ToyRobot::features(profile), profile, ToyRobot(profile, options.noise, options.seed));
}

}  // namespace threewe::backend::testing
