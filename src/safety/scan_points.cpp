#include "safety/scan_points.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "core/exact.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "safety/scan_points.cpp"
#include "core/highway-inl.hpp"
//
#include "core/pose-inl.hpp"

#ifndef THREEWE_SAFETY_SCAN_POINTS_HITS
#define THREEWE_SAFETY_SCAN_POINTS_HITS
namespace threewe::safety {

// What some beams hit; room for whole vectors.
struct Hits {
  static constexpr std::size_t kRoom = 64;
  static constexpr std::size_t kVector = 8;         // numbers at most
  alignas(64) std::array<double, kRoom> share;      // of the turn gone by
  alignas(64) std::array<double, kRoom> direction;  // counted from the robot's back [rad]
  alignas(64) std::array<double, kRoom> range;      // [m]; then x
  alignas(64) std::array<double, kRoom> y;
  std::size_t count = 0;

  Hits() {}  // NOLINT: what is used is filled
  // Fills the vector that was begun last.
  void pad() {
    for (std::size_t i = count; i % kVector != 0; ++i) share[i] = direction[i] = range[i] = 0.0;
  }
};

// The lidar's way during a turn.
struct Way {
  Pose2D begin;
  Vec2 along;
  double turn = 0.0;
};

}  // namespace threewe::safety
#endif

HWY_BEFORE_NAMESPACE();
namespace threewe::safety::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Doubles = hn::CappedTag<double, Hits::kVector>;
using V = hn::Vec<Doubles>;

// Turns ranges into points.
void place(const Way& way, Hits& hits) {
  const Doubles d;
  const V begin_x = hn::Set(d, way.begin.x);
  const V begin_y = hn::Set(d, way.begin.y);
  const V begin_theta = hn::Set(d, way.begin.theta);
  for (std::size_t i = 0; i < hits.count; i += hn::Lanes(d)) {
    const V share = hn::Load(d, &hits.share[i]);
    const V range = hn::Load(d, &hits.range[i]);
    const V x = hn::Add(begin_x, hn::Mul(share, hn::Set(d, way.along.x)));
    const V y = hn::Add(begin_y, hn::Mul(share, hn::Set(d, way.along.y)));
    const V turned = hn::Add(begin_theta, hn::Mul(share, hn::Set(d, way.turn)));
    const V theta = threewe::HWY_NAMESPACE::wrap_angle(turned);
    const V angle = hn::Add(hn::Sub(theta, hn::Set(d, exact::kPi)), hn::Load(d, &hits.direction[i]));
    const auto [s, c] = exact::HWY_NAMESPACE::sincos(angle);
    hn::Store(hn::Add(x, hn::Mul(range, c)), d, &hits.range[i]);
    hn::Store(hn::Add(y, hn::Mul(range, s)), d, &hits.y[i]);
  }
}

// Lists the ranges that are no longer than that, in order; as many may be listed as there are. Returns how many.
std::size_t find_within(std::span<const float> ranges, float longest, std::uint32_t* found) {
  const hn::CappedTag<float, 16> d;
  constexpr std::size_t kLanes = hn::MaxLanes(d);
  std::size_t count = 0;
  std::size_t i = 0;
  for (; i + kLanes <= ranges.size(); i += kLanes) {
    std::uint8_t bytes[8] = {};
    hn::StoreMaskBits(d, hn::Le(hn::LoadU(d, &ranges[i]), hn::Set(d, longest)), bytes);
    for (unsigned bits = bytes[0] | bytes[1] << 8U; bits != 0; bits &= bits - 1) {
      found[count++] = static_cast<std::uint32_t>(i) + static_cast<std::uint32_t>(std::countr_zero(bits));
    }
  }
  for (; i < ranges.size(); ++i) {
    found[count] = static_cast<std::uint32_t>(i);
    count += static_cast<std::size_t>(ranges[i] <= longest);
  }
  return count;
}

}  // namespace threewe::safety::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace threewe::safety {

HWY_EXPORT(place);
HWY_EXPORT(find_within);

void append_scan_points(const LidarSpec& lidar, std::span<const float> ranges, const Pose2D& odom_from_lidar_at_begin,
                        const Pose2D& odom_from_lidar_at_end, std::vector<Vec2>& points, double longest) {
  const auto beams = static_cast<double>(ranges.size());
  const double increment = 2.0 * exact::kPi / beams;
  const auto rounded_up = static_cast<float>(longest * (1.0 + 1e-6));
  const Pose2D& begin = odom_from_lidar_at_begin;
  const Pose2D& end = odom_from_lidar_at_end;
  const Way way{begin, end.position() - begin.position(), wrap_angle(end.theta - begin.theta)};
  Hits hits;
  const auto put = [&] {
    hits.pad();
    HWY_DYNAMIC_DISPATCH(place)(way, hits);
    points.reserve(points.size() + hits.count);  // and no more: there may be thousands of such lists
    for (std::size_t k = 0; k < hits.count; ++k) points.push_back({hits.range[k], hits.y[k]});
    hits.count = 0;
  };
  // nearly all beams are longer than what concerns the gate
  constexpr std::size_t kAtOnce = 512;
  std::array<std::uint32_t, kAtOnce> near;  // NOLINT: what is used is filled
  for (std::size_t first = 0; first < ranges.size(); first += kAtOnce) {
    const auto some = ranges.subspan(first, std::min(kAtOnce, ranges.size() - first));
    const std::size_t count = HWY_DYNAMIC_DISPATCH(find_within)(some, rounded_up, near.data());
    for (const std::uint32_t within : std::span(near).first(count)) {
      const std::size_t i = first + within;
      const auto range = static_cast<double>(ranges[i]);
      if (range < lidar.range_min || range >= lidar.range_max || range > longest) continue;
      const double counted = (static_cast<double>(i) + 0.5) / beams;
      hits.share[hits.count] = lidar.rolling ? (lidar.clockwise ? 1.0 - counted : counted) : 1.0;
      hits.direction[hits.count] = static_cast<double>(i) * increment;
      hits.range[hits.count] = range;
      if (++hits.count == Hits::kRoom) put();
    }
  }
  if (hits.count > 0) put();
}

}  // namespace threewe::safety
#endif
