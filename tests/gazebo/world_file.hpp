// What the stand-in reads of a world file.
#pragma once

#include <string>
#include <vector>

#include "threewe/core/pose.hpp"
#include "threewe/core/time.hpp"

/// A sensor of the model.
struct SensorFile {
  enum class Kind { lidar, imu, camera, rgbd, contact };
  Kind kind{};
  std::string topic;
  threewe::Duration period{};  // in whole milliseconds
  threewe::Pose2D mount;
  double height = 0.0;
  // of a lidar
  unsigned beams = 0;
  double angle_min = 0.0;
  double angle_max = 0.0;
  double range_min = 0.0;
  double range_max = 0.0;
  // of a camera
  int width = 0;
  int height_in_pixels = 0;
  double fov = 0.0;
  // standard deviations: of ranges; of an inertial unit
  double sigma = 0.0;
  double accelerometer_sigma = 0.0;
};

/// A system that publishes odometry.
struct OdometryFile {
  std::string topic;
  threewe::Duration period{};
  bool of_wheels = false;
};

struct WorldFile {
  std::string name;
  std::string model;
  threewe::Duration step{};
  double real_time_factor = 1.0;
  std::string command_topic;
  std::vector<SensorFile> sensors;
  std::vector<OdometryFile> odometries;
};

/// Reads a world with libsdformat, and the model that it includes. Throws std::runtime_error with what it complains of.
WorldFile read_world_file(const std::string& file);
