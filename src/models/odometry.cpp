#include "models/odometry.hpp"

#include <hwy/highway.h>

#include "core/exact.hpp"
#include "models/odometry-inl.hpp"

namespace threewe::models {

Odometer make_odometer(const OdometrySpec& spec, const WheelGeometry& wheels) {
  Odometer odometer{};
  if (spec.ticks_per_turn > 0) {
    odometer.count = 2.0 * exact::kPi / spec.ticks_per_turn;
    odometer.counts_per_radian = spec.ticks_per_turn / (2.0 * exact::kPi);
  }
  odometer.per_period = 1.0 / to_seconds(spec.period);
  odometer.roll = wheels.radius / wheels.wheel_count();
  odometer.roll_turn = odometer.roll / (wheels.half_length + wheels.half_width);
  odometer.sideways = wheels.kinematics == Kinematics::holonomic ? 1.0 : 0.0;
  return odometer;
}

WheelErrors draw_wheel_errors(const OdometrySpec& spec, const RngKey& key, double slip) {
  RngKey episode = key;
  episode.stream = Stream::episode;
  const auto draw = static_cast<std::uint64_t>(Stream::odometry);
  WheelErrors errors;
  for (std::uint32_t wheel = 0; wheel < 4; ++wheel) {
    errors.scale[wheel] = 1.0 + uniform(episode, draw, wheel, -spec.wheel_scale, spec.wheel_scale);
  }
  errors.lateral = uniform(episode, draw, 4, spec.lateral_scale_min, spec.lateral_scale_max);

  // written so that a factor of one changes no bit
  const auto stretch = [slip](double& share) { share += (slip - 1.0) * (share - 1.0); };
  for (double& scale : errors.scale) stretch(scale);
  stretch(errors.lateral);
  return errors;
}

void measure_odometry(const Odometer& odometer, const WheelErrors& errors, const std::array<double, 4>& angles,
                      OdometryState& state) {
  HWY_NAMESPACE::WheelsOf<double> rolled{};
  for (std::size_t wheel = 0; wheel < 4; ++wheel) {
    const double angle = HWY_NAMESPACE::encoder_angle(odometer, angles[wheel]);
    rolled.at[wheel] = errors.scale[wheel] * (angle - state.read[wheel]);
    state.read[wheel] = angle;
  }
  const Pose2D& before = state.reading.pose;
  threewe::HWY_NAMESPACE::Pose2DOf<double> pose{before.x, before.y, before.theta};
  const auto [vx, vy, omega] = HWY_NAMESPACE::move_on(odometer, rolled, pose);
  state.reading = {{pose.x, pose.y, pose.theta}, {vx, vy, omega}};
}

}  // namespace threewe::models
