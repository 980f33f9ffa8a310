// Lengths of ways to where there is room, for a point that keeps its distance from hits: an estimate for searches.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "threewe/core/pose.hpp"

namespace threewe::nav {

/// A square grid of cells of size `cell` [m] about the origin. Ways lead through cells no nearer than `least` [m] to a
/// hit and end in the nearest that is `wanted` [m] from all of them; where none of those can be reached, at the edge,
/// `reach` [m] away.
class RoomField {
 public:
  RoomField(std::span<const Vec2> hits, double cell, double least, double wanted, double reach);
  /// [m]; infinity where no way leads on.
  double way_from(Vec2 place) const;

 private:
  std::size_t cell_at(Vec2 place) const;
  Vec2 center(std::size_t cell) const;
  void spread(const std::vector<std::size_t>& ends);

  double cell_;               // [m]
  int half_;                  // [cells] to either side of the middle one
  std::vector<double> room_;  // [m] to the nearest hit, at most `wanted`
  std::vector<double> way_;
  double least_;
};

}  // namespace threewe::nav
