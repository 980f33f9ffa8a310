// Unfused throughout, so that the bits are the same for every target.
#include "sim/renderer/meet.hpp"

#include <cstddef>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sim/renderer/meet.cpp"
#include "threewe/core/highway-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace threewe::sim::view::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Doubles = hn::CappedTag<double, kBlock>;
using D = hn::Vec<Doubles>;
using Floats = hn::CappedTag<float, 16>;
using F = hn::Vec<Floats>;
using Ints = hn::RebindToSigned<Floats>;

struct Hits {
  D near;
  D far;
  D face;
};

HWY_INLINE Hits meet_box(const Outline& outline, D slope) {
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
HWY_INLINE Hits meet_disc(const Outline& outline, D slope) {
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
    return {hn::IfThenElse(misses, zero, hn::IfThenElseZero(before, near)), far, hn::Zero(d)};
  }
  // the eye is above or below it
  const D behind = hn::Div(hn::Sub(ahead, r), beyond);
  return {hn::IfThenElse(misses, zero, infinity), hn::IfThenElse(before, far, behind), hn::Zero(d)};
}

unsigned meet_block(const Outline& outline, const double* slopes, const double* behind, Meeting& meeting) {
  const Doubles d;
  unsigned met = 0;
  for (std::size_t i = 0; i < kBlock; i += hn::Lanes(d)) {
    const D slope = hn::LoadU(d, slopes + i);
    const Hits hits = outline.is_disc ? meet_disc(outline, slope) : meet_box(outline, slope);
    const D limit = hn::LoadU(d, behind + i);
    const D far = hn::IfThenElse(hn::Gt(hits.far, limit), hits.far, limit);
    hn::Store(hits.near, d, meeting.near.data() + i);
    hn::Store(far, d, meeting.far.data() + i);
    hn::Store(hits.face, d, meeting.face.data() + i);
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(d, hn::Gt(hits.near, far), bits);
    met |= (bits[0] & ((1U << hn::Lanes(d)) - 1U)) << i;
  }
  return met;
}

void lay_rows(const Layers& layers, int begin, int end, float inverse, float rise, std::int32_t owner) {
  const Floats d;
  const Ints di;
  const auto last = static_cast<std::size_t>(end);
  auto i = static_cast<std::size_t>(begin);
  for (; i + hn::Lanes(d) <= last; i += hn::Lanes(d)) {
    const F w = hn::Add(hn::Set(d, inverse), hn::Mul(hn::Set(d, rise), hn::LoadU(d, layers.slopes + i)));
    hn::StoreU(w, d, layers.inverse + i);
    hn::StoreU(hn::Set(di, owner), di, layers.owner + i);
  }
  for (; i < last; ++i) {
    layers.inverse[i] = inverse + rise * layers.slopes[i];
    layers.owner[i] = owner;
  }
}

void put_rows(const Layers& layers, int begin, int end, float inverse, float rise, std::int32_t owner) {
  const Floats d;
  const Ints di;
  const auto last = static_cast<std::size_t>(end);
  auto i = static_cast<std::size_t>(begin);
  for (; i + hn::Lanes(d) <= last; i += hn::Lanes(d)) {
    const F w = hn::Add(hn::Set(d, inverse), hn::Mul(hn::Set(d, rise), hn::LoadU(d, layers.slopes + i)));
    const F there = hn::LoadU(d, layers.inverse + i);
    const auto nearer = hn::Gt(w, there);
    const auto before = hn::LoadU(di, layers.owner + i);
    hn::StoreU(hn::IfThenElse(nearer, w, there), d, layers.inverse + i);
    hn::StoreU(hn::IfThenElse(hn::RebindMask(di, nearer), hn::Set(di, owner), before), di, layers.owner + i);
  }
  for (; i < last; ++i) {
    const float w = inverse + rise * layers.slopes[i];
    if (!(w > layers.inverse[i])) continue;
    layers.inverse[i] = w;
    layers.owner[i] = owner;
  }
}

int changes(const std::int32_t* owner, int rows, std::int32_t* changed) {
  const Ints di;
  const auto last = static_cast<std::size_t>(rows);
  const auto lanes = hn::Lanes(di);
  int count = 0;
  const auto look_at = [&](std::size_t i) {
    changed[count] = static_cast<std::int32_t>(i);
    count += owner[i] != owner[i - 1] ? 1 : 0;
  };
  std::size_t i = 1;
  for (; i + lanes <= last; i += lanes) {
    const auto same = hn::Eq(hn::LoadU(di, owner + i), hn::LoadU(di, owner + i - 1));
    if (hn::AllTrue(di, same)) continue;
    for (std::size_t k = 0; k < lanes; ++k) look_at(i + k);
  }
  for (; i < last; ++i) look_at(i);
  return count;
}

}  // namespace threewe::sim::view::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace threewe::sim::view {

HWY_EXPORT(meet_block);
HWY_EXPORT(lay_rows);
HWY_EXPORT(put_rows);
HWY_EXPORT(changes);

unsigned meet(const Outline& outline, const double* slopes, const double* behind, Meeting& meeting) {
  return HWY_DYNAMIC_DISPATCH(meet_block)(outline, slopes, behind, meeting);
}

void lay(const Layers& layers, int begin, int end, float inverse, float rise, std::int32_t owner) {
  HWY_DYNAMIC_DISPATCH(lay_rows)(layers, begin, end, inverse, rise, owner);
}

void put(const Layers& layers, int begin, int end, float inverse, float rise, std::int32_t owner) {
  HWY_DYNAMIC_DISPATCH(put_rows)(layers, begin, end, inverse, rise, owner);
}

int find_changes(const std::int32_t* owner, int rows, std::int32_t* changed) {
  return HWY_DYNAMIC_DISPATCH(changes)(owner, rows, changed);
}

}  // namespace threewe::sim::view
#endif
