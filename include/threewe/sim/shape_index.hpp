// What a robot can run into or hear, and where near it something stands at all.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "threewe/core/pose.hpp"
#include "threewe/scene/geometry.hpp"

namespace threewe::sim {

/// The shapes of a slice behind a grid that tells which of them lie near a point. Const once built.
class ShapeIndex {
 public:
  ShapeIndex() = default;
  /// `reach` [m] is how far from a point a shape can matter, `cell` [m] how wide the grid's cells are: smaller ones
  /// know better, and take more memory.
  ShapeIndex(scene::Slice slice, double reach, double cell = 0.25);

  const scene::Slice& slice() const { return slice_; }

  /// The shapes that may lie within `reach` of `point`, and surely all that do: segments count from 0, circles follow.
  std::span<const std::uint16_t> near(Vec2 point) const;

 private:
  scene::Slice slice_;
  double cells_per_metre_ = 1.0;
  Vec2 origin_;
  int width_ = 0;
  int height_ = 0;
  std::vector<std::uint32_t> begins_;  // of each cell's part of `shapes_`, and one past the last
  std::vector<std::uint16_t> shapes_;
};

}  // namespace threewe::sim
