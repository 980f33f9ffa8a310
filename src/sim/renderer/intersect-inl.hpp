// Ray-solid intersection for several columns at once, entry and exit; for a kernel's source file to include, once per
// target. Unfused throughout, so that the bits are the same for every target.
#if defined(THREEWE_SIM_RENDERER_INTERSECT_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef THREEWE_SIM_RENDERER_INTERSECT_INL_HPP
#undef THREEWE_SIM_RENDERER_INTERSECT_INL_HPP
#else
#define THREEWE_SIM_RENDERER_INTERSECT_INL_HPP
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <cstddef>
#include <limits>

#include "sim/renderer/intersect.hpp"

HWY_BEFORE_NAMESPACE();
namespace threewe::sim::view::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::CappedTag<float, kWidestBlock>;
using Doubles = hn::CappedTag<double, kWidestBlock>;

/// Columns of a block. Fewer than a vector holds would leave it idle; more than eight would meet more solids.
inline constexpr std::size_t kBlock = std::max<std::size_t>(8, hn::MaxLanes(Floats()));
using D = hn::Vec<Doubles>;

/// Inverse depths at which rays enter and leave, and the face by which they enter a box.
struct Hits {
  D near;
  D far;
  D face;
};

HWY_INLINE Hits intersect_box(const Outline& outline, D slope) {
  const Doubles d;
  const auto along = [&](const Outline::Line& line)
                         HWY_ATTR { return hn::Add(hn::Mul(hn::Set(d, line.slope), slope), hn::Set(d, line.offset)); };
  Hits hits{hn::Set(d, std::numeric_limits<double>::infinity()), hn::Zero(d), hn::Set(d, -1.0)};
  for (int i = 0; i < outline.near_count; ++i) {
    const Outline::Line& line = outline.near[static_cast<std::size_t>(i)];
    const D w = along(line);
    const auto nearer = hn::Lt(w, hits.near);
    hits.near = hn::IfThenElse(nearer, w, hits.near);
    hits.face = hn::IfThenElse(nearer, hn::Set(d, line.face), hits.face);
  }
  for (int i = 0; i < outline.far_count; ++i) {
    hits.far = hn::Max(hits.far, along(outline.far[static_cast<std::size_t>(i)]));
  }
  return hits;
}

// beyond w^2 - 2 ahead w + (1 + s^2) <= 0
HWY_INLINE Hits intersect_disc(const Outline& outline, D slope) {
  const Doubles d;
  const D zero = hn::Zero(d);
  const D infinity = hn::Set(d, std::numeric_limits<double>::infinity());
  const D beyond = hn::Set(d, outline.beyond);
  const D ahead = hn::Add(hn::Set(d, outline.center.x), hn::Mul(slope, hn::Set(d, outline.center.y)));
  const D square = hn::Add(hn::Set(d, 1.0), hn::Mul(slope, slope));
  const D root = hn::Sub(hn::Mul(ahead, ahead), hn::Mul(beyond, square));
  const auto misses = hn::Lt(root, zero);
  const D r = hn::Sqrt(hn::IfThenElse(misses, zero, root));
  const auto before = hn::Gt(ahead, zero);
  const D far = hn::Div(square, hn::Add(ahead, r));
  if (outline.beyond > 0.0) {
    const D near = hn::Div(hn::Add(ahead, r), beyond);
    return {hn::IfThenElse(misses, zero, hn::IfThenElseZero(before, near)), far, zero};
  }
  // the eye is above or below it
  const D behind = hn::Div(hn::Sub(ahead, r), beyond);
  return {hn::IfThenElse(misses, zero, infinity), hn::IfThenElse(before, far, behind), zero};
}

/// Where rays of some slopes pass through an outline before `behind`, an inverse depth for each.
struct Passage {
  Hits hits;
  hn::Mask<Doubles> met;
};
HWY_INLINE Passage pass_through(const Outline& outline, D slope, D behind) {
  Hits hits = outline.is_disc ? intersect_disc(outline, slope) : intersect_box(outline, slope);
  hits.far = hn::IfThenElse(hn::Gt(hits.far, behind), hits.far, behind);
  return {hits, hn::Gt(hits.near, hits.far)};
}

}  // namespace threewe::sim::view::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
