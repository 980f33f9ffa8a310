#include "models/traction.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <hwy/highway.h>

#include "models/traction-inl.hpp"

namespace threewe::models {
namespace {

// What takes load from the driven wheels of a differential base as it speeds up: casters on one side of them alone.
double caster_lever(const Body& body) {
  if (body.casters.empty()) return 0.0;
  const auto ahead = [](const Caster& caster) { return caster.position.x; };
  const auto [rear, front] = std::ranges::minmax(body.casters, {}, ahead);
  if (front.position.x < 0.0) return -front.position.x;
  if (rear.position.x > 0.0) return -rear.position.x;
  return 0.0;
}

}  // namespace

TractionModel make_traction_model(const RobotProfile& profile, Duration step) {
  TractionModel traction_model{};
  traction_model.ahead = traction_model.sideways = traction_model.turning = traction_model.turn_inertia =
      1.0;  // nothing is divided by zero
  if (!profile.body.traction) return traction_model;
  const Body& body = profile.body;
  const TractionSpec& traction = *body.traction;
  const WheelGeometry& wheels = body.wheels;
  const bool mecanum = wheels.kinematics == Kinematics::holonomic;
  const double arm = wheels.half_length + wheels.half_width;
  const double per_gain = traction.mass_height / (kGravity * to_seconds(step));  // [s] of a lever of a metre

  traction_model.present = 1.0;
  traction_model.ahead = traction.ahead;
  traction_model.sideways = traction.sideways;
  traction_model.turning = traction.turning;
  traction_model.turn_inertia = body.inertia / (body.mass * arm * arm);
  // a roller holds along its axle only, at 45 degrees
  traction_model.hold = mecanum ? 1.0 / std::numbers::sqrt2 : 1.0;
  traction_model.load = traction.load;
  traction_model.shift = traction.shift;
  traction_model.per_shift_speed = traction.shift > 0.0 ? 1.0 / traction.shift_speed : 0.0;
  if (mecanum) {
    traction_model.pitch = per_gain / wheels.half_length;
    traction_model.rear_pitch = -traction_model.pitch;
    traction_model.roll = per_gain / wheels.half_width;
  } else if (const double lever = caster_lever(body); lever != 0.0) {
    traction_model.pitch = per_gain / lever;
  }
  traction_model.wheel_share = 1.0 / wheels.wheel_count();
  return traction_model;
}

TractionStep apply_traction(const Drive& drive, const TractionModel& traction_model, const Traction& traction,
                            const Velocity& body, const Velocity& command, double lateral, double supply, double floor,
                            const std::array<double, 4>& shares) {
  const HWY_NAMESPACE::GivenOf<double> given{traction.response,
                                             traction.turn_response,
                                             traction.stall_change,
                                             floor * traction.friction_change,
                                             supply,
                                             {{shares[0], shares[1], shares[2], shares[3]}}};
  const auto [after, wheels] = HWY_NAMESPACE::push_body<double>(
      drive, traction_model, given, lateral, {command.vx, command.vy, command.omega}, {body.vx, body.vy, body.omega});
  return {{after.vx, after.vy, after.omega}, {wheels.at[0], wheels.at[1], wheels.at[2], wheels.at[3]}};
}

}  // namespace threewe::models
