#include "threewe/models/odometry.hpp"

namespace threewe::models {
namespace {

// The angle that an encoder shows: the last whole count.
double encoder_angle(int ticks_per_turn, double angle) {
  if (ticks_per_turn == 0) return angle;
  const double tick = 2.0 * exact::kPi / ticks_per_turn;
  return tick * std::floor(angle / tick);
}

}  // namespace

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

void measure_odometry(const OdometrySpec& spec, const WheelGeometry& wheels, const WheelErrors& errors,
                      const std::array<double, 4>& angles, OdometryState& state) {
  std::array<double, 4> rolled{};
  for (std::size_t wheel = 0; wheel < 4; ++wheel) {
    const double angle = encoder_angle(spec.ticks_per_turn, angles[wheel]);
    rolled[wheel] = errors.scale[wheel] * (angle - state.read[wheel]);
    state.read[wheel] = angle;
  }
  const double period = to_seconds(spec.period);
  const Velocity moved = body_velocity(wheels, rolled);
  state.reading.velocity = {moved.vx / period, moved.vy / period, moved.omega / period};
  state.reading.pose = integrate(state.reading.pose, moved, 1.0);
}

}  // namespace threewe::models
