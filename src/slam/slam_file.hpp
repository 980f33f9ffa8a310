// SLAM map file with all that is behind it: the pose graph, the scans at its nodes, and the trajectory.
#pragma once

#include <filesystem>

#include "slam/keyframe_graph.hpp"
#include "threewe/slam/slam.hpp"

namespace threewe::slam {

/// What a file holds. Text, so that it can be read, compared and mended: a line for each thing, numbers as short as
/// they can be without losing a bit.
struct SlamFile {
  SlamConfig config;
  double range_bias = 0.0;  ///< [m] by which all ranges are too long
  KeyframeGraphData keyframe_graph;
};

/// Writes it beside the place first, so that a file that was there is replaced as a whole or stays as it is. Throws
/// ConfigError when that fails.
void write_slam_file(const std::filesystem::path& path, const SlamFile& content);

/// Throws ConfigError with file:line, what is wrong and what would be right.
SlamFile read_slam_file(const std::filesystem::path& path);

}  // namespace threewe::slam
