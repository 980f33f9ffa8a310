// MuJoCo models (MJCF). Their names are stable, so that programs find what they look for.
#pragma once

#include <span>
#include <string>

#include "export/robot_description.hpp"
#include "threewe/scene/scene.hpp"

namespace threewe::exports {

/// A robot in a scene, under a name that is unique there.
struct PlacedRobot {
  std::string name = "robot";
  RobotDescription description;
  Pose2D scene_from_base;
};

/// A MuJoCo 4 model of the scene and of robots in it, as XML.
///
/// Names, for a robot named `robot`: body and free joint `robot/base_link`; for each wheel, in the order of
/// `WheelSpeeds`, body, joint, actuator (its control is a wheel speed [rad/s]) and sensor `robot/<wheel>`; sites
/// `robot/lidar`, `robot/imu` and `robot/ultrasonic_...`, camera `robot/camera`; sensors `robot/gyro`,
/// `robot/accelerometer`, `robot/orientation` and `robot/ultrasonic_...`. People are mocap bodies `person/<name>`.
std::string mjcf(const scene::Scene& scene, std::span<const PlacedRobot> robots);

}  // namespace threewe::exports
