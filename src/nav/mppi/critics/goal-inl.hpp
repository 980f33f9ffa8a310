// The goal: be there, and rest there.
#if defined(THREEWE_NAV_MPPI_GOAL_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef THREEWE_NAV_MPPI_GOAL_INL
#undef THREEWE_NAV_MPPI_GOAL_INL
#else
#define THREEWE_NAV_MPPI_GOAL_INL
#endif

#include "nav/mppi/critics/sample-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace threewe::nav::mppi::HWY_NAMESPACE {

HWY_INLINE V goal_cost(const GoalCritic& critic, const Sample& at) {
  return hn::Mul(number(critic.distance), length(hn::Sub(at.x, number(critic.x)), hn::Sub(at.y, number(critic.y))));
}

/// At the end of the plan.
HWY_INLINE V rest_cost(const GoalCritic& critic, const Sample& at) {
  return hn::Mul(number(critic.speed), squared(at.speed));
}

}  // namespace threewe::nav::mppi::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
