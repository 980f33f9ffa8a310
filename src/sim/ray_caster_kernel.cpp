// How one fan is cast. For each candidate, a vector of them at a time, the interval of beams that can meet it is found;
// then each beam of the interval keeps the larger of its inverse range so far and that of the candidate. Inverse,
// because along a straight line it is A cos + B sin of the beam's angle: two products.
//
// Single precision is enough wherever a beam meets a surface at a fair angle. The few candidates that are seen almost
// edge-on, and all of them while the sensor moves, take the careful path: double precision, each beam from its own
// origin, both ends tested. A maximum has no order, so the bits depend on neither grouping nor vector length.
#include "sim/ray_caster_kernel.hpp"

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sim/ray_caster_kernel.cpp"
#include "threewe/core/highway-inl.hpp"
//
#include "threewe/core/exact-inl.hpp"

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
// Intervals are widened by this much [rad], above all rounding of angles, so that no beam slips between neighbours.
constexpr float kAngleMargin = 2e-6F;
// A segment is careful when (its farthest range)^2 / (distance of its line) is above this [m]: single precision would be
// off by 3e-7 of that.
constexpr float kSegmentCare = 160.0F;
// A circle is careful when radius * distance is above this [m^2]: near its tangents the error grows with its root.
constexpr float kCircleCare = 0.6F;

// What the set-up of one vector of candidates finds.
struct Found {
  F first;         // angles [rad] relative to the middle of the fan, counter-clockwise
  F width;         // [rad]
  F slack;         // [rad] to be added at both ends
  hn::Mask<Floats> visible;
  hn::Mask<Floats> everywhere;  // the sensor may touch it: every beam must try
};

// The same, sorted out into whole beams.
struct Intervals {
  HWY_ALIGN std::int32_t first[kBlock];
  HWY_ALIGN std::int32_t last[kBlock];
  std::uint64_t visible = 0;  // one bit per candidate
};

// Constants of a fan for the set-up.
struct Frame {
  float middle_angle;  // [rad], in (-pi, pi]
  float beams_per_radian;
  float middle_beam;
  float last_beam;
  float origin_x;  // of the middle of the way, relative to the blocks
  float origin_y;
  float reach;  // [m] of the way to either side
};

HWY_INLINE void point_beams(Fan& fan) {
  const Floats d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  HWY_ALIGN float power_cos[kBlock];
  HWY_ALIGN float power_sin[kBlock];
  for (std::size_t j = 0; j < kBlock; ++j) {
    power_cos[j] = static_cast<float>(fan.power_cos[j]);
    power_sin[j] = static_cast<float>(fan.power_sin[j]);
  }
  for (int i = 0; i < fan.sweep.count; i += kBlock) {
    const F head_cos = hn::Set(d, static_cast<float>(fan.head_cos[static_cast<std::size_t>(i / kBlock)]));
    const F head_sin = hn::Set(d, static_cast<float>(fan.head_sin[static_cast<std::size_t>(i / kBlock)]));
    for (int j = 0; j < kBlock; j += lanes) {
      const F c = hn::Load(d, power_cos + j);
      const F s = hn::Load(d, power_sin + j);
      hn::Store(hn::Sub(hn::Mul(head_cos, c), hn::Mul(head_sin, s)), d, fan.cos.data() + i + j);
      hn::Store(hn::Add(hn::Mul(head_sin, c), hn::Mul(head_cos, s)), d, fan.sin.data() + i + j);
    }
  }
}

// Which beams, at a whole number of turns away, lie between `low` and `high`, counted in beams.
HWY_INLINE void select(F low, F high, F shift, hn::Mask<Floats> visible, const Frame& frame, Intervals& out) {
  const Floats d;
  const Ints di;
  const F first = hn::Max(hn::Ceil(hn::Add(low, shift)), hn::Zero(d));
  const F last = hn::Min(hn::Floor(hn::Add(high, shift)), hn::Set(d, frame.last_beam));
  const auto some = hn::And(visible, hn::Le(first, last));
  hn::Store(hn::ConvertTo(di, hn::IfThenElseZero(some, first)), di, out.first);
  hn::Store(hn::ConvertTo(di, hn::IfThenElseZero(some, last)), di, out.last);
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(d, some, bytes);
  out.visible = std::uint64_t{bytes[0]} | std::uint64_t{bytes[1]} << 8;
}

// Calls `trace(place, first, last)` for every candidate of a vector and every interval of beams that can meet it.
template <class Trace>
HWY_INLINE void for_each_interval(const Found& found, const Frame& frame, const Trace& trace) {
  const Floats d;
  const auto visit = [&](const Intervals& intervals) {
    for (std::uint64_t bits = intervals.visible; bits != 0; bits &= bits - 1) {
      const auto place = static_cast<std::size_t>(__builtin_ctzll(bits));
      trace(static_cast<int>(place), intervals.first[place], intervals.last[place]);
    }
  };

  // angles to beams: the middle of the candidate within half a turn of the middle of the fan
  const F relative = hn::Sub(found.first, hn::Set(d, frame.middle_angle));
  const F middle = hn::Add(relative, hn::Mul(found.width, hn::Set(d, 0.5F)));
  const F turns = hn::Round(hn::Mul(middle, hn::Set(d, 1.0F / kTwoPi)));
  const F nearest = hn::Sub(relative, hn::Mul(turns, hn::Set(d, kTwoPi)));
  const F scale = hn::Set(d, frame.beams_per_radian);
  const F end0 = hn::Mul(hn::Sub(nearest, found.slack), scale);
  const F end1 = hn::Mul(hn::Add(hn::Add(nearest, found.width), found.slack), scale);
  const F all = hn::Set(d, 1e6F);
  const F low = hn::IfThenElse(found.everywhere, hn::Neg(all), hn::Add(hn::Min(end0, end1), hn::Set(d, frame.middle_beam)));
  const F high = hn::IfThenElse(found.everywhere, all, hn::Add(hn::Max(end0, end1), hn::Set(d, frame.middle_beam)));

  Intervals intervals;
  select(low, high, hn::Zero(d), found.visible, frame, intervals);
  visit(intervals);

  // seldom: what lies across the back of a fan of a whole turn is seen from both its ends
  const F turn = hn::Set(d, kTwoPi * std::fabs(frame.beams_per_radian));
  const auto wraps_up = hn::And(found.visible, hn::Le(hn::Add(low, turn), hn::Set(d, frame.last_beam)));
  const auto wraps_down = hn::And(found.visible, hn::Ge(hn::Sub(high, turn), hn::Zero(d)));
  if (!hn::AllFalse(d, wraps_up)) {
    select(low, high, turn, hn::AndNot(found.everywhere, wraps_up), frame, intervals);
    visit(intervals);
  }
  if (!hn::AllFalse(d, wraps_down)) {
    select(low, high, hn::Neg(turn), hn::AndNot(found.everywhere, wraps_down), frame, intervals);
    visit(intervals);
  }
}

// Runs `inverse_range(beam, cos, sin)` over the beams of an interval and keeps the larger.
template <class InverseRange>
HWY_INLINE void keep_larger(Fan& fan, int first, int last, const InverseRange& inverse_range) {
  const Floats d;
  const Ints di;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto before = hn::Set(di, first - 1);
  const auto after = hn::Set(di, last + 1);
  for (int i = first & -lanes; i <= last; i += lanes) {
    const auto beam = hn::Iota(di, i);
    const auto inside = hn::And(hn::Gt(beam, before), hn::Gt(after, beam));
    const F value = inverse_range(hn::Load(d, fan.cos.data() + i), hn::Load(d, fan.sin.data() + i));
    float* kept = fan.inverse_range.data() + i;
    hn::Store(hn::Max(hn::Load(d, kept), hn::IfThenElseZero(hn::RebindMask(d, inside), value)), d, kept);
  }
}

// The same in double precision with each beam's own origin: `inverse_range(x, y, cos, sin)`.
template <class InverseRange>
HWY_INLINE void keep_larger_carefully(Fan& fan, int first, int last, const InverseRange& inverse_range) {
  const Doubles d;
  const HalfFloats df;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const Sweep& sweep = fan.sweep;
  for (int i = first & -lanes; i <= last; i += lanes) {
    const V beam = hn::Iota(d, i);
    const auto inside = hn::And(hn::Ge(beam, hn::Set(d, first)), hn::Le(beam, hn::Set(d, last)));
    const V x = hn::Add(hn::Set(d, sweep.origin.x), hn::Mul(beam, hn::Set(d, sweep.step.x)));
    const V y = hn::Add(hn::Set(d, sweep.origin.y), hn::Mul(beam, hn::Set(d, sweep.step.y)));
    const V head_cos = hn::Set(d, fan.head_cos[static_cast<std::size_t>(i / kBlock)]);
    const V head_sin = hn::Set(d, fan.head_sin[static_cast<std::size_t>(i / kBlock)]);
    const V power_cos = hn::Load(d, fan.power_cos.data() + i % kBlock);
    const V power_sin = hn::Load(d, fan.power_sin.data() + i % kBlock);
    const V c = hn::Sub(hn::Mul(head_cos, power_cos), hn::Mul(head_sin, power_sin));
    const V s = hn::Add(hn::Mul(head_sin, power_cos), hn::Mul(head_cos, power_sin));
    const V value = hn::IfThenElseZero(inside, inverse_range(x, y, c, s));
    float* kept = fan.inverse_range.data() + i;
    hn::Store(hn::Max(hn::Load(df, kept), hn::DemoteTo(df, value)), df, kept);
  }
}

HWY_INLINE V cross(V ax, V ay, V bx, V by) { return hn::Sub(hn::Mul(ax, by), hn::Mul(ay, bx)); }

void meet_carefully(Fan& fan, int first, int last, const scene::Segment& segment) {
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

void meet_carefully(Fan& fan, int first, int last, const scene::Circle& circle) {
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

void meet_segments(const Shapes& shapes, const Frame& frame, bool moves, Fan& fan) {
  const Floats d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const F origin_x = hn::Set(d, frame.origin_x);
  const F origin_y = hn::Set(d, frame.origin_y);
  const F reach = hn::Set(d, frame.reach);
  HWY_ALIGN float slope_cos[kBlock];
  HWY_ALIGN float slope_sin[kBlock];
  HWY_ALIGN float care[kBlock];

  for (int i = 0; i < shapes.segment_count; i += lanes) {
    const SegmentBlock& block = shapes.segment_blocks[static_cast<std::size_t>(i / kBlock)];
    const int j = i % kBlock;
    const F normal_x = hn::Load(d, block.normal_x + j);
    const F normal_y = hn::Load(d, block.normal_y + j);
    const F along_normal = hn::Add(hn::Mul(normal_x, origin_x), hn::Mul(normal_y, origin_y));
    const F distance = hn::Sub(hn::Load(d, block.offset + j), along_normal);
    const F ax = hn::Sub(hn::Load(d, block.a_x + j), origin_x);
    const F ay = hn::Sub(hn::Load(d, block.a_y + j), origin_y);
    const F bx = hn::Sub(hn::Load(d, block.b_x + j), origin_x);
    const F by = hn::Sub(hn::Load(d, block.b_y + j), origin_y);

    // seen from the free side a stands to the left of b
    Found found;
    const F angle_b = exact::HWY_NAMESPACE::atan2(d, by, bx);
    const F width = hn::Sub(exact::HWY_NAMESPACE::atan2(d, ay, ax), angle_b);
    const F turned = hn::IfThenElse(hn::Lt(width, hn::Set(d, -1.0F)), hn::Add(width, hn::Set(d, kTwoPi)), width);
    found.first = angle_b;
    found.width = hn::Max(turned, hn::Zero(d));
    found.slack = hn::Set(d, kAngleMargin);
    found.visible = hn::Gt(distance, hn::Neg(reach));
    found.everywhere = hn::Lt(distance, hn::Zero(d));

    const F square_a = hn::Add(hn::Mul(ax, ax), hn::Mul(ay, ay));
    const F square_b = hn::Add(hn::Mul(bx, bx), hn::Mul(by, by));
    if (moves) {
      // the way turns the view of an end by asin(reach / distance) at most
      const F square = hn::Min(square_a, square_b);
      found.everywhere = hn::Or(hn::Le(distance, reach), hn::Le(square, hn::Mul(reach, reach)));
      const F sine = hn::Div(reach, hn::Sqrt(hn::Max(square, hn::Set(d, 1e-12F))));
      found.slack = hn::Add(hn::Mul(sine, hn::Set(d, 1.5708F)), hn::Set(d, kAngleMargin));
    }
    if (hn::AllFalse(d, found.visible)) continue;

    const F inverse = hn::Div(hn::Set(d, 1.0F), hn::IfThenElse(found.visible, distance, hn::Set(d, 1.0F)));
    const F farthest = hn::Max(square_a, square_b);
    hn::Store(hn::Mul(normal_x, inverse), d, slope_cos);
    hn::Store(hn::Mul(normal_y, inverse), d, slope_sin);
    hn::Store(hn::Sub(farthest, hn::Mul(distance, hn::Set(d, kSegmentCare))), d, care);
    for_each_interval(found, frame, [&](int place, int first, int last) HWY_ATTR {
      if (moves || care[place] > 0.0F) {
        meet_carefully(fan, first, last, shapes.segments[static_cast<std::size_t>(block.index[j + place])]);
      } else {
        const F a = hn::Set(d, slope_cos[place]);
        const F b = hn::Set(d, slope_sin[place]);
        keep_larger(fan, first, last,
                    [&](F c, F s) HWY_ATTR { return hn::Add(hn::Mul(a, c), hn::Mul(b, s)); });
      }
    });
  }
}

void meet_circles(const Shapes& shapes, const Frame& frame, bool moves, Fan& fan) {
  const Floats d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const F reach = hn::Set(d, frame.reach);
  HWY_ALIGN float center_x[kBlock];
  HWY_ALIGN float center_y[kBlock];
  HWY_ALIGN float inverse_power[kBlock];
  HWY_ALIGN float care[kBlock];

  for (int i = 0; i < shapes.circle_count; i += lanes) {
    const CircleBlock& block = shapes.circle_blocks[static_cast<std::size_t>(i / kBlock)];
    const int j = i % kBlock;
    const F x = hn::Sub(hn::Load(d, block.x + j), hn::Set(d, frame.origin_x));
    const F y = hn::Sub(hn::Load(d, block.y + j), hn::Set(d, frame.origin_y));
    const F radius = hn::Load(d, block.radius + j);
    const F square = hn::Add(hn::Mul(x, x), hn::Mul(y, y));
    const F power = hn::Sub(square, hn::Mul(radius, radius));

    // from anywhere on the way it looks no wider than a circle larger by the way
    const F wide = hn::Add(radius, reach);
    const F wide_power = hn::Sub(square, hn::Mul(wide, wide));
    const auto clear = hn::Gt(wide_power, hn::Zero(d));
    const F tangent = hn::Sqrt(hn::Max(wide_power, hn::Zero(d)));
    const F half_width = exact::HWY_NAMESPACE::atan2(d, wide, tangent);
    Found found;
    found.first = hn::Sub(exact::HWY_NAMESPACE::atan2(d, y, x), half_width);
    found.width = hn::Add(half_width, half_width);
    found.slack = hn::Set(d, kAngleMargin);
    found.visible = hn::Gt(radius, hn::Zero(d));
    found.everywhere = hn::Not(clear);

    hn::Store(x, d, center_x);
    hn::Store(y, d, center_y);
    hn::Store(hn::Div(hn::Set(d, 1.0F), hn::IfThenElse(clear, power, hn::Set(d, 1.0F))), d, inverse_power);
    const F limit = hn::Set(d, kCircleCare * kCircleCare);
    const F care_of_size = hn::Sub(hn::Mul(square, hn::Mul(radius, radius)), limit);
    hn::Store(hn::IfThenElse(clear, care_of_size, hn::Set(d, 1.0F)), d, care);
    for_each_interval(found, frame, [&](int place, int first, int last) HWY_ATTR {
      const scene::Circle& circle = shapes.circles[static_cast<std::size_t>(block.index[j + place])];
      if (moves || care[place] > 0.0F) return meet_carefully(fan, first, last, circle);
      const F cx = hn::Set(d, center_x[place]);
      const F cy = hn::Set(d, center_y[place]);
      const F radius_squared = hn::Set(d, block.radius[j + place] * block.radius[j + place]);
      const F inverse = hn::Set(d, inverse_power[place]);
      keep_larger(fan, first, last, [&](F c, F s) HWY_ATTR {
        const F ahead = hn::Add(hn::Mul(c, cx), hn::Mul(s, cy));
        const F aside = hn::Sub(hn::Mul(c, cy), hn::Mul(s, cx));
        const F half_chord_squared = hn::Sub(radius_squared, hn::Mul(aside, aside));
        const F half_chord = hn::Sqrt(hn::Max(half_chord_squared, hn::Zero(d)));
        return hn::IfThenElseZero(hn::Ge(half_chord_squared, hn::Zero(d)), hn::Mul(hn::Add(ahead, half_chord), inverse));
      });
    });
  }
}

void meet_shapes(const Shapes& shapes, Fan& fan) {
  const Sweep& sweep = fan.sweep;
  const double middle = 0.5 * (sweep.count - 1);
  const Vec2 from_center = sweep.origin + middle * sweep.step - shapes.center;
  const bool moves = sweep.step != Vec2{};
  const Frame frame{
      .middle_angle = static_cast<float>(wrap_angle(sweep.angle + middle * sweep.increment)),
      .beams_per_radian = static_cast<float>(sweep.count > 1 ? 1.0 / sweep.increment : 1e3),
      .middle_beam = static_cast<float>(middle),
      .last_beam = static_cast<float>(sweep.count - 1),
      .origin_x = static_cast<float>(from_center.x),
      .origin_y = static_cast<float>(from_center.y),
      .reach = moves ? static_cast<float>(middle * norm(sweep.step)) + 1e-5F : 0.0F,
  };
  meet_segments(shapes, frame, moves, fan);
  meet_circles(shapes, frame, moves, fan);
}

void point(Fan& fan) { point_beams(fan); }

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
HWY_EXPORT(meet_shapes);
HWY_EXPORT(invert);

void put(SegmentBlock& block, int place, const scene::Segment& segment, Vec2 center, int index) {
  const Vec2 a = segment.a - center;
  const Vec2 b = segment.b - center;
  const double length = norm(b - a);
  if (length == 0.0) return;
  const Vec2 normal = (1.0 / length) * Vec2{a.y - b.y, b.x - a.x};
  block.normal_x[place] = static_cast<float>(normal.x);
  block.normal_y[place] = static_cast<float>(normal.y);
  block.offset[place] = static_cast<float>(dot(normal, a));
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

void begin(const Sweep& sweep, double range_max, Fan& fan) {
  fan.sweep = sweep;

  // powers of one increment, each from two of half its size
  fan.power_cos[0] = 1.0;
  fan.power_sin[0] = 0.0;
  const auto [s1, c1] = exact::sincos(sweep.increment);
  fan.power_cos[1] = c1;
  fan.power_sin[1] = s1;
  for (std::size_t j = 2; j < kBlock; ++j) {
    const std::size_t p = j / 2;
    const std::size_t q = j - p;
    fan.power_cos[j] = fan.power_cos[p] * fan.power_cos[q] - fan.power_sin[p] * fan.power_sin[q];
    fan.power_sin[j] = fan.power_sin[p] * fan.power_cos[q] + fan.power_cos[p] * fan.power_sin[q];
  }

  // every 16th beam from the one before
  const double c16 = fan.power_cos[8] * fan.power_cos[8] - fan.power_sin[8] * fan.power_sin[8];
  const double s16 = 2.0 * fan.power_sin[8] * fan.power_cos[8];
  auto [s, c] = exact::sincos(sweep.angle);
  const std::size_t blocks = static_cast<std::size_t>(sweep.count + kBlock - 1) / kBlock;
  for (std::size_t k = 0; k < blocks; ++k) {
    fan.head_cos[k] = c;
    fan.head_sin[k] = s;
    const double next = c * c16 - s * s16;
    s = s * c16 + c * s16;
    c = next;
  }
  HWY_DYNAMIC_DISPATCH(point)(fan);

  // beyond the range, yet not infinitely far: nothing divides by zero
  std::fill_n(fan.inverse_range.begin(), blocks * kBlock, static_cast<float>(0.5 / range_max));
}

void meet(const Shapes& shapes, Fan& fan) { HWY_DYNAMIC_DISPATCH(meet_shapes)(shapes, fan); }

void finish(const Fan& fan, double range_max, float* ranges) {
  HWY_DYNAMIC_DISPATCH(invert)(fan, static_cast<float>(range_max), ranges);
}

}  // namespace threewe::sim::kernel
#endif
