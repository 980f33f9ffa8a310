// The inner part of the ray caster: one fan of beams against a list of shapes, vectorised.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "threewe/core/pose.hpp"
#include "threewe/scene/solid.hpp"

namespace threewe::sim::kernel {

/// Candidates come in blocks of this many, the widest vector there is.
inline constexpr int kBlock = 16;
/// Beams that are cast at a time.
inline constexpr int kMaxBeams = 1024;

/// Segments in single precision, relative to a point near the sensor. Unused places stay zero: no length, nothing to
/// see.
struct alignas(64) SegmentBlock {
  float a_x[kBlock] = {};
  float a_y[kBlock] = {};
  float b_x[kBlock] = {};
  float b_y[kBlock] = {};
  std::int32_t index[kBlock] = {};  // in `Shapes::segments`
};

struct alignas(64) CircleBlock {
  float x[kBlock] = {};
  float y[kBlock] = {};
  float radius[kBlock] = {};  // 0: nothing
  std::int32_t index[kBlock] = {};
};

void put(SegmentBlock& block, int place, const scene::Segment& segment, Vec2 center, int index);
void put(CircleBlock& block, int place, const scene::Circle& circle, Vec2 center, int index);

/// What may be hit: blocks for the fast path, the shapes themselves for the careful one.
struct Shapes {
  Vec2 center;  // the point that the blocks are relative to
  std::span<const SegmentBlock> segment_blocks;
  int segment_count = 0;  // places in use
  std::span<const CircleBlock> circle_blocks;
  int circle_count = 0;
  std::span<const scene::Segment> segments;
  std::span<const scene::Circle> circles;
};

/// Beam i leaves `origin + i * step` along `angle + i * increment`.
struct Sweep {
  Vec2 origin;
  Vec2 step;
  double angle = 0.0;
  double increment = 0.0;
  int count = 0;
};

/// Powers of a rotation by one increment, as complex numbers; and the sixteenth, from one block of beams to the next.
struct Powers {
  double increment = 0.0;
  alignas(64) std::array<double, kBlock> cos{1.0};
  alignas(64) std::array<double, kBlock> sin{};
  double next_cos = 1.0;
  double next_sin = 0.0;
};

/// A fan in the making: the directions of its beams, and the largest inverse range that each has met.
struct Fan {
  Sweep sweep;
  // beam 16 k + j points along head[k] * power[j]
  alignas(64) std::array<double, kMaxBeams / kBlock> head_cos;
  alignas(64) std::array<double, kMaxBeams / kBlock> head_sin;
  const Powers* powers;  // until the same thread begins another
  alignas(64) std::array<float, kMaxBeams + 2 * kBlock> cos;
  alignas(64) std::array<float, kMaxBeams + 2 * kBlock> sin;
  alignas(64) std::array<float, kMaxBeams + 2 * kBlock> inverse_range;
};

/// Points the beams of a sweep of at most kMaxBeams.
void begin(const Sweep& sweep, double range_max, Fan& fan);
/// Lets the beams meet shapes.
void intersect(const Shapes& shapes, Fan& fan);
/// Writes the ranges [m].
void finish(const Fan& fan, double range_max, float* ranges);

}  // namespace threewe::sim::kernel
