#include "backend/mujoco/world/mujoco_port.hpp"

#include <algorithm>
#include <optional>

#include <fmt/format.h>

#include "backend/mujoco/world/mujoco_world.hpp"
#include "threewe/core/errors.hpp"
#include "threewe/models/lidar.hpp"
#include "threewe/models/ultrasonic.hpp"

namespace threewe::backend::mujoco {
namespace {

SensorInfo sensor_info(SensorType type, Duration period) {
  return {std::string(to_string(type)), type, 1.0 / to_seconds(period)};
}

// No camera: who asks for one hears that the robot has none here.
Features features_of(const RobotProfile& profile) {
  Features features;
  features.kinematics = profile.kinematics();
  features.lockstep = features.deterministic = features.can_reset = features.can_save = true;
  if (profile.lidar) features.sensors.push_back(sensor_info(SensorType::lidar, profile.lidar->turn));
  if (profile.imu) features.sensors.push_back(sensor_info(SensorType::imu, profile.imu->period));
  features.sensors.push_back(sensor_info(SensorType::odometry, profile.odometry.period));
  if (profile.battery) features.sensors.push_back(sensor_info(SensorType::battery, profile.battery->period));
  if (profile.ultrasonics) {
    for (const UltrasonicSpec::Mount& mount : profile.ultrasonics->mounts) {
      features.sensors.push_back({mount.name, SensorType::ultrasonic, 1.0 / to_seconds(profile.ultrasonics->period())});
    }
  }
  return features;
}

}  // namespace

MujocoPort::MujocoPort(const MujocoWorld& world, RobotProfile profile)
    : world_(world),
      profile_(std::move(profile)),
      features_(features_of(profile_)),
      truth_(world.scene_, profile_.body, world.physics_, world.state_) {
  reset();
}

void MujocoPort::disconnect() {
  connected_ = false;
  state_.command = {};
  state_.arrivals.clear();
}

std::vector<Sample> MujocoPort::poll() {
  if (!connected_) throw ConnectionError(fmt::format("{}: poll() needs connect() first", profile_.name));
  auto& arrivals = state_.arrivals;
  const auto arrived = std::ranges::find_if(arrivals, [&](const auto& arrival) { return arrival.time > world_.now(); });
  std::vector<Sample> samples;
  for (auto arrival = arrivals.begin(); arrival != arrived; ++arrival) {
    Sample& sample = samples.emplace_back(std::move(arrival->sample));
    sample.sequence = state_.sequences[sample.sensor]++;
    sample.received = world_.now();
  }
  arrivals.erase(arrivals.begin(), arrived);
  return samples;
}

void MujocoPort::command(const Velocity& velocity, Time valid_until) {
  if (!connected_) throw ConnectionError(fmt::format("{}: command() needs connect() first", profile_.name));
  if (!is_finite(velocity)) {
    throw ContractError(fmt::format("{}: a velocity of ({}, {}, {}) is not finite", profile_.name, velocity.vx,
                                    velocity.vy, velocity.omega));
  }
  if (profile_.kinematics() == Kinematics::differential && velocity.vy != 0.0) {
    throw ContractError(
        fmt::format("{}: vy is {} m/s, but a differential base cannot drive sideways", profile_.name, velocity.vy));
  }
  state_.command = velocity;
  state_.valid_until = valid_until;
}

void MujocoPort::send(std::size_t sensor, Time measured, Duration latency, SampleData data) {
  const Time arrival = world_.state_.time() + latency;
  // what arrives at one moment keeps the order in which it was sent
  const auto later = std::ranges::find_if(state_.arrivals, [&](const auto& other) { return other.time > arrival; });
  state_.arrivals.insert(later, {arrival, {static_cast<std::uint16_t>(sensor), 0, measured, {}, std::move(data)}});
}

void MujocoPort::collect() {
  if (!connected_) return;
  const RobotState& state = world_.state_;
  const RobotModel& robot = world_.robot_;
  const RobotProfile& simulated = robot.profile;
  const auto pinged = ping_ready(robot, state);
  std::size_t ultrasonic = 0;  // sensors of that kind so far
  for (std::size_t i = 0; i < features_.sensors.size(); ++i) {
    switch (features_.sensors[i].type) {
      case SensorType::lidar:
        if (scan_ready(robot, state)) {
          const LidarSpec& lidar = *simulated.lidar;
          send(i, models::scan_time(lidar, state.time() - lidar.turn), lidar.latency,
               models::make_scan(lidar, scan_points(robot, state)));
        }
        break;
      case SensorType::imu:
        if (imu_ready(robot, state)) send(i, state.time(), simulated.imu->latency, state.imu);
        break;
      case SensorType::odometry:
        if (odometry_ready(robot, state)) send(i, state.time(), simulated.odometry.latency, state.odometry.reading);
        break;
      case SensorType::battery:
        if (battery_ready(robot, state)) send(i, state.time(), Duration::zero(), state.battery);
        break;
      case SensorType::ultrasonic:
        if (pinged == ultrasonic++) {
          const UltrasonicSpec& spec = *simulated.ultrasonics;
          send(i, state.time(), spec.latency, models::range_data(spec, state.ultrasonic_range));
        }
        break;
      case SensorType::camera: break;
    }
  }
}

void MujocoPort::reset() {
  state_ = {};
  state_.sequences.assign(features_.sensors.size(), 0);
}

void PortState::save(ByteWriter& bytes) const {
  bytes.put(command);
  bytes.put(valid_until);
  for (const std::uint64_t sequence : sequences) bytes.put(sequence);
  bytes.put(std::uint64_t{arrivals.size()});
  for (const Arrival& arrival : arrivals) {
    bytes.put(arrival.time);
    bytes.put(arrival.sample);
  }
}

void PortState::load(ByteReader& bytes, std::size_t sensors) {
  bytes.get(command);
  bytes.get(valid_until);
  sequences.resize(sensors);
  for (std::uint64_t& sequence : sequences) bytes.get(sequence);
  arrivals.resize(bytes.get_size());
  for (Arrival& arrival : arrivals) {
    bytes.get(arrival.time);
    bytes.get(arrival.sample);
  }
}

}  // namespace threewe::backend::mujoco
