#include "backend/mock/mock_port.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "threewe/core/errors.hpp"
#include "threewe/models/lidar.hpp"
#include "threewe/models/ultrasonic.hpp"
#include "threewe/sim/camera.hpp"
#include "threewe/sim/step.hpp"

namespace threewe::backend::mock {
namespace {

SensorInfo sensor_info(SensorType type, Duration period) {
  return {std::string(to_string(type)), type, 1.0 / to_seconds(period)};
}

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

}  // namespace

MockPort::MockPort(const MockWorld& world, std::size_t index, RobotProfile profile)
    : world_(world),
      index_(index),
      profile_(std::move(profile)),
      features_(features_of(profile_)),
      truth_(world.model_, index, world.states_, world.people_) {
  reset();
}

void MockPort::connect() { connected_ = true; }

void MockPort::disconnect() {
  connected_ = false;
  state_.command = {};
  state_.arrivals.clear();
}

std::vector<Sample> MockPort::poll() {
  if (!connected_) throw ConnectionError(fmt::format("{}: poll() needs connect() first", profile_.name));
  auto& arrivals = state_.arrivals;
  const auto arrived = std::ranges::find_if(arrivals, [&](const auto& arrival) { return arrival.time > world_.now(); });
  std::vector<Sample> samples;
  for (auto arrival = arrivals.begin(); arrival != arrived; ++arrival) {
    Sample& sample = samples.emplace_back(std::move(arrival->sample));
    if (arrival->shot) sample.data = picture_of(std::move(*arrival->shot));
    sample.sequence = state_.sequences[sample.sensor]++;
    sample.received = world_.now();
  }
  arrivals.erase(arrivals.begin(), arrived);
  return samples;
}

void MockPort::command(const Velocity& velocity, Time valid_until) {
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

Picture MockPort::picture_of(sim::Shot shot) const {
  return Picture([model = world_.model_, shot = std::move(shot)] { return sim::draw_picture(*model, shot); });
}

void MockPort::send(std::size_t sensor, Time measured, Duration latency, SampleData data,
                    std::optional<sim::Shot> shot) {
  const Time arrival = world_.states_[index_].time() + latency;
  // what arrives at one moment keeps the order in which it was sent
  const auto later = std::ranges::find_if(state_.arrivals, [&](const auto& other) { return other.time > arrival; });
  state_.arrivals.insert(
      later, {arrival, {static_cast<std::uint16_t>(sensor), 0, measured, {}, std::move(data)}, std::move(shot)});
}

void MockPort::collect() {
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
             sim::varied_latency(lidar.latency, state.variation),
             models::make_scan(lidar, sim::scan_points(robot, state)));
        break;
      }
      case SensorType::imu:
        if (sim::imu_ready(robot, state)) send(i, state.time(), simulated.imu->latency, state.imu);
        break;
      case SensorType::odometry:
        if (sim::odometry_ready(robot, state)) {
          send(i, state.time(), simulated.odometry.latency, state.odometry.reading);
        }
        break;
      case SensorType::battery:
        if (sim::battery_ready(robot, state)) send(i, state.time(), Duration::zero(), state.battery);
        break;
      case SensorType::ultrasonic:
        if (pinged == ultrasonic++) {
          const UltrasonicSpec& spec = *simulated.ultrasonics;
          send(i, state.time(), spec.latency, models::range_data(spec, state.ultrasonic_range));
        }
        break;
      case SensorType::camera:
        if (sim::picture_ready(robot, state)) {
          send(i, state.time(), sim::varied_latency(simulated.camera->latency, state.variation), Picture(),
               sim::take_shot(world_.states_, world_.people_, index_));
        }
        break;
    }
  }
}

void MockPort::reset() {
  state_ = {};
  state_.sequences.assign(features_.sensors.size(), 0);
}

namespace {

void put(ByteWriter& bytes, const sim::Shot& shot) {
  bytes.put(shot.key.seed);
  bytes.put(shot.key.episode);
  bytes.put(shot.key.robot);
  bytes.put(shot.step);
  bytes.put(shot.variation);
  bytes.put(shot.robots);
  bytes.put(shot.people);
}

void get(ByteReader& bytes, sim::Shot& shot) {
  shot.key.stream = Stream::camera;
  bytes.get(shot.key.seed);
  bytes.get(shot.key.episode);
  bytes.get(shot.key.robot);
  bytes.get(shot.step);
  bytes.get(shot.variation);
  bytes.get(shot.robots);
  bytes.get(shot.people);
}

}  // namespace

void PortState::save(ByteWriter& bytes) const {
  bytes.put(command);
  bytes.put(valid_until);
  for (const std::uint64_t sequence : sequences) bytes.put(sequence);
  bytes.put(std::uint64_t{arrivals.size()});
  for (const Arrival& arrival : arrivals) {
    bytes.put(arrival.time);
    bytes.put(arrival.sample);
    if (arrival.shot) put(bytes, *arrival.shot);
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
    if (std::holds_alternative<Picture>(arrival.sample.data)) get(bytes, arrival.shot.emplace());
  }
}

}  // namespace threewe::backend::mock
