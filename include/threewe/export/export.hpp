// Exporters of scenes and robots to MJCF, URDF, SDF, USD and ROS maps.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "threewe/hardware/profile.hpp"
#include "threewe/map/occupancy_grid.hpp"
#include "threewe/scene/scene.hpp"

namespace threewe::exports {

/// MuJoCo's model, the robot of ROS, Gazebo's world and model, a stage for Isaac Sim, and the map of ROS.
enum class Format : std::uint8_t { mjcf, urdf, sdf, usd, map };

/// The format of a name. Throws ConfigError naming the nearest right one.
Format format_named(std::string_view name);
/// The names of all formats.
std::vector<std::string> format_names();

/// A file and where it belongs, relative to the folder that is exported to.
struct File {
  std::filesystem::path path;  ///< relative to the folder that is written
  std::string contents;        ///< text or bytes
};

/// The files of a format, for a robot at the first start of a scene.
std::vector<File> files(const scene::Scene& scene, const RobotProfile& robot, Format format);

/// Writes files into a folder, which is made where it is missing; returns their paths. Throws ConfigError with the
/// path that cannot be written.
std::vector<std::filesystem::path> write(const std::vector<File>& files, const std::filesystem::path& folder);

/// What a robot maps: what stands in the plane of its lidar (without one: up to its height), and the floor that is
/// connected with its start. Cells of 5 cm that overlap something are occupied; the rest is unknown.
map::OccupancyGrid map_of(const scene::Scene& scene, const RobotProfile& robot);

}  // namespace threewe::exports
