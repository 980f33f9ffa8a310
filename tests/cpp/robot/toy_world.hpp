// The smallest complete backend: robots that obey at once in an empty square room, with perfect sensors. No scene, no
// truth service, and every fault a test may wish for.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "backend/delegation.hpp"
#include "core/exact.hpp"
#include "threewe/backend/world.hpp"
#include "threewe/core/errors.hpp"
#include "threewe/hardware/profile.hpp"
#include "threewe/robot/world.hpp"

namespace threewe::test {

class ToyPort final : public backend::RobotPort {
 public:
  static constexpr double kRoom = 4.0;  // [m] from the middle to each wall
  enum Sensor : std::uint16_t { kImu, kOdometry, kBattery, kLidar };

  /// `hardware`: a profile's name, or "blind" for the standard robot without anything that looks.
  ToyPort(const std::string& hardware, const Pose2D& start) : pose(start), start_(start) {
    profile_ = load_profile(hardware == "blind" ? "3we_standard_v2" : hardware);
    features_ = {.sensors = {{"imu", SensorType::imu, 50.0},
                             {"odometry", SensorType::odometry, 50.0},
                             {"battery", SensorType::battery, 10.0},
                             {"lidar", SensorType::lidar, 10.0}},
                 .kinematics = profile_.kinematics(),
                 .lockstep = true,
                 .deterministic = true};
    if (hardware == "blind") {
      profile_.name = hardware;
      profile_.lidar.reset();
      profile_.ultrasonics.reset();
      features_.sensors.pop_back();
    }
  }

  const backend::Features& features() const override { return features_; }
  const RobotProfile& profile() const override { return profile_; }
  void connect() override {
    connected_ = true;
    if (on_connect) on_connect();
  }
  void disconnect() override { connected_ = false; }

  std::vector<Sample> poll() override {
    if (!connected_) throw ConnectionError("not connected");
    if (on_poll) on_poll(now_);
    for (Sample& sample : arrived_) sample.received = now_;
    if (on_samples) on_samples(arrived_);
    return std::exchange(arrived_, {});
  }

  void command(const Velocity& velocity, Time valid_until) override {
    if (!connected_) throw ConnectionError("not connected");
    if (on_command) on_command(now_);
    commands.push_back(velocity);
    command_ = velocity;
    valid_until_ = valid_until;
  }

  backend::ExternalLocalizer& delegate_localization(std::string_view program,
                                                    const std::optional<Pose2D>& map_from_start) override {
    if (localizer == nullptr) return RobotPort::delegate_localization(program, map_from_start);
    return *localizer;
  }
  backend::ExternalNavigator& delegate_navigation(std::string_view program) override {
    if (navigator == nullptr) return RobotPort::delegate_navigation(program);
    return *navigator;
  }

  std::string link_fault() const override { return wrong_link; }

  void advance(Time t) {
    while (now_ < t) {
      now_ += 10ms;
      velocity_ = pushed != Velocity{} ? pushed : now_ <= valid_until_ ? command_ : Velocity{};
      pose = integrate(pose, velocity_, 0.01);
      if (now_ % 20ms == 0ms) deliver(kImu, IMUData{{0.0, 0.0, velocity_.omega}, {0.0, 0.0, 9.81}});
      if (now_ % 20ms == 0ms) deliver(kOdometry, Odometry{inverse(start_) * pose, velocity_});
      if (now_ % 100ms == 0ms && profile_.lidar) deliver(kLidar, scan());
      if (now_ % 100ms == 0ms) deliver(kBattery, BatteryState{8.0, 1.0, 0.9});
    }
  }

  /// Time goes by on its own; before a world is made of it.
  void run_by_itself() { features_.lockstep = features_.deterministic = false; }

  std::string wrong_link;
  Pose2D pose;      // the truth
  Velocity pushed;  // by another program, while ours commands nothing
  backend::ExternalLocalizer* localizer = nullptr;
  backend::ExternalNavigator* navigator = nullptr;
  std::vector<Velocity> commands;  // all there were
  std::vector<bool> silent = {false, false, false, false};
  std::function<void()> on_connect;
  std::function<void(Time)> on_poll;
  std::function<void(Time)> on_command;
  std::function<void(std::vector<Sample>&)> on_samples;

 private:
  void deliver(Sensor sensor, SampleData data) {
    if (silent[sensor]) return;
    arrived_.push_back({sensor, sequence_[sensor]++, now_, now_, std::move(data)});
  }

  LaserScan scan() const {
    const LidarSpec& spec = *profile_.lidar;
    LaserScan s;
    s.angle_min = -exact::kPi;
    s.angle_increment = 2.0 * exact::kPi / spec.beams;
    s.range_min = spec.range_min;
    s.range_max = spec.range_max;
    const Pose2D lidar = pose * spec.base_from_lidar;
    for (int i = 0; i < spec.beams; ++i) {
      const double angle = lidar.theta + s.angle_min + i * s.angle_increment;
      const auto to_wall = [](double from, double direction) {
        if (direction == 0.0) return std::numeric_limits<double>::infinity();
        return ((direction > 0.0 ? kRoom : -kRoom) - from) / direction;
      };
      s.ranges.push_back(
          static_cast<float>(std::min(to_wall(lidar.x, std::cos(angle)), to_wall(lidar.y, std::sin(angle)))));
    }
    return s;
  }

  RobotProfile profile_;
  backend::Features features_;
  Pose2D start_;
  bool connected_ = false;
  Time now_{};
  Velocity velocity_;
  Velocity command_;
  Time valid_until_{};
  std::vector<Sample> arrived_;
  std::array<std::uint64_t, 4> sequence_{};
};

class ToyWorld final : public backend::World {
 public:
  explicit ToyWorld(const std::vector<std::string>& robots = {"3we_standard_v2"}) {
    for (std::size_t i = 0; i < robots.size(); ++i) {
      ports.push_back(std::make_unique<ToyPort>(robots[i], Pose2D{0.0, static_cast<double>(i), 0.0}));
    }
  }
  std::size_t robot_count() const override { return ports.size(); }
  ToyPort& robot(std::size_t index) override { return *ports[index]; }
  Time now() const override { return now_; }
  void advance_to(Time t) override {
    if (on_advance) on_advance(t);
    for (const auto& port : ports) port->advance(t);
    now_ = t;
  }
  /// Time that goes by while nobody asks.
  void pass(Duration duration) { now_ += duration; }

  std::vector<std::unique_ptr<ToyPort>> ports;
  std::function<void(Time)> on_advance;

 private:
  Time now_{};
};

/// A World over a ToyWorld that the test keeps in reach.
struct Toy {
  explicit Toy(const std::vector<std::string>& robots = {"3we_standard_v2"}, const Autonomy& autonomy = {},
               const std::vector<Pose2D>& initial_poses = {}, bool realtime = false) {
    auto owned = std::make_unique<ToyWorld>(robots);
    backend = owned.get();
    world = std::make_unique<World>(std::move(owned), realtime, autonomy, initial_poses);
  }
  ToyPort& port(std::size_t index = 0) { return backend->robot(index); }

  ToyWorld* backend = nullptr;
  std::unique_ptr<World> world;
};

}  // namespace threewe::test
