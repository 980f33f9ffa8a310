// Ray-solid intersection for several columns at once.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "threewe/core/pose.hpp"

namespace threewe::sim::view {

/// Pictures are drawn in blocks of columns: 8, or as many as a vector holds, which is this many at most.
inline constexpr int kWidestBlock = 16;
/// As many as that for the target in use.
int block_width();

/// A solid's outline in the camera's frame. Along the ray (1, s) it lies between the inverse depths max(far lines) and
/// min(near lines), each of which is `slope * s + offset`; or between the roots of a quadratic.
struct Outline {
  struct Line {
    double slope;
    double offset;
    double face;
  };
  bool is_disc = false;
  int near_count = 0;
  int far_count = 0;
  std::array<Line, 4> near;
  std::array<Line, 4> far;
  Vec2 center;          // of a disc
  double beyond = 0.0;  // square of the distance to its centre, less that of its radius
};

/// Where the rays of a block of columns enter a solid: inverse depths, and by which face of a box.
struct Intersection {
  alignas(64) std::array<double, kWidestBlock> near;
  alignas(64) std::array<double, kWidestBlock> face;
};

/// Circles, as arrays whose lengths are padded to whole blocks.
struct Circles {
  std::vector<float> x;
  std::vector<float> y;
  std::vector<float> radius;
};
/// What a camera sees of the plane, widened by a pixel: between two lines through the eye, as slopes y / x.
struct Sector {
  Vec2 eye;
  Vec2 forward;
  Vec2 left;
  double most = 0.0;
  double least = 0.0;
};
/// Finds the circles that may reach into a sector: surely all that do. Room for all in `found`; the result tells how
/// many.
std::size_t find_within(const Circles& circles, const Sector& sector, std::uint32_t* found);

/// Finds where rays of some slopes meet an outline before `behind`, an inverse depth for each. The bits of the result
/// tell which do; the others' part of `intersection` means nothing.
unsigned intersect(const Outline& outline, const double* slopes, const double* behind, Intersection& intersection);

}  // namespace threewe::sim::view
