// Spatial index of shapes for contact and sonar.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "threewe/core/pose.hpp"
#include "threewe/scene/solid.hpp"

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
  std::span<const std::uint16_t> near(Vec2 point) const {
    const double x = (point.x - origin_.x) * cells_per_metre_;
    const double y = (point.y - origin_.y) * cells_per_metre_;
    const bool inside = x >= 0.0 && y >= 0.0 && x < width_ && y < height_;
    if (!inside) return {};
    const auto cell = static_cast<std::uint32_t>(static_cast<int>(y) * width_ + static_cast<int>(x));
    return {shapes_.data() + begins_[cell], shapes_.data() + begins_[cell + 1]};
  }

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
