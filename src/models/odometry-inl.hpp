// One reading of an odometer, written once for a number and for a vector of them. For kernels, after highway-inl.hpp,
// or after <hwy/highway.h> for the plain form.
#if defined(THREEWE_MODELS_ODOMETRY_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef THREEWE_MODELS_ODOMETRY_INL
#undef THREEWE_MODELS_ODOMETRY_INL
#else
#define THREEWE_MODELS_ODOMETRY_INL
#endif

#include "core/pose-inl.hpp"
#include "models/drive-inl.hpp"
#include "models/odometry.hpp"

HWY_BEFORE_NAMESPACE();
namespace threewe::models::HWY_NAMESPACE {

/// The angle that an encoder shows: the last whole count.
template <class V>
HWY_INLINE V encoder_angle(const OdometerOf<V>& odometer, V angle) {
  const V shown = odometer.count * lanes::floor(angle * odometer.counts_per_radian);
  return lanes::where(odometer.count == lanes::number<V>(0.0), angle, shown);
}

/// Moves a pose on by what the wheels have rolled since the reading before, each by `rolled` [rad], and tells how fast.
template <class V>
HWY_INLINE VelocityOf<V> move_on(const OdometerOf<V>& odometer, const WheelsOf<V>& rolled,
                                 threewe::HWY_NAMESPACE::Pose2DOf<V>& pose) {
  const VelocityOf<V> moved = rolling_velocity(odometer.roll, odometer.roll_turn, odometer.sideways, rolled);
  pose = threewe::HWY_NAMESPACE::integrate(pose, moved, lanes::number<V>(1.0));
  return {moved.vx * odometer.per_period, moved.vy * odometer.per_period, moved.omega * odometer.per_period};
}

}  // namespace threewe::models::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
