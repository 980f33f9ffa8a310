#include "models/drive.hpp"

#include <hwy/highway.h>

#include "core/exact.hpp"
#include "models/drive-inl.hpp"

namespace threewe::models {
namespace {

HWY_NAMESPACE::VelocityOf<double> numbers(const Velocity& v) { return {v.vx, v.vy, v.omega}; }

}  // namespace

Drive make_drive(const RobotProfile& profile, Duration step) {
  const Body& body = profile.body;
  const WheelGeometry& wheels = body.wheels;
  const bool sideways = wheels.kinematics == Kinematics::holonomic;
  Drive drive{};
  drive.turns_per_metre = 1.0 / wheels.radius;
  drive.turn_arm = wheels.half_length + wheels.half_width;
  drive.sideways = sideways ? 1.0 : 0.0;
  drive.roll = wheels.radius / wheels.wheel_count();
  drive.roll_turn = drive.roll / drive.turn_arm;
  drive.linear_limit = profile.hardware_limits.linear;
  drive.angular_limit = profile.hardware_limits.angular;
  drive.per_no_load_speed = 1.0 / body.no_load_speed;
  drive.inertia_arm_squared = body.inertia / body.mass;
  drive.turn_weight = drive.inertia_arm_squared / exact::hypot(wheels.half_length, wheels.half_width);
  drive.resistance = body.rolling_resistance * kGravity;
  drive.per_step = 1.0 / to_seconds(step);
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
  traction.friction_change = variation.friction * body.friction * kGravity * h;
  traction.motor_noise = variation.motor_noise;
  if (body.traction) {
    traction.turn_response = 1.0 - exact::exp(-h / (variation.motor_lag * to_seconds(body.traction->turning_lag)));
  }
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
  const std::size_t wheels = drive.sideways == 0.0 ? 2 : 4;
  for (std::size_t i = 0; i < wheels; ++i) {
    next[i] = HWY_NAMESPACE::drive_motor(drive.per_no_load_speed, traction.response, traction.stall_change, speeds[i],
                                         setpoints[i], supply, shares[i]);
  }
  return next;
}

Velocity limit_by_friction(const Drive& drive, const Traction& traction, const Velocity& body, const Velocity& rolling,
                           double floor) {
  const auto [vx, vy, omega] = HWY_NAMESPACE::limit_by_friction(drive.turn_weight, floor * traction.friction_change,
                                                                numbers(body), numbers(rolling));
  return {vx, vy, omega};
}

double drive_power(const Drive& drive, const Traction& traction, const Velocity& before, const Velocity& after,
                   const Velocity& rolling) {
  return HWY_NAMESPACE::drive_power(drive, traction.mass, numbers(before), numbers(after), numbers(rolling));
}

}  // namespace threewe::models
