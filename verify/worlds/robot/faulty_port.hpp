// A robot whose sensors and wheels break for a while, as they do in life: between any backend and the runtime.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <deque>
#include <limits>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "core/rng.hpp"
#include "threewe/backend/world.hpp"
#include "threewe/core/kinematics.hpp"

namespace threewe::test {

/// How something breaks. The last three concern the wheels, whichever sensor is named.
enum class FaultKind : std::uint8_t {
  silent,
  frozen,
  nan,
  stamps_back,
  stamps_ahead,
  noise,
  bias,
  delay,
  delay_restamped,  ///< late, and stamped as if it were not
  dropout,          ///< beams are invalid here and there
  covered,          ///< beams within a sector are invalid
  slip,             ///< the robot moves half as far as its wheels, which turn as they are told
  wheel_slip,       ///< one wheel turns by half more than it should
  wheel_blocked     ///< one wheel does not turn
};
inline constexpr std::array<const char*, 14> kFaultNames = {
    "silent", "frozen",          "nan",     "stamps_back", "stamps_ahead", "noise",      "bias",
    "delay",  "delay_restamped", "dropout", "covered",     "slip",         "wheel_slip", "wheel_blocked"};

/// One thing that breaks, from when until when. `size`: of the jump of stamps [s], the noise (times what is usual), the
/// bias ([m] of a range, [rad/s] of a gyro), the delay [s], the share of beams that drop out, the sector [rad] that is
/// covered.
struct InjectedFault {
  FaultKind kind{};
  std::uint16_t sensor = 0;
  double size = 0.0;
  Time from = Time::max();
  Time until = Time::max();
  std::size_t wheel = 0;
  double bearing = 0.0;  // [rad] of the middle of the sector
  std::uint64_t seed = 0;

  bool holds(Time t) const { return from <= t && t < until; }
};

/// A port with such faults.
class FaultyPort final : public backend::RobotPort {
 public:
  explicit FaultyPort(backend::RobotPort& port) : port_(port) {}
  const backend::Features& features() const override { return port_.features(); }
  const RobotProfile& profile() const override { return port_.profile(); }
  void connect() override { port_.connect(); }
  void disconnect() override { port_.disconnect(); }

  /// What breaks from now on. Nothing is left of faults before.
  void break_with(std::vector<InjectedFault> faults) {
    faults_ = std::move(faults);
    frozen_.clear();
    late_.clear();
    rolled_.clear();
  }
  void tell_time(Time now) { now_ = now; }

  std::vector<Sample> poll() override {
    std::vector<Sample> samples = port_.poll();
    for (const InjectedFault& fault : faults_) {
      std::vector<Sample> spoiled;
      for (Sample& sample : samples) {
        if (sample.sensor != place_of(fault)) {
          spoiled.push_back(std::move(sample));
        } else {
          spoil(fault, std::move(sample), spoiled);
        }
      }
      deliver_late(fault, spoiled);
      samples = std::move(spoiled);
    }
    return samples;
  }

  void command(const Velocity& velocity, Time valid_until) override {
    Velocity obeyed = velocity;
    for (const InjectedFault& fault : faults_) {
      if (!fault.holds(now_)) continue;
      if (fault.kind == FaultKind::slip) obeyed = {0.5 * obeyed.vx, 0.5 * obeyed.vy, obeyed.omega};
      if (fault.kind == FaultKind::wheel_blocked) {
        WheelSpeeds speeds = wheel_speeds(profile().body.wheels, obeyed);
        speeds[fault.wheel % static_cast<std::size_t>(profile().body.wheels.wheel_count())] = 0.0;
        obeyed = body_velocity(profile().body.wheels, speeds);
      }
    }
    port_.command(obeyed, valid_until);
  }

 private:
  using Kind = FaultKind;

  std::uint16_t place_of(const InjectedFault& fault) const {
    if (fault.kind < Kind::slip) return fault.sensor;
    const auto& sensors = features().sensors;
    for (std::size_t i = 0; i < sensors.size(); ++i) {
      if (sensors[i].type == SensorType::odometry) return static_cast<std::uint16_t>(i);
    }
    return std::numeric_limits<std::uint16_t>::max();
  }

  // A sample of the sensor that breaks: as it comes out, if it does.
  void spoil(const InjectedFault& fault, Sample sample, std::vector<Sample>& out) {
    const Sample honest = sample;
    const bool holds = fault.holds(sample.received);
    switch (fault.kind) {
      case Kind::silent:
        if (holds) return;
        break;
      case Kind::frozen:
        if (holds) sample.data = frozen_.try_emplace(&fault, sample.data).first->second;
        break;
      case Kind::nan:
        if (holds) make_nan(sample);
        break;
      case Kind::stamps_back:
        if (holds) sample.measured -= from_seconds(fault.size);
        break;
      case Kind::stamps_ahead:
        if (holds) sample.measured += from_seconds(fault.size);
        break;
      case Kind::noise:
        if (holds) make_noisy(fault, sample);
        break;
      case Kind::bias:
        if (holds) make_biased(fault, sample);
        break;
      case Kind::delay:
      case Kind::delay_restamped:
        if (!holds) break;
        late_[&fault].push_back(std::move(sample));
        return;
      case Kind::dropout:
        if (holds) drop_out(fault, sample);
        break;
      case Kind::covered:
        if (holds) cover(fault, sample);
        break;
      case Kind::slip:
      case Kind::wheel_slip: roll_on(fault, sample); break;
      case Kind::wheel_blocked: break;
    }
    if (!holds) frozen_.insert_or_assign(&fault, honest.data);
    out.push_back(std::move(sample));
  }

  void deliver_late(const InjectedFault& fault, std::vector<Sample>& out) {
    std::deque<Sample>& late = late_[&fault];
    while (!late.empty() && late.front().received + from_seconds(fault.size) <= now_) {
      Sample sample = std::move(late.front());
      late.pop_front();
      if (!fault.holds(now_)) continue;  // what is still on its way when all is well again is lost
      if (fault.kind == Kind::delay_restamped) sample.measured += now_ - sample.received;
      sample.received = now_;
      out.push_back(std::move(sample));
    }
  }

  static void make_nan(Sample& sample) {
    constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
    if (auto* scan = std::get_if<LaserScan>(&sample.data)) scan->ranges[scan->ranges.size() / 3] = NAN;
    if (auto* imu = std::get_if<IMUData>(&sample.data)) imu->angular_velocity[2] = kNan;
    if (auto* odometry = std::get_if<Odometry>(&sample.data)) odometry->pose.x = kNan;
    if (auto* battery = std::get_if<BatteryState>(&sample.data)) battery->voltage = kNan;
    if (auto* echo = std::get_if<RangeData>(&sample.data)) echo->range = kNan;
  }

  double scatter(const InjectedFault& fault, const Sample& sample, std::uint32_t lane) const {
    return normal({.seed = fault.seed, .sensor = sample.sensor}, sample.sequence, lane);
  }

  // Adds what is missing to `size` times the usual scatter.
  void make_noisy(const InjectedFault& fault, Sample& sample) const {
    const double more = std::sqrt(fault.size * fault.size - 1.0);
    if (auto* scan = std::get_if<LaserScan>(&sample.data)) {
      const LidarSpec& spec = *profile().lidar;
      for (std::uint32_t i = 0; i < scan->ranges.size(); ++i) {
        move_range(spec, more * spec.sigma * scatter(fault, sample, i), scan->ranges[i]);
      }
    }
    if (auto* imu = std::get_if<IMUData>(&sample.data)) {
      for (std::uint32_t i = 0; i < 3; ++i) {
        imu->angular_velocity[i] += more * profile().imu->gyro_sigma * scatter(fault, sample, i);
        imu->linear_acceleration[i] += more * profile().imu->accelerometer_sigma * scatter(fault, sample, 3 + i);
      }
    }
    if (auto* echo = std::get_if<RangeData>(&sample.data)) {
      const UltrasonicSpec& spec = *profile().ultrasonics;
      if (echo->range > spec.range_min && echo->range < spec.range_max)
        echo->range =
            std::clamp(echo->range + more * spec.sigma * scatter(fault, sample, 0), spec.range_min, spec.range_max);
    }
  }

  static void move_range(const LidarSpec& spec, double by, float& range) {
    const auto metres = static_cast<double>(range);
    if (metres <= 0.0 || metres >= spec.range_max) return;
    range = static_cast<float>(std::clamp(metres + by, spec.range_min, spec.range_max));
  }

  void make_biased(const InjectedFault& fault, Sample& sample) const {
    if (auto* scan = std::get_if<LaserScan>(&sample.data)) {
      for (float& range : scan->ranges) move_range(*profile().lidar, fault.size, range);
    }
    if (auto* imu = std::get_if<IMUData>(&sample.data)) imu->angular_velocity[2] += fault.size;
  }

  static void drop_out(const InjectedFault& fault, Sample& sample) {
    auto& scan = std::get<LaserScan>(sample.data);
    const RngKey key{.seed = fault.seed, .sensor = sample.sensor};
    for (std::uint32_t i = 0; i < scan.ranges.size(); ++i) {
      if (uniform(key, sample.sequence, i, 0.0, 1.0) < fault.size) scan.ranges[i] = 0.0F;
    }
  }

  void cover(const InjectedFault& fault, Sample& sample) const {
    auto& scan = std::get<LaserScan>(sample.data);
    for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
      const double angle = scan.angle_min + static_cast<double>(i) * scan.angle_increment;
      const double off = wrap_angle(profile().lidar->base_from_lidar.theta + angle - fault.bearing);
      if (std::abs(off) <= 0.5 * fault.size) scan.ranges[i] = 0.0F;
    }
  }

  // Wheels that count more than the robot goes.
  void roll_on(const InjectedFault& fault, Sample& sample) {
    auto* odometry = std::get_if<Odometry>(&sample.data);
    if (odometry == nullptr) return;
    auto [it, is_first] = rolled_.try_emplace(&fault, Rolled{*odometry, odometry->pose});
    Rolled& rolled = it->second;
    const Pose2D step = inverse(rolled.honest.pose) * odometry->pose;
    rolled.honest = *odometry;
    if (fault.holds(sample.received)) odometry->velocity = slipping(fault, odometry->velocity);
    const double period = 1.0 / features().sensors[sample.sensor].rate;
    rolled.pose = fault.holds(sample.received) ? integrate(rolled.pose, odometry->velocity, is_first ? 0.0 : period)
                                               : rolled.pose * step;
    odometry->pose = rolled.pose;
  }

  Velocity slipping(const InjectedFault& fault, const Velocity& v) const {
    if (fault.kind == Kind::slip) return {2.0 * v.vx, 2.0 * v.vy, v.omega};
    WheelSpeeds speeds = wheel_speeds(profile().body.wheels, v);
    speeds[fault.wheel % static_cast<std::size_t>(profile().body.wheels.wheel_count())] *= 1.5;
    return body_velocity(profile().body.wheels, speeds);
  }

  struct Rolled {
    Odometry honest;
    Pose2D pose;
  };
  backend::RobotPort& port_;
  Time now_{};
  std::vector<InjectedFault> faults_;
  std::map<const InjectedFault*, SampleData> frozen_;
  std::map<const InjectedFault*, std::deque<Sample>> late_;
  std::map<const InjectedFault*, Rolled> rolled_;
};

/// A world of such robots.
class WorldOfFaults final : public backend::World {
 public:
  explicit WorldOfFaults(std::unique_ptr<backend::World> world) : world_(std::move(world)) {
    for (std::size_t i = 0; i < world_->robot_count(); ++i) ports_.emplace_back(world_->robot(i));
  }
  std::size_t robot_count() const override { return ports_.size(); }
  FaultyPort& robot(std::size_t index) override { return ports_.at(index); }
  const backend::TruthService* truth_service() const override { return world_->truth_service(); }
  Time now() const override { return world_->now(); }
  void advance_to(Time t) override {
    world_->advance_to(t);
    for (FaultyPort& port : ports_) port.tell_time(t);
  }
  void reset(const backend::ResetOptions& options) override {
    world_->reset(options);
    for (FaultyPort& port : ports_) port.tell_time(world_->now());
  }

 private:
  std::unique_ptr<backend::World> world_;
  std::deque<FaultyPort> ports_;
};

}  // namespace threewe::test
