#include "calibration/figures.hpp"

#include <algorithm>
#include <cmath>

#include "threewe/core/time.hpp"

namespace threewe::calibration {
namespace {

Knob of_traction(const char* name, double low, double high, double doubt, double TractionSpec::* member) {
  return {name,
          low,
          high,
          doubt,
          [member](const Body& body) { return (*body.traction).*member; },
          [member](Body& body, double value) { (*body.traction).*member = value; }};
}

// [m] of the middle of a footprint ahead of the base
double middle(const Footprint& footprint) {
  double rear = footprint.corners().front().x;
  double front = rear;
  for (const Vec2 corner : footprint.corners()) {
    rear = std::min(rear, corner.x);
    front = std::max(front, corner.x);
  }
  return 0.5 * (rear + front);
}

// What casters leave to the driven wheels of a weight in the middle of the footprint.
double load_on_wheels(const Body& body) {
  if (body.casters.empty()) return 1.0;
  double lever = 0.0;
  for (const Caster& caster : body.casters) lever += caster.position.x / static_cast<double>(body.casters.size());
  const double share = lever == 0.0 ? 0.0 : middle(body.footprint) / lever;
  return std::clamp(1.0 - share, 0.2, 1.0);
}

}  // namespace

std::vector<Knob> knobs(const RobotProfile& profile) {
  std::vector<Knob> knobs = {
      {"motor_lag", 0.002, 0.5, 0.02, [](const Body& body) { return to_seconds(body.motor_lag); },
       [](Body& body, double value) { body.motor_lag = from_seconds(value); }},
      {"friction", 0.05, 2.0, 0.2, [](const Body& body) { return body.friction; },
       [](Body& body, double value) { body.friction = value; }},
      of_traction("traction.ahead", 0.5, 1.5, 0.05, &TractionSpec::ahead),
      of_traction("traction.turning", 0.5, 1.5, 0.05, &TractionSpec::turning),
      {"traction.turning_lag", 0.0005, 0.5, 0.02,
       [](const Body& body) { return to_seconds(body.traction->turning_lag); },
       [](Body& body, double value) { body.traction->turning_lag = from_seconds(value); }},
      of_traction("traction.mass_height", 0.0, 2.0, 0.05, &TractionSpec::mass_height),
  };
  if (profile.kinematics() == Kinematics::holonomic) {
    knobs.push_back(of_traction("traction.sideways", 0.5, 1.5, 0.05, &TractionSpec::sideways));
    knobs.push_back(of_traction("traction.shift", 0.0, 1.0, 0.3, &TractionSpec::shift));
    knobs.push_back(of_traction("traction.shift_speed", 0.02, 5.0, 0.3, &TractionSpec::shift_speed));
  } else {
    knobs.push_back(of_traction("traction.load", 0.1, 1.0, 0.2, &TractionSpec::load));
  }
  return knobs;
}

RobotProfile with_traction(RobotProfile profile) {
  Body& body = profile.body;
  if (body.traction) return profile;
  const double arm = body.wheels.half_length + body.wheels.half_width;
  TractionSpec traction;
  traction.turning_lag = from_seconds(to_seconds(body.motor_lag) * body.inertia / (body.mass * arm * arm));
  traction.load = load_on_wheels(body);
  traction.mass_height = 0.5 * body.height;
  if (body.wheels.kinematics == Kinematics::holonomic) {
    traction.shift = 0.3;
    traction.shift_speed = 0.5;
  }
  body.traction = traction;
  return profile;
}

}  // namespace threewe::calibration
