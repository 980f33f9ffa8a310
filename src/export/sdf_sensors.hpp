// Gazebo sensors: in SDF, and within the <gazebo> elements of URDF.
#pragma once

#include "export/robot_description.hpp"
#include "xml.hpp"

namespace threewe::exports {

inline constexpr double kCameraNear = 0.01;  ///< [m] of cameras that state no limit
inline constexpr double kCameraFar = 100.0;  ///< [m]

/// The beams of a lidar, counter-clockwise and all round: the first at `min_angle`, none twice.
struct Lidar {
  int samples = 0;
  double min_angle = 0.0;  ///< [rad]
  double max_angle = 0.0;  ///< [rad]
};
Lidar lidar_of(const LidarSpec& spec);

/// Adds a sensor of Gazebo Harmonic to a link at a pose in it. Topics are the names of sensors; messages name the
/// sensor's frame.
void add_sdf_sensor(pugi::xml_node link, const SensorMount& mount, const RobotProfile& profile, const Transform& pose);

/// A pose as SDF writes it: x y z roll pitch yaw.
std::string sdf_pose(const Transform& pose);

}  // namespace threewe::exports
