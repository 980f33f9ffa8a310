// Path ahead of a robot, a look-up table for its rollouts.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "nav/mppi/rollout.hpp"
#include "threewe/core/pose.hpp"

namespace threewe::nav::mppi {

/// Points at even spacing along a polyline, from the one nearest to the robot on, with its direction there.
class PathTable {
 public:
  /// `path` in `odom`, not empty; `middle` and `unit` of the window; `reach` [m] is laid out, if the path is so long.
  void lay_out(std::span<const Vec2> path, Vec2 robot, Vec2 middle, double unit, double reach);

  PathView view() const;
  /// The path ends within the table.
  bool ends() const { return ends_; }
  Vec2 end() const { return points_[static_cast<std::size_t>(last_)]; }
  /// The point `ahead` [m] from the robot along the path, in `odom`.
  Vec2 point(double ahead) const;
  /// [m] laid out.
  double length() const { return last_ * spacing_; }

 private:
  void turn_along();

  std::array<Vec2, kPathPoints> points_{};  // in odom
  std::array<std::int32_t, kPathPoints> packed_{};
  std::array<std::int32_t, kPathPoints> directions_{};
  double spacing_ = 1.0;  // [m]
  double unit_ = 1.0;     // [m]
  int last_ = 0;
  bool ends_ = false;
};

}  // namespace threewe::nav::mppi
