// Reader and writer of ROS maps (nav2_map_server): `map.yaml`, which names the image `map.pgm`.
#pragma once

#include <filesystem>

#include "threewe/map/occupancy_grid.hpp"

namespace threewe::map {

/// Reads a map and its picture, in ROS's `trinary` mode: each cell is free, occupied or unknown by the file's own
/// thresholds. Throws ConfigError naming the file and the field that is wrong, and what would be right.
OccupancyGrid load_ros_map(const std::filesystem::path& yaml);

/// Writes `yaml`, whose name ends in .yaml, and the image next to it, which has the same name and ends in .pgm: what
/// `load_ros_map` and ROS read back is free, occupied and unknown where `grid` is by ROS's default thresholds. Throws
/// ConfigError on a grid without cells, or where it cannot be written.
void save_ros_map(const OccupancyGrid& grid, const std::filesystem::path& yaml);

}  // namespace threewe::map
