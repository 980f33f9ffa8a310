// What it costs a robot to be in a cell: nothing far from obstacles, more near them, everything inside its own radius.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "threewe/core/pose.hpp"
#include "threewe/map/occupancy_grid.hpp"

namespace threewe::map {

/// Squared distance, in cells, from each cell of a row-major grid to the nearest that is not 0 in `occupied`; never
/// more than kMaxDistance^2. Exact.
inline constexpr int kMaxDistance = 15;
void squared_distances(std::span<const std::uint8_t> occupied, int width, int height,
                       std::vector<std::int16_t>& squared);

/// A grid of weights for planning: the cost of a path is its length times the weight under it.
class Costmap {
 public:
  struct Settings {
    double lethal_radius = 0.13;   ///< [m] no path comes so near to an obstacle
    double caution_radius = 0.50;  ///< [m] weights fall to kFree here
    int near_weight = 32;          ///< added at the lethal radius
    int unknown_weight = 2;        ///< added where nothing is known: optimistic, but dearer than known to be free
  };
  using Weight = std::uint16_t;
  static constexpr Weight kFree = 4;
  static constexpr Weight kLethal = 0xFFFF;

  Costmap() : Costmap(Settings{}) {}
  explicit Costmap(const Settings& settings);

  /// Takes over a map, with `rim` unknown cells all around it and large enough to hold `include`, except
  /// for what lies too far away (fits_a_grid). Points in
  /// `obstacles` [m] count as occupied besides.
  void update(const OccupancyGrid& grid, std::span<const Vec2> obstacles, std::span<const Vec2> include, int rim = 20);
  /// Lethal cells within `radius` [m] of `point` that are no nearer to an obstacle than `point` itself become dear
  /// instead: the robot is so near already. No slit in a wall opens by that.
  void open_around(Vec2 point, double radius);

  int width() const { return width_; }
  int height() const { return height_; }
  double resolution() const { return resolution_; }
  bool contains(Cell c) const { return c.x >= 0 && c.y >= 0 && c.x < width_ && c.y < height_; }
  std::size_t index(Cell c) const {
    return static_cast<std::size_t>(c.y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(c.x);
  }
  Cell cell(Vec2 point) const;
  Vec2 center(Cell c) const;

  const std::vector<Weight>& weights() const { return weights_; }
  /// The weight at a cell; outside as if unknown and far from everything.
  Weight weight(Cell c) const;
  /// Distance [m] between the middles of this cell and of the nearest occupied one, at most kMaxDistance cells.
  double clearance(Cell c) const;
  /// Nothing is known about this cell.
  bool unknown(Cell c) const { return !contains(c) || unknown_[index(c)] != 0; }
  /// 1 for each unknown cell, else 0.
  const std::vector<std::uint8_t>& unknown() const { return unknown_; }
  /// The cost of a straight line [m times weight]; infinity where it meets a lethal cell.
  double line_cost(Vec2 a, Vec2 b) const;

 private:
  Settings settings_;
  int width_ = 0;
  int height_ = 0;
  double resolution_ = 0.05;
  Vec2 origin_;
  std::vector<std::uint8_t> occupied_;
  std::vector<std::uint8_t> unknown_;
  std::vector<std::int16_t> squared_;
  std::vector<Weight> weights_;
};

}  // namespace threewe::map
