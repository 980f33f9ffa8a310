// Where a scan fits a map, without a good guess: for closing loops, for a first pose in a given map, and for a robot
// that was carried off.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "threewe/core/pose.hpp"
#include "threewe/map/log_odds_map.hpp"
#include "threewe/map/occupancy_grid.hpp"

namespace threewe::slam {

/// Tries every pose of a window, in steps of a cell and of as small a turn as moves the farthest hit by two cells, and
/// finds the best one exactly, by branch and bound over maxima of the map (Olson 2009, Hess et al. 2016). Built once
/// for a finished submap or a given map; const, so that many may search at once.
class ScanSearch {
 public:
  /// The poses to try: position within `reach` of the center along the map's axes, heading within `turn`.
  struct Window {
    Pose2D center;
    Vec2 reach;                ///< [m]
    double turn = exact::kPi;  ///< [rad]; pi and more: all headings
  };
  struct Found {
    Pose2D pose;
    double score = 0.0;      ///< mean over the hits, each from 0 to 1: how near an occupied cell it lies
    double elsewhere = 0.0;  ///< best score more than 0.5 m or 15 degrees away; 0 when that is below the least score
  };

  explicit ScanSearch(const map::OccupancyGrid& grid);

  /// The whole map and all headings.
  Window everywhere() const;
  /// The best pose; empty when none scores `least` or more, or nothing was hit. Of equal ones the one whose position is
  /// nearest to the center wins, then the least turn, then the lower y, the lower x, the clockwise turn. `scan`: in the
  /// base frame. Of hits less than half a cell apart one counts.
  std::optional<Found> find(std::span<const map::Beam> scan, const Window& window, double least) const;

  std::size_t bytes() const;

 private:
  // Maxima over squares of cells, from each cell on towards higher x and y. Cells as far apart as a square is wide lie
  // side by side in one plane, so that the bounds of neighbouring squares are sums over neighbouring bytes.
  struct Level {
    Level(std::span<const std::uint8_t> scores, int width, int height, int level);

    std::size_t index(int x, int y) const {
      const int mask = (1 << shift) - 1;
      const auto plane = static_cast<std::size_t>((y & mask) << shift | (x & mask));
      const auto row = plane * static_cast<std::size_t>(rows) + static_cast<std::size_t>((y >> shift) + kMargin);
      return row * static_cast<std::size_t>(columns) + static_cast<std::size_t>((x >> shift) + kMargin);
    }
    // The scores that begin at a cell; null where all are 0.
    const std::uint8_t* tile(map::Cell c) const {
      const bool inside = static_cast<unsigned>((c.x >> shift) + kMargin) <= static_cast<unsigned>(columns - kMargin) &&
                          static_cast<unsigned>((c.y >> shift) + kMargin) <= static_cast<unsigned>(rows - kMargin);
      return inside ? &data[index(c.x, c.y)] : nullptr;
    }

    static constexpr int kMargin = 8;  // a tile may begin so far before the first column or row
    int shift;                         // squares are 1 << shift cells wide
    int columns;                       // of a plane, margins on both sides included
    int rows;
    std::vector<std::uint8_t> data;
  };
  class Search;

  double resolution_;
  Vec2 origin_;
  int width_;
  int height_;
  std::vector<Level> levels_;  // finest first
};

}  // namespace threewe::slam
