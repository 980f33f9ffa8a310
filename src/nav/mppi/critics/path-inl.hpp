// The path: get on along it, and stay near it.
#if defined(THREEWE_NAV_MPPI_PATH_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef THREEWE_NAV_MPPI_PATH_INL
#undef THREEWE_NAV_MPPI_PATH_INL
#else
#define THREEWE_NAV_MPPI_PATH_INL
#endif

#include "nav/mppi/critics/sample-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace threewe::nav::mppi::HWY_NAMESPACE {

/// Where each sample is along the path, followed from look to look, so that a path that comes back to a place is not
/// cut short.
struct Progress {
  V x, y;    // [m] of the robot at the last look
  V tx, ty;  // the path's direction there
  V along;   // [m] from the beginning of the path
  V beside;  // [m] to the left of it
};

HWY_INLINE void look_at_path(const PathView& path, V x, V y, V guess, Progress& progress) {
  const V last = number(path.last);
  const V nearest = hn::Floor(hn::Add(hn::Mul(guess, number(path.per_spacing)), number(0.5F)));
  const V index = clamp(nearest, hn::Zero(kFloats), last);
  const auto at = hn::ConvertTo(Ints(), index);
  const Pair point = look_up(path.points, at, path.unit);
  const Pair direction = look_up(path.directions, at, 1.0F / 32000.0F);
  const V dx = hn::Sub(x, point.a);
  const V dy = hn::Sub(y, point.b);
  progress.x = x;
  progress.y = y;
  progress.tx = direction.a;
  progress.ty = direction.b;
  progress.along =
      hn::Add(hn::Mul(index, number(path.spacing)), hn::Add(hn::Mul(dx, direction.a), hn::Mul(dy, direction.b)));
  progress.beside = hn::Sub(hn::Mul(dy, direction.a), hn::Mul(dx, direction.b));
}

HWY_INLINE V path_cost(const PathCritic& critic, const Sample& at, Progress& progress) {
  const V moved =
      hn::Add(hn::Mul(hn::Sub(at.x, progress.x), progress.tx), hn::Mul(hn::Sub(at.y, progress.y), progress.ty));
  look_at_path(critic.path, at.x, at.y, hn::Add(progress.along, moved), progress);
  const V length_of_path = number(critic.path.last * critic.path.spacing);
  const V left = hn::Abs(hn::Sub(length_of_path, progress.along));
  return hn::Add(hn::Mul(left, number(critic.left)), hn::Mul(squared(progress.beside), number(critic.beside)));
}

}  // namespace threewe::nav::mppi::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
