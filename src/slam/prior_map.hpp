// Prior map: a given map that stays as it is, and how well a scan agrees with it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "map/log_odds_map.hpp"
#include "slam/branch_and_bound_matcher.hpp"
#include "slam/params.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/map/occupancy_grid.hpp"

namespace threewe::slam {

/// What a scan, taken from some pose, has to do with a map.
struct Resemblance {
  int hits = 0;           ///< that lie where the map knows something
  int on_surface = 0;     ///< of these, next to what the map has occupied
  int beams = 0;          ///< that went through anything that the map knows
  int through_walls = 0;  ///< of these, through what it has occupied
  double agreement() const { return hits > 0 ? static_cast<double>(on_surface) / hits : 0.0; }
  double contradiction() const { return beams > 0 ? static_cast<double>(through_walls) / beams : 0.0; }
};

/// Made once, then shared by all that look for a place in it.
class PriorMap {
 public:
  explicit PriorMap(const map::OccupancyGrid& grid, const SharedParams& params = reference_params());

  /// The map as the matcher and mapping take it, to go on from.
  const map::LogOddsMap& surfaces() const { return surfaces_; }
  const BranchAndBoundMatcher& search() const { return search_; }
  /// `beams`: in the base frame.
  Resemblance compare(const Pose2D& map_from_base, std::span<const map::Beam> beams) const;
  /// A pose somewhere in the map, as likely here as there: its deviations [m, m].
  Vec2 spread() const;

 private:
  enum Cell : std::uint8_t { kUnknown, kFree, kNear, kOccupied };
  bool passes_wall(Vec2 from, Vec2 to) const;
  std::uint8_t at(map::Cell c) const { return grid_.contains(c) ? cells_[grid_.index(c)] : std::uint8_t{kUnknown}; }

  double before_wall_;  // [m]
  map::LogOddsMap surfaces_;
  BranchAndBoundMatcher search_;
  map::OccupancyGrid grid_;  // its shape; no data
  std::vector<std::uint8_t> cells_;
};

}  // namespace threewe::slam
