#include "threewe/models/drive.hpp"

#include <algorithm>

namespace threewe::models {

Drive make_drive(const RobotProfile& profile, Duration step) {
  const Body& body = profile.body;
  const double h = to_seconds(step);
  Drive drive;
  drive.wheels = body.wheels;
  drive.limits = profile.hardware_limits;
  drive.step = h;
  drive.no_load_speed = body.no_load_speed;
  drive.grip_arm = exact::hypot(body.wheels.half_length, body.wheels.half_width);
  drive.inertia_arm_squared = body.inertia / body.mass;
  drive.rolling_resistance = body.rolling_resistance;
  return drive;
}

Traction make_traction(const RobotProfile& profile, Duration step, const Variation& variation) {
  const Body& body = profile.body;
  const double h = to_seconds(step);
  Traction traction;
  traction.mass = variation.mass * body.mass;
  // each motor accelerates its share of the body
  const double wheel_mass = traction.mass / body.wheels.wheel_count();
  traction.response = 1.0 - exact::exp(-h / (variation.motor_lag * to_seconds(body.motor_lag)));
  traction.stall_change = body.stall_torque / (wheel_mass * body.wheels.radius * body.wheels.radius) * h;
  traction.grip_change = variation.friction * body.friction * kGravity * h;
  traction.motor_noise = variation.motor_noise;
  return traction;
}

std::array<double, 4> motor_shares(const Traction& traction, const RngKey& key, std::uint64_t step) {
  std::array<double, 4> shares{1.0, 1.0, 1.0, 1.0};
  if (traction.motor_noise == 0.0) return shares;
  for (std::uint32_t wheel = 0; wheel < 4; ++wheel) shares[wheel] += traction.motor_noise * normal(key, step, wheel);
  return shares;
}

WheelSpeeds drive_motors(const Drive& drive, const Traction& traction, const WheelSpeeds& speeds,
                         const WheelSpeeds& setpoints, double supply, const std::array<double, 4>& shares) {
  WheelSpeeds next{};
  for (int i = 0; i < drive.wheels.wheel_count(); ++i) {
    const auto wheel = static_cast<std::size_t>(i);
    const double speed = speeds[wheel];
    const double wanted = traction.response * (setpoints[wheel] - speed);
    // the torque-speed line, either way; beyond the speed that its supply gives a motor brakes, and the driver's
    // current limit caps all of it
    const double ratio = speed / drive.no_load_speed;
    const double forwards = traction.stall_change * std::clamp(supply - ratio, -1.0, 1.0);
    const double backwards = traction.stall_change * std::clamp(supply + ratio, -1.0, 1.0);
    next[wheel] = speed + shares[wheel] * std::clamp(wanted, -backwards, forwards);
  }
  return next;
}

Velocity grip(const Drive& drive, const Traction& traction, const Velocity& body, const Velocity& rolling,
              double floor) {
  const Velocity change{rolling.vx - body.vx, rolling.vy - body.vy, rolling.omega - body.omega};
  // a torque is measured by the force that it takes at the wheels
  const double turning = change.omega * drive.inertia_arm_squared / drive.grip_arm;
  const double needed = exact::sqrt(change.vx * change.vx + change.vy * change.vy + turning * turning);
  const double given = floor * traction.grip_change;
  if (needed <= given) return rolling;
  const double share = given / needed;
  return {body.vx + share * change.vx, body.vy + share * change.vy, body.omega + share * change.omega};
}

double drive_power(const Drive& drive, const Traction& traction, const Velocity& before, const Velocity& after,
                   const Velocity& rolling) {
  const double accelerating = (after.vx - before.vx) * rolling.vx + (after.vy - before.vy) * rolling.vy +
                              drive.inertia_arm_squared * (after.omega - before.omega) * rolling.omega;
  const double resisting = drive.rolling_resistance * kGravity * exact::hypot(rolling.vx, rolling.vy);
  return traction.mass * (accelerating / drive.step + resisting);
}

}  // namespace threewe::models
