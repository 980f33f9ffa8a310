// How a velocity is scaled down to what a robot may do, written once for a number and for a vector of them. For
// kernels, after highway-inl.hpp, or after <hwy/highway.h> for the plain form.
#if defined(THREEWE_HARDWARE_LIMITS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef THREEWE_HARDWARE_LIMITS_INL
#undef THREEWE_HARDWARE_LIMITS_INL
#else
#define THREEWE_HARDWARE_LIMITS_INL
#endif

#include "core/pose-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace threewe::HWY_NAMESPACE {

/// `within_limits`, whose limits are `linear` [m/s] and `angular` [rad/s].
template <class V>
HWY_INLINE VelocityOf<V> within_limits(V linear, V angular, VelocityOf<V> v) {
  const V rounding = lanes::number<V>(1.0 + 1e-12);  // what scaling may add
  const V huge = lanes::number<V>(1e100);            // no limit is near, and its square is finite
  const auto shorten = [&](V from, V to) {
    const auto within = from <= to * rounding;
    if (lanes::all<V>(within)) return;
    const V share = to / from;
    v.vx = lanes::where(within, v.vx, v.vx * share);
    v.vy = lanes::where(within, v.vy, v.vy * share);
  };
  shorten(lanes::larger(lanes::magnitude(v.vx), lanes::magnitude(v.vy)), huge);
  shorten(lanes::root(v.vx * v.vx + v.vy * v.vy), linear);
  v.omega = lanes::clamp(v.omega, lanes::number<V>(-1.0) * angular, angular);
  return v;
}

}  // namespace threewe::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
