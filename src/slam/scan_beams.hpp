// Conversion of a scan into the beams that maps and the matcher take.
#pragma once

#include <functional>
#include <vector>

#include "map/log_odds_map.hpp"
#include "slam/params.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/core/samples.hpp"

namespace threewe::slam {

/// How far [beam] a beam's range was measured from its middle, on average, where a surface comes nearer to one side,
/// for a driver that spreads so many points of a turn over beams `angle_increment` [rad] apart. Of several points in
/// one beam it keeps the nearest; the first of them is half a point from the beam's edge on average.
double point_offset(int points_per_turn, double angle_increment);

/// The valid beams of a scan, in some frame. `frame_from_lidar(i)` is where the lidar was as it measured beam i; it is
/// asked for every eighth. What is `range_max` [m] away or farther counts as no return. `offset` [beam]: see
/// `point_offset`.
std::vector<map::Beam> beams_of(const LaserScan& scan, double range_max,
                                const std::function<Pose2D(std::size_t)>& frame_from_lidar,
                                const Params::Beams& params = {}, double offset = 0.0);

/// The same beams seen from another frame.
std::vector<map::Beam> transformed(const Pose2D& a_from_b, std::vector<map::Beam> beams_in_b);

/// With beams in between those that hit one flat surface more than `spacing` [m] apart: what a scan shows of a far wall
/// is no row of posts. `beams`: in order of angle, in one frame.
std::vector<map::Beam> filled(const std::vector<map::Beam>& beams, double spacing, const Params::Beams& params = {});

/// A map of some scans, made as large as it will be at once.
map::LogOddsMap drawn(const std::vector<std::vector<map::Beam>>& scans, const map::LogOddsMap::Settings& settings,
                      double range_bias);

}  // namespace threewe::slam
