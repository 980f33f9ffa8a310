#include "sim/renderer/intersect.hpp"

#include <bit>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sim/renderer/intersect.cpp"
#include "core/highway-inl.hpp"
//
#include "sim/renderer/intersect-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace threewe::sim::view::HWY_NAMESPACE {

int columns_of_block() { return static_cast<int>(kBlock); }

unsigned intersect_block(const Outline& outline, const double* slopes, const double* behind,
                         Intersection& intersection) {
  const Doubles d;
  unsigned met = 0;
  for (std::size_t i = 0; i < kBlock; i += hn::Lanes(d)) {
    const Passage passage = pass_through(outline, hn::LoadU(d, slopes + i), hn::LoadU(d, behind + i));
    hn::Store(passage.hits.near, d, intersection.near.data() + i);
    hn::Store(passage.hits.face, d, intersection.face.data() + i);
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(d, passage.met, bits);
    met |= (bits[0] & ((1U << hn::Lanes(d)) - 1U)) << i;
  }
  return met;
}

std::size_t find_circles(const Circles& circles, const Sector& sector, std::uint32_t* found) {
  const Floats d;
  constexpr double kMargin = 1e-3;  // [m], more than rounding takes
  const auto set = [&](double x) HWY_ATTR { return hn::Set(d, static_cast<float>(x)); };
  const auto norm_of = [&](double slope) HWY_ATTR { return set(std::sqrt(1.0 + slope * slope)); };
  const auto left_norm = norm_of(sector.most);
  const auto right_norm = norm_of(sector.least);
  std::size_t count = 0;
  for (std::size_t i = 0; i < circles.x.size(); i += hn::Lanes(d)) {
    const auto dx = hn::Sub(hn::LoadU(d, &circles.x[i]), set(sector.eye.x));
    const auto dy = hn::Sub(hn::LoadU(d, &circles.y[i]), set(sector.eye.y));
    const auto radius = hn::Add(hn::LoadU(d, &circles.radius[i]), set(kMargin));
    const auto x = hn::Add(hn::Mul(dx, set(sector.forward.x)), hn::Mul(dy, set(sector.forward.y)));
    const auto y = hn::Add(hn::Mul(dx, set(sector.left.x)), hn::Mul(dy, set(sector.left.y)));
    const auto beyond_left = hn::Sub(hn::Sub(y, hn::Mul(set(sector.most), x)), hn::Mul(radius, left_norm));
    const auto beyond_right = hn::Sub(hn::Sub(hn::Mul(set(sector.least), x), y), hn::Mul(radius, right_norm));
    const auto behind = hn::Neg(hn::Add(x, radius));
    const auto out = hn::Max(behind, hn::Max(beyond_left, beyond_right));
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(d, hn::Le(out, hn::Zero(d)), bits);
    for (unsigned left = (bits[0] | bits[1] << 8U) & ((1U << hn::Lanes(d)) - 1U); left != 0; left &= left - 1) {
      found[count++] = static_cast<std::uint32_t>(i) + static_cast<std::uint32_t>(std::countr_zero(left));
    }
  }
  return count;
}

}  // namespace threewe::sim::view::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace threewe::sim::view {

HWY_EXPORT(columns_of_block);
HWY_EXPORT(intersect_block);
HWY_EXPORT(find_circles);

int block_width() { return HWY_DYNAMIC_DISPATCH(columns_of_block)(); }

std::size_t find_within(const Circles& circles, const Sector& sector, std::uint32_t* found) {
  return HWY_DYNAMIC_DISPATCH(find_circles)(circles, sector, found);
}

unsigned intersect(const Outline& outline, const double* slopes, const double* behind, Intersection& intersection) {
  return HWY_DYNAMIC_DISPATCH(intersect_block)(outline, slopes, behind, intersection);
}

}  // namespace threewe::sim::view
#endif
