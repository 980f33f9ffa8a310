#include "sim/renderer/meet.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sim/renderer/meet.cpp"
#include "threewe/core/highway-inl.hpp"
//
#include "sim/renderer/meet-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace threewe::sim::view::HWY_NAMESPACE {

unsigned meet_block(const Outline& outline, const double* slopes, const double* behind, Meeting& meeting) {
  const Doubles d;
  unsigned met = 0;
  for (std::size_t i = 0; i < kBlock; i += hn::Lanes(d)) {
    const Passage passage = pass_through(outline, hn::LoadU(d, slopes + i), hn::LoadU(d, behind + i));
    hn::Store(passage.hits.near, d, meeting.near.data() + i);
    hn::Store(passage.hits.face, d, meeting.face.data() + i);
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(d, passage.met, bits);
    met |= (bits[0] & ((1U << hn::Lanes(d)) - 1U)) << i;
  }
  return met;
}

}  // namespace threewe::sim::view::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace threewe::sim::view {

HWY_EXPORT(meet_block);

unsigned meet(const Outline& outline, const double* slopes, const double* behind, Meeting& meeting) {
  return HWY_DYNAMIC_DISPATCH(meet_block)(outline, slopes, behind, meeting);
}

}  // namespace threewe::sim::view
#endif
