#include "backend/simulated/port.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "models/lidar.hpp"
#include "models/ultrasonic.hpp"
#include "sim/step.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::backend::simulated {
namespace {

SensorInfo sensor_info(SensorType type, Duration period) {
  return {std::string(to_string(type)), type, 1.0 / to_seconds(period)};
}

}  // namespace

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
  if (profile.camera) features.sensors.push_back(sensor_info(SensorType::camera, profile.camera->period));
  return features;
}

namespace {

void put(ByteWriter& bytes, const WorldCapture& capture) {
  const sim::CapturePose& state = capture.state;
  bytes.put(state.key.seed);
  bytes.put(state.key.episode);
  bytes.put(state.key.robot);
  bytes.put(state.step);
  bytes.put(state.variation);
  bytes.put(state.robots);
  bytes.put(state.people);
  bytes.put(capture.physics);
}

WorldCapture get_capture(ByteReader& bytes) {
  WorldCapture capture;
  sim::CapturePose& state = capture.state;
  state.key.stream = Stream::camera;
  bytes.get(state.key.seed);
  bytes.get(state.key.episode);
  bytes.get(state.key.robot);
  bytes.get(state.step);
  bytes.get(state.variation);
  bytes.get(state.robots);
  bytes.get(state.people);
  bytes.get(capture.physics);
  return capture;
}

}  // namespace

Port::Port(const SimulatedWorld& world, std::size_t index, const RobotProfile& profile)
    : world_(world), index_(index), profile_(profile), features_(features_of(profile)) {
  reset();
}

void Port::disconnect() {
  connected_ = false;
  state_.command = {};
  state_.arrivals.clear();
}

std::vector<Sample> Port::poll() {
  require_connection("poll");
  auto& arrivals = state_.arrivals;
  const auto arrived =
      std::ranges::find_if(arrivals, [&](const State::Arrival& arrival) { return arrival.time > world_.now(); });
  std::vector<Sample> samples;
  for (auto arrival = arrivals.begin(); arrival != arrived; ++arrival) {
    Sample& sample = samples.emplace_back(std::move(arrival->sample));
    if (arrival->capture) sample.data = world_.engine_->picture(std::move(*arrival->capture));
    sample.sequence = state_.sequences[sample.sensor]++;
    sample.received = world_.now();
  }
  arrivals.erase(arrivals.begin(), arrived);
  return samples;
}

void Port::command(const Velocity& velocity, Time valid_until) {
  require_connection("command");
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

void Port::collect() {
  if (!connected_) return;
  const sim::RobotState& state = world_.states_[index_];
  const sim::RobotModel& robot = world_.model_->robots[index_];
  const RobotProfile& simulated = robot.profile;
  const auto pinged = sim::ping_ready(robot, state);
  std::size_t ultrasonic = 0;  // sensors of that kind so far
  for (std::size_t i = 0; i < features_.sensors.size(); ++i) {
    switch (features_.sensors[i].type) {
      case SensorType::lidar: {
        if (!sim::scan_ready(robot, state)) break;
        const LidarSpec& lidar = *simulated.lidar;
        send(i, models::scan_time(lidar, state.time() - lidar.turn),
             state.time() + sim::varied_latency(lidar.latency, state.variation),
             models::make_scan(lidar, sim::scan_points(robot, state)));
        break;
      }
      case SensorType::imu:
        if (sim::imu_ready(robot, state)) send(i, state.time(), state.time() + simulated.imu->latency, state.imu);
        break;
      case SensorType::odometry:
        if (sim::odometry_ready(robot, state)) {
          send(i, state.time(), state.time() + simulated.odometry.latency, state.odometry.reading);
        }
        break;
      case SensorType::battery:
        if (sim::battery_ready(robot, state)) send(i, state.time(), state.time(), state.battery);
        break;
      case SensorType::ultrasonic:
        if (pinged == ultrasonic++) {
          const UltrasonicSpec& spec = *simulated.ultrasonics;
          send(i, state.time(), state.time() + spec.latency, models::range_data(spec, state.ultrasonic_range));
        }
        break;
      case SensorType::camera:
        if (sim::picture_ready(robot, state)) {
          send(i, state.time(), state.time() + sim::varied_latency(simulated.camera->latency, state.variation),
               Picture(), world_.capture(index_));
        }
        break;
    }
  }
}

// What arrives at one moment keeps the order in which it was sent.
void Port::send(std::size_t sensor, Time measured, Time arrival, SampleData data, std::optional<WorldCapture> capture) {
  const auto later = std::ranges::find_if(state_.arrivals, [&](const auto& other) { return other.time > arrival; });
  state_.arrivals.insert(
      later, {arrival, {static_cast<std::uint16_t>(sensor), 0, measured, {}, std::move(data)}, std::move(capture)});
}

void Port::reset() {
  state_ = {};
  state_.sequences.assign(features_.sensors.size(), 0);
}

void Port::save(ByteWriter& bytes) const {
  bytes.put(state_.command);
  bytes.put(state_.valid_until);
  for (const std::uint64_t sequence : state_.sequences) bytes.put(sequence);
  bytes.put(std::uint64_t{state_.arrivals.size()});
  for (const auto& [time, sample, capture] : state_.arrivals) {
    bytes.put(time);
    bytes.put(sample);
    if (capture) put(bytes, *capture);
  }
}

Port::State Port::load(ByteReader& bytes) const {
  State state;
  bytes.get(state.command);
  bytes.get(state.valid_until);
  state.sequences.assign(features_.sensors.size(), 0);
  for (std::uint64_t& sequence : state.sequences) bytes.get(sequence);
  state.arrivals.resize(bytes.get_size());
  for (auto& [time, sample, capture] : state.arrivals) {
    bytes.get(time);
    bytes.get(sample);
    if (std::holds_alternative<Picture>(sample.data)) capture = get_capture(bytes);
  }
  return state;
}

void Port::require_connection(const char* call) const {
  if (!connected_) throw ConnectionError(fmt::format("{}: {}() needs connect() first", profile_.name, call));
}

}  // namespace threewe::backend::simulated
