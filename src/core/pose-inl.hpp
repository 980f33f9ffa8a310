// Motion in the plane, written once for a number and for a vector of them. For kernels, after highway-inl.hpp, or after
// <hwy/highway.h> for the plain form.
#if defined(THREEWE_CORE_POSE_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef THREEWE_CORE_POSE_INL
#undef THREEWE_CORE_POSE_INL
#else
#define THREEWE_CORE_POSE_INL
#endif

#include "core/exact-inl.hpp"
#include "core/lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace threewe::HWY_NAMESPACE {

namespace lanes = threewe::lanes::HWY_NAMESPACE;

template <class V>
struct Vec2Of {
  V x;
  V y;
};
template <class V>
struct Pose2DOf {
  V x;
  V y;
  V theta;
};
template <class V>
struct VelocityOf {
  V vx;
  V vy;
  V omega;
};

template <class V>
HWY_INLINE V wrap_angle(V angle) {
  const V pi = lanes::number<V>(exact::kPi);
  const V minus_pi = lanes::number<V>(-exact::kPi);
  const auto is_wrapped = [&](V x) { return lanes::both<V>(x > minus_pi, x <= pi); };
  const auto as_it_is = is_wrapped(angle);
  if (lanes::all<V>(as_it_is)) return angle;

  const V two_pi = lanes::number<V>(2.0 * exact::kPi);
  const V wrapped = angle - two_pi * lanes::ceil((angle - pi) / two_pi);
  // rounding may end a hair outside; NaN stays what it is
  const V inside = lanes::where(lanes::either<V>(is_wrapped(wrapped), lanes::is_nan(wrapped)), wrapped, pi);
  return lanes::where(as_it_is, angle, inside);
}

template <class V>
HWY_INLINE Vec2Of<V> rotate(V x, V y, V angle) {
  const auto [s, c] = exact::HWY_NAMESPACE::sincos(angle);
  return {c * x - s * y, s * x + c * y};
}

template <class V>
HWY_INLINE Pose2DOf<V> integrate(const Pose2DOf<V>& pose, const VelocityOf<V>& velocity, V seconds) {
  const V turn = velocity.omega * seconds;

  // along an arc the chord is shorter by sin(a)/a and turned by (1 - cos a)/a, with their series near 0
  V along = lanes::number<V>(1.0) - turn * turn / lanes::number<V>(6.0);
  V across = lanes::number<V>(0.5) * turn;
  const auto bent = lanes::magnitude(turn) > lanes::number<V>(1e-4);
  if (lanes::any<V>(bent)) {
    const auto [s, c] = exact::HWY_NAMESPACE::sincos(turn);
    along = lanes::where(bent, s / turn, along);
    across = lanes::where(bent, (lanes::number<V>(1.0) - c) / turn, across);
  }
  const V dx = velocity.vx * seconds;
  const V dy = velocity.vy * seconds;
  const Vec2Of<V> moved = rotate(along * dx - across * dy, across * dx + along * dy, pose.theta);
  return {pose.x + moved.x, pose.y + moved.y, wrap_angle(pose.theta + turn)};
}

}  // namespace threewe::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
