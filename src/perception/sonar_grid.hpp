// Sonar grid: occupancy evidence of the ultrasonic ranges and bumps of a robot without a lidar, good enough to plan a
// way round what stands there, and not to be localized by.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "map/log_odds_map.hpp"
#include "perception/params.hpp"
#include "threewe/core/footprint.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/core/samples.hpp"

namespace threewe::perception {

/// Evidence of echoes, after Moravec and Elfes (1985): the arc of an echo's cone may be occupied, the middle of the
/// cone up to it is free. No echo tells nothing: smooth surfaces that are met at a slant send none.
class SonarGrid {
 public:
  explicit SonarGrid(const Params::Sonar& sonar = {}, const Params::Bump& bump = {});

  /// An echo that is `explained`, by what others see, marks nothing: it only tells what is free.
  void update(const RangeData& echo, const Pose2D& map_from_sensor, bool explained = false);
  /// Takes a push [m/s^2, base frame] that no wheel can give for a bump: something stands at the side that it came
  /// from. True when it was one.
  bool detect_bump(Vec2 push, const Footprint& footprint, const Pose2D& map_from_base);

  const map::OccupancyGrid& grid() const { return map_.grid(); }
  std::uint64_t version() const { return map_.version(); }
  /// The middles of occupied cells within `radius` [m] of a point, row by row.
  std::vector<Vec2> occupied_near(Vec2 point, double radius) const;

 private:
  void insert(std::span<const map::Beam> beams);

  Params::Sonar sonar_;
  Params::Bump bump_;
  map::LogOddsMap map_;
  std::vector<map::Cell> occupied_;  // row by row, counted from the raster's origin
};

}  // namespace threewe::perception
