// Branch-and-bound correlative scan matcher: for loop closure, global localization and a kidnapped robot.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <queue>
#include <span>
#include <tuple>
#include <vector>

#include "core/exact.hpp"
#include "map/log_odds_map.hpp"
#include "slam/params.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/map/occupancy_grid.hpp"

namespace threewe::slam {

/// Tries every pose of a window, in steps of a cell and of as small a turn as moves the farthest hit by two cells, and
/// finds the best one exactly, by branch and bound over maxima of the map (Olson 2009, Hess et al. 2016). Built once
/// for a finished submap or a given map; const, so that many may search at once.
class BranchAndBoundMatcher {
 public:
  /// The poses to try: position within `reach` of the center along the map's axes, heading within `turn`.
  struct Window {
    Pose2D center;
    Vec2 reach;                ///< [m]
    double turn = exact::kPi;  ///< [rad]; pi and more: all headings
  };
  struct Found {
    Pose2D pose;
    double score = 0.0;  ///< mean over the hits, each from 0 to 1: how near an occupied cell it lies
    double elsewhere =
        0.0;  ///< best score of any pose `elsewhere`, 0.5 m or 15 degrees away; 0 when below the least score
  };

  /// Poses are scored in tiles of so many by so many neighbours.
  static constexpr int kTile = 8;
  /// One search, that stops and goes on. The BranchAndBoundMatcher must outlive it.
  class Search;

  explicit BranchAndBoundMatcher(const map::OccupancyGrid& grid, const Params::GlobalSearch& params = {});

  /// The whole map and all headings.
  Window everywhere() const;
  /// The best pose; empty when none scores `least` or more, or nothing was hit. Of equal ones the one whose position is
  /// nearest to the center wins, then the least turn, then the lower y, the lower x, the clockwise turn. `scan`: in the
  /// base frame. Of hits less than half a cell apart one counts. Throws ContractError for a window that is none.
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
  using Sums = std::array<std::uint32_t, static_cast<std::size_t>(kTile) * kTile>;

  Sums sums_of_tile(std::span<const map::Cell> cells, int level, map::Cell offset) const;

  Params::GlobalSearch params_;
  double resolution_;
  Vec2 origin_;
  int width_;
  int height_;
  std::vector<Level> levels_;  // finest first
};

/// What has been looked into and what is yet to be. Plain data: a copy goes on the same.
class BranchAndBoundMatcher::Search {
 public:
  /// As BranchAndBoundMatcher::find takes them.
  Search(const BranchAndBoundMatcher& map, std::span<const map::Beam> scan, const Window& window, double least);

  /// Goes on for about so much work: what it takes to place a hit or to add a row of scores counts as one. What it
  /// finds does not depend on where it stopped. Returns whether it has ended; takes from `work` what it has done.
  bool go_on(std::int64_t& work);
  /// As BranchAndBoundMatcher::find returns it, once the search has ended.
  const std::optional<Found>& found() const { return found_; }

 private:
  enum class Phase : std::uint8_t { opening, best, reopening, elsewhere, ended };
  // The poses of one heading in a square of cells, kTile^level wide, that begins at (x, y); at level 0 a pose.
  struct Node {
    std::uint32_t bound = 0;  // no pose in it has a higher sum of scores; a pose has this one
    int level = 0;
    int turn = 0;
    int x = 0;
    int y = 0;
    friend bool operator<(const Node& a, const Node& b) { return a.bound < b.bound; }
  };
  // Orders poses, the best last.
  using Merit = std::tuple<std::uint32_t, std::int64_t, int, int, int, int>;

  void choose_headings();
  void step();
  void open_heading();
  void look_for_best();
  void look_elsewhere();
  void end();
  template <class Visit>
  void for_each_child(const Node& node, Visit visit);
  void expand(const Node& node);
  Merit merit(const Node& pose) const;
  bool is_elsewhere(const Node& node) const;
  Pose2D pose_of(const Node& pose) const;

  const BranchAndBoundMatcher* map_;
  Window window_;
  std::vector<Vec2> hits_;  // [m]
  double step_ = 0.0;       // [rad] between headings
  int first_turn_ = 0;      // headings are so many steps from the center's
  int last_turn_ = 0;
  int reach_x_ = 0;  // [cells]
  int reach_y_ = 0;
  std::uint32_t least_ = 0;  // sum of scores
  std::int64_t work_ = 0;    // that was done

  Phase phase_ = Phase::opening;
  std::vector<map::Cell> cells_;  // of the hits at the center, heading by heading
  std::priority_queue<Node> waiting_;
  std::vector<Node> looked_into_;  // of level 1; when all is opened again, those that are left
  std::optional<Node> best_;
  std::uint32_t second_ = 0;  // the best sum of scores elsewhere
  std::optional<Found> found_;
};

}  // namespace threewe::slam
