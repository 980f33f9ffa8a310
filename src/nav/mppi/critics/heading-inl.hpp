// The heading: face along the path, drive the way the robot faces, or turn on the spot.
#if defined(THREEWE_NAV_MPPI_HEADING_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef THREEWE_NAV_MPPI_HEADING_INL
#undef THREEWE_NAV_MPPI_HEADING_INL
#else
#define THREEWE_NAV_MPPI_HEADING_INL
#endif

#include "nav/mppi/critics/path-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace threewe::nav::mppi::HWY_NAMESPACE {

/// `progress` tells the path's direction where the sample is.
HWY_INLINE V heading_cost(const HeadingCritic& critic, const Sample& at, const Progress& progress) {
  // the cosine of the angle between the heading and the path's direction, turned aside
  const V ahead = hn::Add(hn::Mul(at.cos, progress.tx), hn::Mul(at.sin, progress.ty));
  const V left = hn::Sub(hn::Mul(at.sin, progress.tx), hn::Mul(at.cos, progress.ty));
  const V agrees = hn::Add(hn::Mul(ahead, number(critic.aside_cos)), hn::Mul(left, number(critic.aside_sin)));
  const V along = hn::Mul(number(critic.along), hn::Sub(number(1.0F), agrees));
  const V turn = hn::Mul(number(critic.turn), hn::Abs(hn::Sub(number(critic.turn_to), at.theta)));
  return hn::Add(along, turn);
}

HWY_INLINE V direction_cost(const HeadingCritic& critic, const Sample& at) {
  const V against = above_zero(hn::Mul(at.vx, number(-critic.sign)));
  const V sideways = above_zero(hn::Sub(hn::Abs(at.vy), number(critic.sideways_free)));
  return hn::Add(hn::Mul(number(critic.sideways), squared(sideways)),
                 hn::Mul(number(critic.backward), squared(against)));
}

}  // namespace threewe::nav::mppi::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
