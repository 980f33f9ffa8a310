// How one fan is cast. For each candidate, a vector of them at a time, the interval of beams that can meet it is found;
// then each beam of the interval keeps the larger of its inverse range so far and that of the candidate. Inverse,
// because along a straight line it is A cos + B sin of the beam's angle: two products.
//
// Single precision is enough wherever a beam meets a surface at a fair angle, while the sensor moves too. The few
// candidates that are seen almost edge-on, or that are touched, take the careful path: double precision. A maximum has
// no order, so the bits depend on neither grouping nor vector length.
#include "sim/ray_caster_kernel.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <span>
#include <type_traits>
#include <utility>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sim/ray_caster_kernel.cpp"
#include "core/highway-inl.hpp"
//
#include "core/exact-inl.hpp"
#include "core/exact.hpp"

HWY_BEFORE_NAMESPACE();
namespace threewe::sim::kernel::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::CappedTag<float, kBlock>;
using Ints = hn::RebindToSigned<Floats>;
using Doubles = hn::CappedTag<double, kBlock / 2>;
using HalfFloats = hn::Rebind<float, Doubles>;
using F = hn::Vec<Floats>;
using V = hn::Vec<Doubles>;

constexpr float kTwoPi = 6.28318531F;
// Candidates that are looked at before any is met.
constexpr int kBatch = 8 * kBlock;
// Fans of more beams than this let the first vectors of all candidates' beams meet these, then the second ones.
constexpr int kManyBeams = 64;
// Intervals are widened by this much [rad], above all rounding of angles, so that no beam slips between neighbours.
constexpr float kAngleMargin = 2e-6F;
// A segment is careful when (its farthest range)^2 / (distance of its line) is above this [m]: single precision would
// be off by 4e-7 of that.
constexpr float kSegmentCare = 120.0F;
// A circle is careful when radius * distance is above this [m^2]: near its tangents the error grows with its root.
constexpr float kCircleCare = 0.6F;

// How much farther [rad] than it looks a candidate must be tried to either side, where it is out of sight, and where
// the sensor may touch it: more than once all around.
constexpr float kNowhere = -1.0F;
constexpr float kAround = 100.0F;

// Which beams to try on which candidates.
struct Tasks {
  static constexpr std::size_t kRoom = 3 * kBatch + kBlock;  // a whole vector is written at a time
  HWY_ALIGN std::int32_t first[kRoom];
  HWY_ALIGN std::int32_t last[kRoom];
  HWY_ALIGN std::int32_t place[kRoom];
  std::size_t count = 0;
  // those that have more vectors of beams, and the first beam of the next
  struct Next {
    std::int32_t task;
    std::int32_t vector;
  };
  std::array<Next, kRoom> waiting;
};

// Which bits of a byte are set, in ascending order.
struct ChosenLanes {
  std::array<std::array<std::uint8_t, 8>, 256> lane;
};
constexpr ChosenLanes kChosen = [] {
  ChosenLanes chosen{};
  for (std::size_t bits = 0; bits < 256; ++bits) {
    std::size_t count = 0;
    for (std::size_t j = 0; j < 8; ++j) {
      if (bits >> j & 1U) chosen.lane[bits][count++] = static_cast<std::uint8_t>(j);
    }
  }
  return chosen;
}();

// The numbers of beams, to be loaded as vectors.
struct BeamNumbers {
  alignas(64) std::array<std::int32_t, kMaxBeams + 2 * kBlock> number;
};
constexpr BeamNumbers kBeams = [] {
  BeamNumbers beams{};
  for (std::size_t i = 0; i < beams.number.size(); ++i) beams.number[i] = static_cast<std::int32_t>(i);
  return beams;
}();

// Constants of a fan for the set-up.
struct Frame {
  float middle_angle;  // [rad], in (-pi, pi]
  float beams_per_radian;
  float middle_beam;
  float last_beam;
  float origin_x;  // of the middle of the way, relative to the blocks
  float origin_y;
  float step_x;  // of the way, per beam
  float step_y;
  float reach;  // [m] of the way to either side
  bool narrow;  // so that most candidates lie beyond its edges, and need not be looked at
  float left_cos;
  float left_sin;
  float right_cos;
  float right_sin;
};

HWY_INLINE void copy(const SegmentBlock& from, int j, SegmentBlock& to, int place) {
  to.a_x[place] = from.a_x[j];
  to.a_y[place] = from.a_y[j];
  to.b_x[place] = from.b_x[j];
  to.b_y[place] = from.b_y[j];
  to.index[place] = from.index[j];
}

HWY_INLINE void copy(const CircleBlock& from, int j, CircleBlock& to, int place) {
  to.x[place] = from.x[j];
  to.y[place] = from.y[j];
  to.radius[place] = from.radius[j];
  to.index[place] = from.index[j];
}

// The directions of all beams, from heads and powers.
void point(Fan& fan, float nothing) {
  const Floats d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  HWY_ALIGN float power_cos[kBlock];
  HWY_ALIGN float power_sin[kBlock];
  for (std::size_t j = 0; j < kBlock; ++j) {
    power_cos[j] = static_cast<float>(fan.powers->cos[j]);
    power_sin[j] = static_cast<float>(fan.powers->sin[j]);
  }
  for (int i = 0; i < fan.sweep.count; i += kBlock) {
    const F head_cos = hn::Set(d, static_cast<float>(fan.head_cos[static_cast<std::size_t>(i / kBlock)]));
    const F head_sin = hn::Set(d, static_cast<float>(fan.head_sin[static_cast<std::size_t>(i / kBlock)]));
    for (int j = 0; j < kBlock; j += lanes) {
      const F c = hn::Load(d, power_cos + j);
      const F s = hn::Load(d, power_sin + j);
      hn::Store(hn::Sub(hn::Mul(head_cos, c), hn::Mul(head_sin, s)), d, fan.cos.data() + i + j);
      hn::Store(hn::Add(hn::Mul(head_sin, c), hn::Mul(head_cos, s)), d, fan.sin.data() + i + j);
      hn::Store(hn::Set(d, nothing), d, fan.inverse_range.data() + i + j);
    }
  }
}

// The lanes of a mask, the chosen ones first. Highway's own Compress copies its table at every call (1.0, with GCC).
using Order = decltype(hn::IndicesFromVec(Ints(), hn::Zero(Ints())));
HWY_INLINE Order order_of(hn::Mask<Ints> mask) {
  const Ints di;
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(di, mask, bytes);
  if constexpr (hn::MaxLanes(Ints()) <= 8) {
    const hn::Rebind<std::uint8_t, Ints> bytes_of_lanes;
    return hn::IndicesFromVec(di, hn::PromoteTo(di, hn::LoadU(bytes_of_lanes, kChosen.lane[bytes[0]].data())));
  } else {
    return hn::IndicesFromVec(di, hn::Compress(hn::Iota(di, 0), mask));
  }
}

// Adds tasks, in the lanes of a mask. No branches here: which candidates have beams is hard to foresee.
HWY_INLINE void append(hn::Mask<Floats> mask, hn::Vec<Ints> first, hn::Vec<Ints> last, hn::Vec<Ints> place,
                       Tasks& tasks) {
  const Ints di;
  const Order order = order_of(hn::RebindMask(di, mask));
  hn::StoreU(hn::TableLookupLanes(first, order), di, tasks.first + tasks.count);
  hn::StoreU(hn::TableLookupLanes(last, order), di, tasks.last + tasks.count);
  hn::StoreU(hn::TableLookupLanes(place, order), di, tasks.place + tasks.count);
  tasks.count += hn::CountTrue(Floats(), mask);
}

// Adds those that have beams between `low` and `high`, counted in beams.
HWY_INLINE void add_tasks(hn::Mask<Floats> visible, F low, F high, hn::Vec<Ints> place, const Frame& frame,
                          Tasks& tasks) {
  const Floats d;
  const Ints di;
  const F first = hn::Max(hn::Ceil(low), hn::Zero(d));
  const F last = hn::Min(hn::Floor(high), hn::Set(d, frame.last_beam));
  const auto some = hn::And(visible, hn::Le(first, last));
  append(some, hn::ConvertTo(di, first), hn::ConvertTo(di, last), place, tasks);
}

// Turns where a vector of candidates from `first_place` on is seen, from an angle counter-clockwise, into intervals of
// beams.
HWY_INLINE void find_beams(F seen_first, F seen_width, F slack, int first_place, const Frame& frame, Tasks& tasks) {
  const Floats d;
  const Ints di;
  const F start = hn::Sub(seen_first, slack);
  const F width = hn::Add(seen_width, hn::Add(slack, slack));
  const auto visible = hn::Gt(slack, hn::Zero(d));
  // angles to beams: the middle of the candidate within half a turn of the middle of the fan
  const F relative = hn::Sub(start, hn::Set(d, frame.middle_angle));
  const F middle = hn::Add(relative, hn::Mul(width, hn::Set(d, 0.5F)));
  const F turns = hn::Round(hn::Mul(middle, hn::Set(d, 1.0F / kTwoPi)));
  const F nearest = hn::Sub(relative, hn::Mul(turns, hn::Set(d, kTwoPi)));
  const F scale = hn::Set(d, frame.beams_per_radian);
  const F end0 = hn::Mul(nearest, scale);
  const F end1 = hn::Mul(hn::Add(nearest, width), scale);
  const F low = hn::Add(hn::Min(end0, end1), hn::Set(d, frame.middle_beam));
  const F high = hn::Add(hn::Max(end0, end1), hn::Set(d, frame.middle_beam));
  const auto place = hn::Add(hn::Iota(di, 0), hn::Set(di, first_place));  // Iota of a variable is slow in Highway 1.0
  add_tasks(visible, low, high, place, frame, tasks);

  // what lies across the back of a fan of a whole turn is seen from both its ends; few do, and they stand together
  const F turn = hn::Set(d, kTwoPi * std::fabs(frame.beams_per_radian));
  const F after = hn::Add(low, turn);
  const F before = hn::Sub(high, turn);
  const auto beyond = hn::Or(hn::Le(after, hn::Set(d, frame.last_beam)), hn::Ge(before, hn::Zero(d)));
  const auto across = hn::And(visible, beyond);
  if (hn::AllFalse(d, across)) return;
  add_tasks(across, after, hn::Add(high, turn), place, frame, tasks);
  add_tasks(across, hn::Sub(low, turn), before, place, frame, tasks);
}

// Runs `inverse_range(beam, cos, sin)` over those beams of a task that are in one vector, and keeps the larger.
template <class InverseRange>
HWY_INLINE void keep_larger(Fan& fan, const Tasks& tasks, std::size_t task, int vector,
                            const InverseRange& inverse_range) {
  const Floats d;
  const Ints di;
  const auto first = hn::Set(di, tasks.first[task]);
  const auto last = hn::Set(di, tasks.last[task]);
  const auto beam = hn::Load(di, kBeams.number.data() + vector);
  const auto outside = hn::RebindMask(d, hn::Or(hn::Lt(beam, first), hn::Gt(beam, last)));
  const F value = inverse_range(beam, hn::Load(d, fan.cos.data() + vector), hn::Load(d, fan.sin.data() + vector));
  float* kept = fan.inverse_range.data() + vector;
  hn::Store(hn::Max(hn::Load(d, kept), hn::IfThenZeroElse(outside, value)), d, kept);
}

// The same in double precision with each beam's own origin: `inverse_range(x, y, cos, sin)`.
template <class InverseRange>
HWY_INLINE void keep_larger_carefully(Fan& fan, int first, int last, const InverseRange& inverse_range) {
  const Doubles d;
  const HalfFloats df;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const Sweep& sweep = fan.sweep;
  const V ascending = hn::Iota(d, 0);
  for (int i = first & -lanes; i <= last; i += lanes) {
    const V beam = hn::Add(ascending, hn::Set(d, i));
    const auto inside = hn::And(hn::Ge(beam, hn::Set(d, first)), hn::Le(beam, hn::Set(d, last)));
    const V x = hn::Add(hn::Set(d, sweep.origin.x), hn::Mul(beam, hn::Set(d, sweep.step.x)));
    const V y = hn::Add(hn::Set(d, sweep.origin.y), hn::Mul(beam, hn::Set(d, sweep.step.y)));
    const V head_cos = hn::Set(d, fan.head_cos[static_cast<std::size_t>(i / kBlock)]);
    const V head_sin = hn::Set(d, fan.head_sin[static_cast<std::size_t>(i / kBlock)]);
    const V power_cos = hn::Load(d, fan.powers->cos.data() + i % kBlock);
    const V power_sin = hn::Load(d, fan.powers->sin.data() + i % kBlock);
    const V c = hn::Sub(hn::Mul(head_cos, power_cos), hn::Mul(head_sin, power_sin));
    const V s = hn::Add(hn::Mul(head_sin, power_cos), hn::Mul(head_cos, power_sin));
    const V value = hn::IfThenElseZero(inside, inverse_range(x, y, c, s));
    float* kept = fan.inverse_range.data() + i;
    hn::Store(hn::Max(hn::Load(df, kept), hn::DemoteTo(df, value)), df, kept);
  }
}

HWY_INLINE V cross(V ax, V ay, V bx, V by) { return hn::Sub(hn::Mul(ax, by), hn::Mul(ay, bx)); }

void intersect_carefully(Fan& fan, int first, int last, const scene::Segment& segment) {
  const Doubles d;
  const V along_x = hn::Set(d, segment.b.x - segment.a.x);
  const V along_y = hn::Set(d, segment.b.y - segment.a.y);
  keep_larger_carefully(fan, first, last, [&](V x, V y, V c, V s) HWY_ATTR {
    const V ax = hn::Sub(hn::Set(d, segment.a.x), x);
    const V ay = hn::Sub(hn::Set(d, segment.a.y), y);
    const V bx = hn::Sub(hn::Set(d, segment.b.x), x);
    const V by = hn::Sub(hn::Set(d, segment.b.y), y);
    const V height = cross(along_x, along_y, ax, ay);
    const V approach = cross(along_x, along_y, c, s);
    const auto between = hn::And(hn::Ge(cross(c, s, ax, ay), hn::Zero(d)), hn::Le(cross(c, s, bx, by), hn::Zero(d)));
    const auto ahead = hn::And(hn::Gt(height, hn::Zero(d)), hn::Gt(approach, hn::Zero(d)));
    return hn::IfThenElseZero(hn::And(between, ahead), hn::Div(approach, height));
  });
}

void intersect_carefully(Fan& fan, int first, int last, const scene::Circle& circle) {
  const Doubles d;
  const V radius_squared = hn::Set(d, circle.radius * circle.radius);
  keep_larger_carefully(fan, first, last, [&](V x, V y, V c, V s) HWY_ATTR {
    const V cx = hn::Sub(hn::Set(d, circle.center.x), x);
    const V cy = hn::Sub(hn::Set(d, circle.center.y), y);
    const V ahead = hn::Add(hn::Mul(c, cx), hn::Mul(s, cy));
    const V aside = cross(c, s, cx, cy);
    const V half_chord_squared = hn::Sub(radius_squared, hn::Mul(aside, aside));
    const V power = hn::Sub(hn::Add(hn::Mul(cx, cx), hn::Mul(cy, cy)), radius_squared);
    const auto outside = hn::And(hn::Gt(power, hn::Zero(d)), hn::Gt(ahead, hn::Zero(d)));
    const auto hit = hn::And(outside, hn::Ge(half_chord_squared, hn::Zero(d)));
    const V half_chord = hn::Sqrt(hn::Max(half_chord_squared, hn::Zero(d)));
    return hn::IfThenElseZero(hit, hn::Div(hn::Add(ahead, half_chord), power));
  });
}

// What is known of a batch of segments, by place.
struct SegmentBatch {
  HWY_ALIGN float a_x[kBatch];  // from the origin
  HWY_ALIGN float a_y[kBatch];
  HWY_ALIGN float b_x[kBatch];
  HWY_ALIGN float b_y[kBatch];
  HWY_ALIGN float a_angle[kBatch];
  HWY_ALIGN float b_angle[kBatch];
  HWY_ALIGN float slack[kBatch];
  HWY_ALIGN float along_x[kBatch];
  HWY_ALIGN float along_y[kBatch];
  HWY_ALIGN float height[kBatch];  // of the origin above the line, times length
  HWY_ALIGN float of_cos[kBatch];  // inverse range = of_cos * cos + of_sin * sin, if the sensor stands still
  HWY_ALIGN float of_sin[kBatch];
  HWY_ALIGN float care[kBatch];  // positive: single precision will not do
};

// Looks at a vector of segments from the middle of the way.
template <bool kMoves>
HWY_INLINE void see(const SegmentBlock& block, int j, int place, const Frame& frame, SegmentBatch& batch) {
  const Floats d;
  const F origin_x = hn::Set(d, frame.origin_x);
  const F origin_y = hn::Set(d, frame.origin_y);
  const F ax = hn::Sub(hn::Load(d, block.a_x + j), origin_x);
  const F ay = hn::Sub(hn::Load(d, block.a_y + j), origin_y);
  const F bx = hn::Sub(hn::Load(d, block.b_x + j), origin_x);
  const F by = hn::Sub(hn::Load(d, block.b_y + j), origin_y);
  const F along_x = hn::Sub(bx, ax);
  const F along_y = hn::Sub(by, ay);
  const F height = hn::Sub(hn::Mul(along_x, ay), hn::Mul(along_y, ax));
  const F square_a = hn::Add(hn::Mul(ax, ax), hn::Mul(ay, ay));
  const F square_b = hn::Add(hn::Mul(bx, bx), hn::Mul(by, by));
  const F square_length = hn::Add(hn::Mul(along_x, along_x), hn::Mul(along_y, along_y));
  hn::Store(ax, d, batch.a_x + place);
  hn::Store(ay, d, batch.a_y + place);
  hn::Store(bx, d, batch.b_x + place);
  hn::Store(by, d, batch.b_y + place);

  F lowest = height;
  auto visible = hn::Gt(height, hn::Zero(d));
  F slack = hn::Set(d, kAngleMargin);
  if constexpr (kMoves) {
    // on the way the line comes nearer by the reach, and each end turns by asin(reach / distance) at most
    const F reach = hn::Set(d, frame.reach);
    const F change = hn::Mul(reach, hn::Sqrt(square_length));
    lowest = hn::Sub(height, change);
    visible = hn::Gt(hn::Add(height, change), hn::Zero(d));
    const F square = hn::Min(square_a, square_b);
    const auto touched = hn::Or(hn::Le(lowest, hn::Zero(d)), hn::Le(square, hn::Mul(reach, reach)));
    const F sine = hn::Div(reach, hn::Sqrt(hn::Max(square, hn::Set(d, 1e-12F))));
    slack = hn::IfThenElse(touched, hn::Set(d, kAround), hn::Add(slack, hn::Mul(sine, hn::Set(d, 1.5708F))));
    hn::Store(along_x, d, batch.along_x + place);
    hn::Store(along_y, d, batch.along_y + place);
    hn::Store(height, d, batch.height + place);
  } else {
    const F inverse = hn::Div(hn::Set(d, 1.0F), height);
    hn::Store(hn::Mul(hn::Neg(along_y), inverse), d, batch.of_cos + place);
    hn::Store(hn::Mul(along_x, inverse), d, batch.of_sin + place);
  }
  hn::Store(hn::IfThenElse(visible, slack, hn::Set(d, kNowhere)), d, batch.slack + place);

  // careful if farthest^2 / distance > kSegmentCare, squared and without the division
  const F farthest = hn::Max(square_a, square_b);
  const F near = hn::Mul(hn::Max(lowest, hn::Zero(d)), hn::Set(d, kSegmentCare));
  hn::Store(hn::Sub(hn::Mul(hn::Mul(farthest, farthest), square_length), hn::Mul(near, near)), d, batch.care + place);
}

// The angles of many points. A loop of its own: what is long to wait for, yet waits for nothing else, overlaps.
HWY_INLINE void find_angles(const float* y, const float* x, int count, float* angle) {
  const Floats d;
  for (int i = 0; i < count; i += static_cast<int>(hn::Lanes(d))) {
    hn::Store(exact::HWY_NAMESPACE::atan2(d, hn::Load(d, y + i), hn::Load(d, x + i)), d, angle + i);
  }
}

HWY_INLINE void find_angles(SegmentBatch& batch, int count) {
  find_angles(batch.a_y, batch.a_x, count, batch.a_angle);
  find_angles(batch.b_y, batch.b_x, count, batch.b_angle);
}

// Seen from the free side, a stands to the left of b.
HWY_INLINE void find_beams(const SegmentBatch& batch, int count, const Frame& frame, Tasks& tasks) {
  const Floats d;
  for (int i = 0; i < count; i += static_cast<int>(hn::Lanes(d))) {
    const F first = hn::Load(d, batch.b_angle + i);
    const F width = hn::Sub(hn::Load(d, batch.a_angle + i), first);
    const F turned = hn::IfThenElse(hn::Lt(width, hn::Set(d, -1.0F)), hn::Add(width, hn::Set(d, kTwoPi)), width);
    find_beams(first, hn::Max(turned, hn::Zero(d)), hn::Load(d, batch.slack + i), i, frame, tasks);
  }
}

HWY_INLINE void intersect_standing(Fan& fan, const Tasks& tasks, std::size_t task, int vector,
                                   const SegmentBatch& batch, std::size_t place, const Frame&) {
  const Floats d;
  const F a = hn::Set(d, batch.of_cos[place]);
  const F b = hn::Set(d, batch.of_sin[place]);
  keep_larger(fan, tasks, task, vector,
              [&](hn::Vec<Ints>, F c, F s) HWY_ATTR { return hn::Add(hn::Mul(a, c), hn::Mul(b, s)); });
}

// On the way: each beam from its own origin, both ends tested.
HWY_INLINE void intersect_moving(Fan& fan, const Tasks& tasks, std::size_t task, int vector, const SegmentBatch& batch,
                                 std::size_t place, const Frame& frame) {
  const Floats d;
  const float along_x = batch.along_x[place];
  const float along_y = batch.along_y[place];
  const F height0 = hn::Set(d, batch.height[place]);
  const F sinking = hn::Set(d, along_x * frame.step_y - along_y * frame.step_x);
  const F a_x = hn::Set(d, batch.a_x[place]);
  const F a_y = hn::Set(d, batch.a_y[place]);
  const F b_x = hn::Set(d, batch.b_x[place]);
  const F b_y = hn::Set(d, batch.b_y[place]);
  const F step_x = hn::Set(d, frame.step_x);
  const F step_y = hn::Set(d, frame.step_y);
  const F middle = hn::Set(d, frame.middle_beam);
  keep_larger(fan, tasks, task, vector, [&](hn::Vec<Ints> beam, F c, F s) HWY_ATTR {
    const F i = hn::Sub(hn::ConvertTo(d, beam), middle);
    const F x = hn::Mul(i, step_x);
    const F y = hn::Mul(i, step_y);
    const F height = hn::Sub(height0, hn::Mul(i, sinking));
    const F approach = hn::Sub(hn::Mul(s, hn::Set(d, along_x)), hn::Mul(c, hn::Set(d, along_y)));
    const F left = hn::Sub(hn::Mul(c, hn::Sub(a_y, y)), hn::Mul(s, hn::Sub(a_x, x)));
    const F right = hn::Sub(hn::Mul(c, hn::Sub(b_y, y)), hn::Mul(s, hn::Sub(b_x, x)));
    const auto between = hn::And(hn::Ge(left, hn::Zero(d)), hn::Le(right, hn::Zero(d)));
    const auto ahead = hn::And(hn::Gt(height, hn::Zero(d)), hn::Gt(approach, hn::Zero(d)));
    return hn::IfThenElseZero(hn::And(between, ahead), hn::Div(approach, height));
  });
}

// What is known of a batch of circles, by place.
struct CircleBatch {
  HWY_ALIGN float angle[kBatch];
  HWY_ALIGN float slack[kBatch];
  HWY_ALIGN float x[kBatch];  // from the origin
  HWY_ALIGN float y[kBatch];
  HWY_ALIGN float radius_squared[kBatch];
  HWY_ALIGN float inverse_power[kBatch];  // of the origin with respect to the circle [1/m^2]
  HWY_ALIGN float care[kBatch];
};

template <bool kMoves>  // the reach of the way says enough
HWY_INLINE void see(const CircleBlock& block, int j, int place, const Frame& frame, CircleBatch& batch) {
  const Floats d;
  const F x = hn::Sub(hn::Load(d, block.x + j), hn::Set(d, frame.origin_x));
  const F y = hn::Sub(hn::Load(d, block.y + j), hn::Set(d, frame.origin_y));
  const F radius = hn::Load(d, block.radius + j);
  const F square = hn::Add(hn::Mul(x, x), hn::Mul(y, y));
  const F radius_squared = hn::Mul(radius, radius);
  const F power = hn::Sub(square, radius_squared);

  // from anywhere on the way it looks no wider than a circle that is larger by the reach; the tangent of half of that
  // is more than enough, as each beam is tested
  const F wide = hn::Add(radius, hn::Set(d, frame.reach));
  const F wide_power = hn::Sub(square, hn::Mul(wide, wide));
  const auto clear = hn::Gt(wide_power, hn::Zero(d));
  const F tangent = hn::Sqrt(hn::Max(wide_power, hn::Zero(d)));
  const F half_width = hn::Min(hn::Div(wide, tangent), hn::Set(d, 0.25F * kTwoPi));
  const F slack = hn::IfThenElse(clear, hn::Add(half_width, hn::Set(d, kAngleMargin)), hn::Set(d, kAround));
  const auto visible = hn::Gt(radius, hn::Zero(d));
  hn::Store(hn::IfThenElse(visible, slack, hn::Set(d, kNowhere)), d, batch.slack + place);

  const F large = hn::Sub(hn::Mul(square, radius_squared), hn::Set(d, kCircleCare * kCircleCare));
  hn::Store(hn::IfThenElse(clear, large, hn::Set(d, 1.0F)), d, batch.care + place);
  hn::Store(x, d, batch.x + place);
  hn::Store(y, d, batch.y + place);
  hn::Store(radius_squared, d, batch.radius_squared + place);
  hn::Store(hn::Div(hn::Set(d, 1.0F), power), d, batch.inverse_power + place);
}

HWY_INLINE void find_angles(CircleBatch& batch, int count) { find_angles(batch.y, batch.x, count, batch.angle); }

HWY_INLINE void find_beams(const CircleBatch& batch, int count, const Frame& frame, Tasks& tasks) {
  const Floats d;
  for (int i = 0; i < count; i += static_cast<int>(hn::Lanes(d))) {
    find_beams(hn::Load(d, batch.angle + i), hn::Zero(d), hn::Load(d, batch.slack + i), i, frame, tasks);
  }
}

HWY_INLINE void intersect_standing(Fan& fan, const Tasks& tasks, std::size_t task, int vector, const CircleBatch& batch,
                                   std::size_t place, const Frame&) {
  const Floats d;
  const F x = hn::Set(d, batch.x[place]);
  const F y = hn::Set(d, batch.y[place]);
  const F radius_squared = hn::Set(d, batch.radius_squared[place]);
  const F inverse_power = hn::Set(d, batch.inverse_power[place]);
  keep_larger(fan, tasks, task, vector, [&](hn::Vec<Ints>, F c, F s) HWY_ATTR {
    const F ahead = hn::Add(hn::Mul(c, x), hn::Mul(s, y));
    const F aside = hn::Sub(hn::Mul(c, y), hn::Mul(s, x));
    const F half_chord_squared = hn::Sub(radius_squared, hn::Mul(aside, aside));
    const auto hit = hn::Ge(half_chord_squared, hn::Zero(d));
    const F half_chord = hn::Sqrt(hn::Max(half_chord_squared, hn::Zero(d)));
    return hn::IfThenElseZero(hit, hn::Mul(hn::Add(ahead, half_chord), inverse_power));
  });
}

// On the way: each beam from its own origin.
HWY_INLINE void intersect_moving(Fan& fan, const Tasks& tasks, std::size_t task, int vector, const CircleBatch& batch,
                                 std::size_t place, const Frame& frame) {
  const Floats d;
  const F x0 = hn::Set(d, batch.x[place]);
  const F y0 = hn::Set(d, batch.y[place]);
  const F radius_squared = hn::Set(d, batch.radius_squared[place]);
  const F step_x = hn::Set(d, frame.step_x);
  const F step_y = hn::Set(d, frame.step_y);
  const F middle = hn::Set(d, frame.middle_beam);
  keep_larger(fan, tasks, task, vector, [&](hn::Vec<Ints> beam, F c, F s) HWY_ATTR {
    const F i = hn::Sub(hn::ConvertTo(d, beam), middle);
    const F x = hn::Sub(x0, hn::Mul(i, step_x));
    const F y = hn::Sub(y0, hn::Mul(i, step_y));
    const F ahead = hn::Add(hn::Mul(c, x), hn::Mul(s, y));
    const F aside = hn::Sub(hn::Mul(c, y), hn::Mul(s, x));
    const F half_chord_squared = hn::Sub(radius_squared, hn::Mul(aside, aside));
    const F power = hn::Sub(hn::Add(hn::Mul(x, x), hn::Mul(y, y)), radius_squared);
    const auto outside = hn::And(hn::Gt(power, hn::Zero(d)), hn::Gt(ahead, hn::Zero(d)));
    const auto hit = hn::And(outside, hn::Ge(half_chord_squared, hn::Zero(d)));
    const F half_chord = hn::Sqrt(hn::Max(half_chord_squared, hn::Zero(d)));
    return hn::IfThenElseZero(hit, hn::Div(hn::Add(ahead, half_chord), power));
  });
}

// How far [m] each of a vector of candidates stretches beyond an edge of the fan, at least; a direction to its left.
HWY_INLINE F beyond(const SegmentBlock& block, int j, const Frame& frame, float across_x, float across_y) {
  const Floats d;
  const F x = hn::Set(d, across_x);
  const F y = hn::Set(d, across_y);
  const F a = hn::Add(hn::Mul(hn::Load(d, block.a_x + j), x), hn::Mul(hn::Load(d, block.a_y + j), y));
  const F b = hn::Add(hn::Mul(hn::Load(d, block.b_x + j), x), hn::Mul(hn::Load(d, block.b_y + j), y));
  return hn::Sub(hn::Min(a, b), hn::Set(d, frame.origin_x * across_x + frame.origin_y * across_y));
}

HWY_INLINE F beyond(const CircleBlock& block, int j, const Frame& frame, float across_x, float across_y) {
  const Floats d;
  const F x = hn::Sub(hn::Load(d, block.x + j), hn::Set(d, frame.origin_x));
  const F y = hn::Sub(hn::Load(d, block.y + j), hn::Set(d, frame.origin_y));
  const F middle = hn::Add(hn::Mul(x, hn::Set(d, across_x)), hn::Mul(y, hn::Set(d, across_y)));
  return hn::Sub(middle, hn::Load(d, block.radius + j));
}

// Copies those candidates that are not wholly beyond an edge of a narrow fan. Returns how many.
template <class Block>
HWY_INLINE int choose(const Block* blocks, int count, const Frame& frame, Block* chosen) {
  constexpr float kMargin = 1e-3F;  // [m], above all rounding
  const Floats d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const F most = hn::Set(d, frame.reach + kMargin);
  int kept = 0;
  for (int i = 0; i < count; i += lanes) {
    const Block& block = blocks[i / kBlock];
    const auto left = hn::Le(beyond(block, i % kBlock, frame, -frame.left_sin, frame.left_cos), most);
    const auto right = hn::Le(beyond(block, i % kBlock, frame, frame.right_sin, -frame.right_cos), most);
    std::uint8_t bytes[8] = {};
    hn::StoreMaskBits(d, hn::And(left, right), bytes);
    for (unsigned bits = bytes[0] | bytes[1] << 8U; bits != 0; bits &= bits - 1) {
      const int j = i % kBlock + std::countr_zero(bits);
      copy(block, j, chosen[kept / kBlock], kept % kBlock);
      ++kept;
    }
  }
  static constexpr Block kNothing{};
  for (int place = kept; place % lanes != 0; ++place) copy(kNothing, 0, chosen[place / kBlock], place % kBlock);
  return kept;
}

// Looks at a batch of candidates after the other, finds the beams that each concerns, and lets these meet it.
template <class Batch, bool kMoves, bool kMany, class Block, class Shape>
HWY_INLINE void intersect_candidates(std::span<const Block> all_blocks, int all, std::span<const Shape> shapes,
                                     const Frame& frame, Fan& fan) {
  const int lanes = static_cast<int>(hn::Lanes(Floats()));
  for (int start = 0; start < all; start += kBatch) {
    Batch batch;
    Tasks tasks;
    const Block* blocks = all_blocks.data() + start / kBlock;
    int count = std::min(kBatch, all - start);
    alignas(Block) std::array<std::byte, kBatch / kBlock * sizeof(Block)> room;
    if (frame.narrow) {
      auto* chosen = reinterpret_cast<Block*>(room.data());
      count = choose(blocks, count, frame, chosen);
      blocks = chosen;
    }
    for (int i = 0; i < count; i += lanes) see<kMoves>(blocks[i / kBlock], i % kBlock, i, frame, batch);
    find_angles(batch, count);
    find_beams(batch, count, frame, tasks);

    const auto meet = [&](std::size_t task, int vector) HWY_ATTR {
      const auto place = static_cast<std::size_t>(tasks.place[task]);
      if constexpr (kMoves) {
        intersect_moving(fan, tasks, task, vector, batch, place, frame);
      } else {
        intersect_standing(fan, tasks, task, vector, batch, place, frame);
      }
    };
    std::size_t waiting = 0;
    for (std::size_t t = 0; t < tasks.count; ++t) {
      const auto place = static_cast<std::size_t>(tasks.place[t]);
      const int first_vector = tasks.first[t] & -lanes;
      if (batch.care[place] > 0.0F) {
        const std::int32_t index = blocks[place / kBlock].index[place % kBlock];
        intersect_carefully(fan, tasks.first[t], tasks.last[t], shapes[static_cast<std::size_t>(index)]);
      } else if constexpr (kMany) {
        meet(t, first_vector);
        tasks.waiting[waiting] = {static_cast<std::int32_t>(t), first_vector + lanes};
        waiting += first_vector + lanes <= tasks.last[t] ? 1 : 0;
      } else {
        for (int vector = first_vector; vector <= tasks.last[t]; vector += lanes) meet(t, vector);
      }
    }
    // how many wait is easier for the processor to foresee than how many vectors each has
    while (waiting > 0) {
      const std::size_t waited = std::exchange(waiting, 0);
      for (std::size_t i = 0; i < waited; ++i) {
        const auto [task, vector] = tasks.waiting[i];
        const auto t = static_cast<std::size_t>(task);
        meet(t, vector);
        tasks.waiting[waiting] = {task, vector + lanes};
        waiting += vector + lanes <= tasks.last[t] ? 1 : 0;
      }
    }
  }
}

void intersect_shapes(const Shapes& shapes, Fan& fan) {
  const Sweep& sweep = fan.sweep;
  const double middle = 0.5 * (sweep.count - 1);
  const Vec2 from_center = sweep.origin + middle * sweep.step - shapes.center;
  const bool moves = sweep.step != Vec2{};
  const std::size_t last = static_cast<std::size_t>(sweep.count) - 1;
  const std::size_t left = sweep.increment > 0.0 ? last : 0;
  const std::size_t right = last - left;
  const Frame frame{
      .middle_angle = static_cast<float>(wrap_angle(sweep.angle + middle * sweep.increment)),
      .beams_per_radian = static_cast<float>(sweep.count > 1 ? 1.0 / sweep.increment : 1e3),
      .middle_beam = static_cast<float>(middle),
      .last_beam = static_cast<float>(sweep.count - 1),
      .origin_x = static_cast<float>(from_center.x),
      .origin_y = static_cast<float>(from_center.y),
      .step_x = static_cast<float>(sweep.step.x),
      .step_y = static_cast<float>(sweep.step.y),
      .reach = moves ? static_cast<float>(middle * norm(sweep.step)) + 1e-5F : 0.0F,
      .narrow = std::fabs((sweep.count - 1) * sweep.increment) < 2.0,
      .left_cos = fan.cos[left],
      .left_sin = fan.sin[left],
      .right_cos = fan.cos[right],
      .right_sin = fan.sin[right],
  };
  const auto intersect_all = [&](auto is_moving, auto has_many) HWY_ATTR {
    intersect_candidates<SegmentBatch, is_moving(), has_many()>(shapes.segment_blocks, shapes.segment_count,
                                                                shapes.segments, frame, fan);
    intersect_candidates<CircleBatch, is_moving(), has_many()>(shapes.circle_blocks, shapes.circle_count,
                                                               shapes.circles, frame, fan);
  };
  constexpr std::true_type kYes;
  constexpr std::false_type kNo;
  const bool many = sweep.count > kManyBeams;
  if (moves) {
    many ? intersect_all(kYes, kYes) : intersect_all(kYes, kNo);
  } else {
    many ? intersect_all(kNo, kYes) : intersect_all(kNo, kNo);
  }
}

void invert(const Fan& fan, float range_max, float* ranges) {
  const Floats d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const int count = fan.sweep.count;
  for (int i = 0; i < count; i += lanes) {
    const F range = hn::Div(hn::Set(d, 1.0F), hn::Load(d, fan.inverse_range.data() + i));
    const F limited = hn::Min(range, hn::Set(d, range_max));
    if (i + lanes <= count) {
      hn::StoreU(limited, d, ranges + i);
    } else {
      HWY_ALIGN float rest[kBlock];
      hn::Store(limited, d, rest);
      std::copy_n(rest, count - i, ranges + i);
    }
  }
}

}  // namespace threewe::sim::kernel::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace threewe::sim::kernel {

HWY_EXPORT(point);
HWY_EXPORT(intersect_shapes);
HWY_EXPORT(invert);

void put(SegmentBlock& block, int place, const scene::Segment& segment, Vec2 center, int index) {
  const Vec2 a = segment.a - center;
  const Vec2 b = segment.b - center;
  block.a_x[place] = static_cast<float>(a.x);
  block.a_y[place] = static_cast<float>(a.y);
  block.b_x[place] = static_cast<float>(b.x);
  block.b_y[place] = static_cast<float>(b.y);
  block.index[place] = index;
}

void put(CircleBlock& block, int place, const scene::Circle& circle, Vec2 center, int index) {
  block.x[place] = static_cast<float>(circle.center.x - center.x);
  block.y[place] = static_cast<float>(circle.center.y - center.y);
  block.radius[place] = static_cast<float>(circle.radius);
  block.index[place] = index;
}

namespace {

// Each from two of half its size.
Powers powers_of(double increment) {
  Powers powers{.increment = increment};
  auto& [made, cos, sin, next_cos, next_sin] = powers;
  const auto [s1, c1] = exact::sincos(increment);
  cos = {1.0, c1};
  sin = {0.0, s1};
  for (std::size_t j = 2; j < kBlock; ++j) {
    const std::size_t p = j / 2;
    const std::size_t q = j - p;
    cos[j] = cos[p] * cos[q] - sin[p] * sin[q];
    sin[j] = sin[p] * cos[q] + cos[p] * sin[q];
  }
  next_cos = cos[8] * cos[8] - sin[8] * sin[8];
  next_sin = 2.0 * sin[8] * cos[8];
  return powers;
}

}  // namespace

void begin(const Sweep& sweep, double range_max, Fan& fan) {
  // a lidar that stands has the same from scan to scan
  static thread_local Powers powers;
  if (sweep.increment != powers.increment) powers = powers_of(sweep.increment);
  fan.sweep = sweep;
  fan.powers = &powers;

  // every 16th beam from the one before
  auto [s, c] = exact::sincos(sweep.angle);
  const std::size_t blocks = static_cast<std::size_t>(sweep.count + kBlock - 1) / kBlock;
  for (std::size_t k = 0; k < blocks; ++k) {
    fan.head_cos[k] = c;
    fan.head_sin[k] = s;
    const double next = c * powers.next_cos - s * powers.next_sin;
    s = s * powers.next_cos + c * powers.next_sin;
    c = next;
  }

  // to begin with they have met nothing: beyond the range, yet not infinitely far, so that nothing divides by zero
  HWY_DYNAMIC_DISPATCH(point)(fan, static_cast<float>(0.5 / range_max));
}

void intersect(const Shapes& shapes, Fan& fan) { HWY_DYNAMIC_DISPATCH(intersect_shapes)(shapes, fan); }

void finish(const Fan& fan, double range_max, float* ranges) {
  HWY_DYNAMIC_DISPATCH(invert)(fan, static_cast<float>(range_max), ranges);
}

}  // namespace threewe::sim::kernel
#endif
