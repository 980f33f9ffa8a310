// Obstacles: the real outline keeps clear of the point that is nearest to it, the more so the faster it moves.
#if defined(THREEWE_NAV_MPPI_OBSTACLE_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef THREEWE_NAV_MPPI_OBSTACLE_INL
#undef THREEWE_NAV_MPPI_OBSTACLE_INL
#else
#define THREEWE_NAV_MPPI_OBSTACLE_INL
#endif

#include <numbers>

#include "nav/mppi/critics/sample-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace threewe::nav::mppi::HWY_NAMESPACE {

/// [m] from the outline to the nearest obstacle, negative inside; large where there is none.
HWY_INLINE V clearance(const FieldView& field, const Sample& at) {
  // the middle of the outline
  const V mx = number(field.middle_x);
  const V my = number(field.middle_y);
  const V x = hn::Add(at.x, hn::Sub(hn::Mul(at.cos, mx), hn::Mul(at.sin, my)));
  const V y = hn::Add(at.y, hn::Add(hn::Mul(at.sin, mx), hn::Mul(at.cos, my)));

  // its cell and heading
  const V per_metre = number(field.cells_per_metre);
  const V half = number(0.5F * kSide);
  const V zero = hn::Zero(kFloats);
  const auto bounded = [&](V along, float first, float last) {
    return clamp(hn::Floor(hn::Add(hn::Mul(along, per_metre), half)), number(first), number(last));
  };
  const V column = bounded(x, field.first_column, field.last_column);
  const V row = bounded(y, field.first_row, field.last_row);
  const V bin = hn::Floor(hn::Mul(at.theta, number(kBins / std::numbers::pi_v<float>)));
  const auto layer = hn::And(hn::ConvertTo(Ints(), bin), hn::Set(Ints(), kBins - 1));
  const auto cell = hn::ConvertTo(Ints(), hn::Add(hn::Mul(row, number(kSide)), column));
  const auto index = hn::Add(hn::ShiftLeft<14>(layer), cell);
  static_assert(kSide * kSide == 1 << 14);
  const Pair obstacle = look_up(field.cells, index, field.unit);

  // the obstacle as the box sees it
  const V dx = hn::Sub(obstacle.a, x);
  const V dy = hn::Sub(obstacle.b, y);
  const V ahead = hn::Add(hn::Mul(at.cos, dx), hn::Mul(at.sin, dy));
  const V left = hn::Sub(hn::Mul(at.cos, dy), hn::Mul(at.sin, dx));
  const V beyond_x = hn::Sub(hn::Abs(ahead), number(field.half_length));
  const V beyond_y = hn::Sub(hn::Abs(left), number(field.half_width));
  const V outside = length(above_zero(beyond_x), above_zero(beyond_y));
  return hn::Add(outside, hn::Min(hn::Max(beyond_x, beyond_y), zero));
}

HWY_INLINE V obstacle_cost(const ObstacleCritic& critic, const Sample& at) {
  const V beyond = hn::Sub(clearance(critic.field, at), number(critic.margin));
  const V inside = hn::Max(hn::Neg(beyond), hn::Zero(kFloats));
  const V contact = hn::Add(number(critic.contact), hn::Mul(number(critic.depth), inside));
  const V near = above_zero(hn::Sub(number(1.0F), hn::Mul(above_zero(beyond), number(critic.per_reach))));
  const V motion = hn::Add(hn::Mul(number(critic.close_speed), squared(at.speed)),
                           hn::Mul(number(critic.close_turn), squared(at.omega)));
  const V weight = hn::Add(number(critic.close), motion);
  const V closeness = hn::Mul(squared(near), weight);
  return hn::Add(closeness, hn::IfThenElseZero(hn::Lt(beyond, hn::Zero(kFloats)), contact));
}

}  // namespace threewe::nav::mppi::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
