// Inputs of all critics: one step of many samples. For rollout_kernel.cpp, after highway-inl.hpp.
#if defined(THREEWE_NAV_MPPI_SAMPLE_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef THREEWE_NAV_MPPI_SAMPLE_INL
#undef THREEWE_NAV_MPPI_SAMPLE_INL
#else
#define THREEWE_NAV_MPPI_SAMPLE_INL
#endif

#include "nav/mppi/rollout.hpp"

HWY_BEFORE_NAMESPACE();
namespace threewe::nav::mppi::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using Floats = hn::CappedTag<float, kBlock>;
using V = hn::Vec<Floats>;
using Ints = hn::RebindToSigned<Floats>;
constexpr Floats kFloats;

HWY_INLINE V number(float x) { return hn::Set(kFloats, x); }
HWY_INLINE V clamp(V x, V low, V high) { return hn::Max(low, hn::Min(x, high)); }
HWY_INLINE V squared(V x) { return hn::Mul(x, x); }
HWY_INLINE V above_zero(V x) { return hn::Max(x, hn::Zero(kFloats)); }

/// The robot of each sample at the end of a step.
struct Sample {
  V x, y;      // [m] in the window
  V cos, sin;  // of its heading
  V theta;     // [rad], not wrapped
  V vx, vy;    // [m/s] in the base frame
  V omega;     // [rad/s]
  V speed;     // [m/s], that the body may have
};

/// Two numbers of `pack`.
struct Pair {
  V a, b;
};
HWY_INLINE Pair look_up(const std::int32_t* table, hn::Vec<Ints> index, float unit) {
  const auto packed = hn::GatherIndex(Ints(), table, index);
  const auto a = hn::ShiftRight<16>(hn::ShiftLeft<16>(packed));
  const auto b = hn::ShiftRight<16>(packed);
  return {hn::Mul(hn::ConvertTo(kFloats, a), number(unit)), hn::Mul(hn::ConvertTo(kFloats, b), number(unit))};
}

/// The distance to a place.
HWY_INLINE V length(V x, V y) { return hn::Sqrt(hn::Add(squared(x), squared(y))); }

}  // namespace threewe::nav::mppi::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
