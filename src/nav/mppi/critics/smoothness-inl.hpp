// Smoothness: change the velocity no more than is needed.
#if defined(THREEWE_NAV_MPPI_SMOOTHNESS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef THREEWE_NAV_MPPI_SMOOTHNESS_INL
#undef THREEWE_NAV_MPPI_SMOOTHNESS_INL
#else
#define THREEWE_NAV_MPPI_SMOOTHNESS_INL
#endif

#include "nav/mppi/critics/sample-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace threewe::nav::mppi::HWY_NAMESPACE {

HWY_INLINE V smoothness_cost(const SmoothnessCritic& critic, const Sample& before, const Sample& at) {
  const V linear = hn::Add(squared(hn::Sub(at.vx, before.vx)), squared(hn::Sub(at.vy, before.vy)));
  const V angular = squared(hn::Sub(at.omega, before.omega));
  return hn::Add(hn::Mul(number(critic.linear), linear), hn::Mul(number(critic.angular), angular));
}

}  // namespace threewe::nav::mppi::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
