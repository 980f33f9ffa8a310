// Where rays enter and leave a solid, and which of several surfaces is nearest: for many columns or rows at once.
#pragma once

#include <array>
#include <cstdint>

#include "threewe/core/pose.hpp"

namespace threewe::sim::view {

/// Columns are met in blocks of this many.
inline constexpr int kBlock = 8;

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

/// Where the rays of a block of columns pass through a solid, as inverse depths, and by which face they enter a box.
struct Meeting {
  alignas(64) std::array<double, kBlock> near;
  alignas(64) std::array<double, kBlock> far;
  alignas(64) std::array<double, kBlock> face;
};

/// Finds where rays of some slopes meet an outline before `behind`, an inverse depth for each. The bits of the result
/// tell which do; the others' part of `meeting` means nothing.
unsigned meet(const Outline& outline, const double* slopes, const double* behind, Meeting& meeting);

/// What a column shows so far, by row.
struct Layers {
  const float* slopes = nullptr;
  float* inverse = nullptr;  // the largest inverse depth
  std::int32_t* owner = nullptr;
};

/// Gives rows [begin, end) to an owner whose inverse depth is `inverse + rise * slope`.
void lay(const Layers& layers, int begin, int end, float inverse, float rise, std::int32_t owner);
/// The same where it is nearer than what is there.
void put(const Layers& layers, int begin, int end, float inverse, float rise, std::int32_t owner);

/// Finds the rows, beyond the first, whose owner is another than that of the row above. Room for all rows in `changed`;
/// the result tells how many there are.
int find_changes(const std::int32_t* owner, int rows, std::int32_t* changed);

}  // namespace threewe::sim::view
