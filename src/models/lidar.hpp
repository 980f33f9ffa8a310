// Lidar model: when and where the points of a turn are measured, how well, and the uniform scan that is made of them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/rng.hpp"
#include "threewe/core/samples.hpp"
#include "threewe/core/time.hpp"
#include "threewe/hardware/profile.hpp"
#include "threewe/models/randomization.hpp"

namespace threewe::models {

/// Where the points of a turn are taken. Point k leaves along `first_angle + k * angle_step` [rad] in the sensor's
/// frame, at k / points_per_turn of the turn.
///
/// The turn begins and ends behind the robot, at the edge between the scan's last beam and its first, and each point
/// sits in the middle of its own share of the circle: so a scan is one turn, in one direction, without a seam inside.
struct ScanPattern {
  double first_angle = 0.0;
  double angle_step = 0.0;  ///< negative for a device that turns clockwise
};
ScanPattern scan_pattern(const LidarSpec& spec);

/// This unit's constant offset of all ranges [m], drawn once per episode.
double lidar_bias(const LidarSpec& spec, const RngKey& key);

/// Makes measurements of true ranges [m], in place: 0 = invalid, range_max = no return. `first` counts points from the
/// beginning of the episode. `bias` is that of `lidar_bias`; a variation's `lidar_noise` scales it too. Single
/// precision is finer than what any lidar tells apart.
void measure_ranges(const LidarSpec& spec, const RngKey& key, double bias, std::uint64_t first, std::span<float> ranges,
                    const Variation& variation = {});

/// [m] By how much a point is measured too short, at most; by a variation's noise.
double most_too_short(const LidarSpec& spec, double bias, const Variation& variation);
/// Whether three of the points that `measure_ranges` makes of a turn, side by side or across its seam, are dropped.
bool drops_neighbours(const LidarSpec& spec, const RngKey& key, std::uint64_t first, const Variation& variation);

/// The beam or the two beams of a scan that a point of a turn counts for.
struct PointBeams {
  std::uint16_t first = 0;
  std::uint16_t second = 0;  ///< the same, unless the point lies on the edge of two
};
/// Those of each point of a turn, in the order in which points are taken.
std::vector<PointBeams> beams_of_points(const LidarSpec& spec);
/// Fills in the beams of a scan from the points of a turn: the nearest valid return among the points of each beam,
/// range_max if only no-returns, 0 if all were invalid.
void fill_scan(std::span<const PointBeams> beams_of_points, std::span<const float> points, std::span<float> ranges);

/// The scan of one turn that began at `turn_begin`, from its points in the order in which they were taken.
///
/// Beam i stands for the angles within half an increment of its own, both edges included, see `fill_scan`.
LaserScan make_scan(const LidarSpec& spec, std::span<const float> points);
/// When beam 0 of the scan was measured.
Time scan_time(const LidarSpec& spec, Time turn_begin);

}  // namespace threewe::models
