// People: do not drive where they will be, if they walk on as they do. They walk round who stands still.
#if defined(THREEWE_NAV_MPPI_PEOPLE_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef THREEWE_NAV_MPPI_PEOPLE_INL
#undef THREEWE_NAV_MPPI_PEOPLE_INL
#else
#define THREEWE_NAV_MPPI_PEOPLE_INL
#endif

#include "nav/mppi/critics/sample-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace threewe::nav::mppi::HWY_NAMESPACE {

/// `seconds`: since the plan began.
HWY_INLINE V people_cost(const PeopleCritic& critic, const Sample& at, float seconds) {
  V cost = hn::Zero(kFloats);
  for (std::size_t i = 0; i < critic.count; ++i) {
    const V dx = hn::Sub(at.x, number(critic.x[i] + seconds * critic.vx[i]));
    const V dy = hn::Sub(at.y, number(critic.y[i] + seconds * critic.vy[i]));
    const V beyond = hn::Sub(length(dx, dy), number(critic.apart[i]));
    const V near = above_zero(hn::Sub(number(1.0F), hn::Mul(above_zero(beyond), number(critic.per_reach))));
    const auto touches = hn::Lt(beyond, hn::Zero(kFloats));
    cost = hn::Add(cost, hn::Mul(number(critic.close), squared(near)));
    cost = hn::Add(cost, hn::IfThenElseZero(touches, number(critic.contact)));
  }
  return hn::Mul(cost, at.speed);
}

}  // namespace threewe::nav::mppi::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
