#include "perception/health_monitor.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "core/exact.hpp"
#include "hardware/sample_checks.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::perception {
namespace {

// What the autonomy stack uses; the rest may break without harm.
bool is_needed(SensorType type, const RobotProfile& profile) {
  switch (type) {
    case SensorType::lidar:
    case SensorType::imu:
    case SensorType::odometry: return true;
    case SensorType::ultrasonic: return !profile.lidar;
    default: return false;
  }
}

Velocity rotated(const Velocity& v, double angle) {
  const Vec2 linear = rotate({v.vx, v.vy}, angle);
  return {linear.x, linear.y, v.omega};
}

}  // namespace

HealthMonitor::HealthMonitor(std::span<const SensorInfo> sensors, const RobotProfile& profile, const Params& params)
    : params_(params.monitor),
      new_stamps_(params.stamps),
      new_repeats_(params.repeats),
      scan_(profile.lidar ? profile.lidar->sigma : 0.0, params.scan),
      blind_(profile.lidar ? BlindCheck(profile, params.blind) : BlindCheck()),
      turn_(profile, params.turn),
      drive_(profile, params.drive),
      way_(params.slip),
      lidar_heading_(profile.lidar ? profile.lidar->base_from_lidar.theta : 0.0) {
  for (const SensorInfo& sensor : sensors) {
    sensors_.push_back({sensor.name, SensorFault::none, "", {}, is_needed(sensor.type, profile)});
    Watch watch{.type = sensor.type, .stamps = new_stamps_, .repeats = new_repeats_};
    watch.patience = std::max(params_.least_patience, from_seconds(1.5 / sensor.rate) + 50ms);
    watches_.push_back(watch);
  }
}

void HealthMonitor::begin(Time now) {
  begun_ = now_ = now;
  for (std::size_t i = 0; i < watches_.size(); ++i) {
    watches_[i] = {
        .type = watches_[i].type, .patience = watches_[i].patience, .stamps = new_stamps_, .repeats = new_repeats_};
    sensors_[i] = {sensors_[i].name, SensorFault::none, "", now, sensors_[i].needed};
  }
  changes_.clear();
  drive_.begin();
}

bool HealthMonitor::examine(const Sample& sample, std::span<const SensorInfo> sensors, const RobotProfile& profile) {
  now_ = sample.received;
  Watch& watch = watches_.at(sample.sensor);
  watch.received = sample.received;
  try {
    check_data(sensors[sample.sensor], sample.data, profile);
  } catch (const ContractError& error) {
    const std::string text = error.what();  // "sensor 'imu': what is wrong"
    report(sample.sensor, SensorFault::implausible, text.substr(text.find("': ") + 3), params_.ok_after);
    return false;
  }
  const Finding found = check(watch, sample);
  if (found.fault != SensorFault::none) report(sample.sensor, found.fault, found.detail, params_.ok_after);
  return sensors_[sample.sensor].ok() || watch.believed;
}

// Everything that one sensor's samples tell about it.
HealthMonitor::Finding HealthMonitor::check(Watch& watch, const Sample& sample) {
  const SensorFault stamps = watch.stamps.check(sample.measured, sample.received);
  if (stamps != SensorFault::none) return {stamps};
  Motion motion = this->motion();
  if (watch.type == SensorType::lidar) motion.velocity = rotated(motion.velocity, -lidar_heading_);
  if (watch.repeats.is_frozen(sample.data, motion)) return {SensorFault::frozen};
  if (const auto* scan = std::get_if<LaserScan>(&sample.data)) return check_scan(sample.measured, *scan);
  if (const auto* imu = std::get_if<IMUData>(&sample.data)) {
    gyro_rate_ = imu->angular_velocity[2];
    turn_.add_gyro(sample.measured, gyro_rate_);
  }
  if (const auto* odometry = std::get_if<Odometry>(&sample.data)) {
    wheels_ = *odometry;
    if (const auto off = turn_.add_odometry(sample.measured, *odometry)) turn_off_ = off;
  }
  return {};
}

HealthMonitor::Finding HealthMonitor::check_scan(Time measured, const LaserScan& scan) {
  constexpr double kDegree = exact::kPi / 180.0;
  const Pose2D at = wheels_ ? wheels_->pose : Pose2D{};
  const auto blind = blind_.check(scan, at);
  if (!blind) return {scan_.check(measured, scan, at)};
  return {SensorFault::blind,
          fmt::format("no beam is valid from {:.0f} to {:.0f} degrees", blind->from / kDegree, blind->to / kDegree)};
}

void HealthMonitor::judge(Time now, const Velocity& command, const slam::PoseEstimate& estimate) {
  now_ = now;
  for (std::size_t i = 0; i < watches_.size(); ++i) watch_silence(i);
  const bool standing = motion().still;

  if (turn_off_ && std::fabs(*turn_off_) > params_.contradiction) {
    // while the robot moves either may be right; wheels at rest are
    contradict(SensorType::imu, "gyro and wheels do not turn alike", !standing);
    if (!standing)
      contradict(SensorType::odometry, "wheels and gyro do not turn alike: a wheel slips, or is blocked", true);
  }
  turn_off_.reset();
  if (wheels_ && drive_.is_disobeyed(command, wheels_->velocity)) {
    contradict(SensorType::odometry, "the wheels do not turn as commanded: one is blocked, or slips", true);
  }
  if (way_.is_contradicted(estimate)) {
    contradict(SensorType::odometry, "the robot does not go as far as its wheels say: they slip", true);
  }
  for (std::size_t i = 0; i < watches_.size(); ++i) {
    if (sensors_[i].ok() || now < watches_[i].until) continue;
    sensors_[i].fault = SensorFault::none;
    sensors_[i].detail.clear();
    sensors_[i].since = watches_[i].ended = now;
    changes_.push_back(i);
  }
}

void HealthMonitor::watch_silence(std::size_t sensor) {
  const Watch& watch = watches_[sensor];
  const bool silent = watch.received ? now_ - *watch.received > watch.patience
                                     : now_ - begun_ > params_.first_patience + watch.patience;
  if (silent) report(sensor, SensorFault::silent, "", params_.ok_after);
}

// Something is wrong from now on, and for `hold` at least.
void HealthMonitor::report(std::size_t sensor, SensorFault fault, const std::string& detail, Duration hold,
                           bool believed) {
  SensorHealth& health = sensors_[sensor];
  Watch& watch = watches_[sensor];
  watch.until = std::max(watch.until, now_ + hold);
  watch.believed = believed && (health.ok() || watch.believed);
  if (!health.ok()) return;
  health.fault = fault;
  health.detail = detail;
  health.since = now_;
  changes_.push_back(sensor);
}

// What was noticed as the robot moved cannot be seen once it stands: it is tried again after a while, and after twice
// as long when that was no good.
void HealthMonitor::contradict(SensorType type, const std::string& detail, bool believed) {
  for (std::size_t i = 0; i < watches_.size(); ++i) {
    Watch& watch = watches_[i];
    if (watch.type != type) continue;
    if (sensors_[i].ok()) {
      const bool again = watch.penalty > 0ns && now_ - watch.ended < params_.longest_penalty;
      watch.penalty = again ? std::min(2 * watch.penalty, params_.longest_penalty) : params_.first_penalty;
    }
    report(i, SensorFault::contradicted, detail, std::max(watch.penalty, params_.ok_after), believed);
  }
}

// Whether the robot moves: any sensor that says so is believed, since a sensor that is frozen may not.
Motion HealthMonitor::motion() const {
  const auto believed = [this](SensorType type) {
    for (std::size_t i = 0; i < watches_.size(); ++i) {
      if (watches_[i].type == type) return sensors_[i].ok() || watches_[i].believed;
    }
    return false;
  };
  const bool wheels_known = wheels_ && believed(SensorType::odometry);
  const Velocity v = wheels_known ? wheels_->velocity : Velocity{};
  const bool rolls = exact::hypot(v.vx, v.vy) > params_.standing || std::fabs(v.omega) > params_.standing_turn;
  const bool turns = believed(SensorType::imu) && std::fabs(gyro_rate_) > params_.turning;
  const bool driven = drive_.commanded_to_drive();
  return {.moving = rolls || turns || driven,
          .driven = driven,
          .still = wheels_known && !rolls && !turns && drive_.commanded_to_stand(),
          .velocity = v};
}

const SensorHealth* HealthMonitor::blocking_sensor() const {
  const auto found = std::ranges::find_if(sensors_, [](const SensorHealth& s) { return s.needed && !s.ok(); });
  return found == sensors_.end() ? nullptr : &*found;
}

std::vector<std::size_t> HealthMonitor::take_changes() { return std::exchange(changes_, {}); }

}  // namespace threewe::perception
