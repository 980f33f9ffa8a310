// Path fidelity score: normalised dynamic time warping.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "threewe/core/pose.hpp"

namespace threewe::task {

/// The distance [m] between points of a path, the reference's as well as the robot's: neither standing still nor the
/// control rate changes a score.
inline constexpr double kPathSpacing = 0.25;
/// The distance [m] at which two points are one step apart (`d_th`).
inline constexpr double kPathThreshold = 1.0;
/// The longest path, in points.
inline constexpr std::size_t kMostPathPoints = 96;

/// Points along a polyline, `spacing` apart from its first; its last point ends them.
std::vector<Vec2> points_along(const std::vector<Vec2>& corners, double spacing);

/// The score of a robot that has come this far. Plain data.
struct PathScore {
  /// The cheapest warping of the robot's path so far onto the first i + 1 points of the reference [m].
  std::array<double, kMostPathPoints> cost{};
  Vec2 last;                   ///< point of the robot's path
  Vec2 robot;                  ///< where it is now
  double next = kPathSpacing;  ///< [m] that it will have driven at the next point of its path
  friend bool operator==(const PathScore&, const PathScore&) = default;
};

/// At the beginning of a reference of 1 to 96 points, with the robot at `start`.
PathScore begin_score(const std::vector<Vec2>& reference, Vec2 start);
/// Takes note of where the robot is, straight from where it was: its path is `points_along` all that. Costs next to
/// nothing while there is no new point.
void advance(PathScore& score, const std::vector<Vec2>& reference, Vec2 robot);
/// nDTW = exp(-DTW(R, Q) / (|R| d_th)), in (0, 1], of the reference R and the robot's path Q (Ilharco et al. 2019,
/// "General evaluation for instruction conditioned navigation using dynamic time warping").
double ndtw(PathScore score, const std::vector<Vec2>& reference);

}  // namespace threewe::task
