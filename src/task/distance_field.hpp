// Compact geodesic distance field to one target: small enough to keep many, quick enough to ask at every step.
#pragma once

#include <cstdint>
#include <vector>

#include "scene/scene_tables.hpp"

namespace threewe::task {

/// The lengths of a `GeodesicField` at the middles of its cells, rounded to a 65,000th of the longest: a quarter of the
/// field's size, and no line of sight is asked for. 0.1 m between them would be too coarse: where the ways round both
/// sides of a thing meet, and beside narrow gaps, that is wrong by up to a quarter.
class DistanceField {
 public:
  DistanceField(const scene::SceneTables& tables, Vec2 target);

  Vec2 target() const { return target_; }
  /// Length [m] of the shortest path from a point to the target; infinity where there is none.
  double length_from(Vec2 point) const;

 private:
  double at(int x, int y) const;

  Vec2 target_;
  scene::GridFrame frame_;
  Vec2 first_;              // [m] centre of the first cell
  double per_metre_ = 0.0;  // cells
  double unit_ = 0.0;       // [m]
  std::vector<std::uint16_t> lengths_;
};

}  // namespace threewe::task
