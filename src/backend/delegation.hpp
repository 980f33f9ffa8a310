// Delegation port: localization and navigation that other programs on the robot do, such as SLAM Toolbox and Nav2.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "threewe/core/pose.hpp"
#include "threewe/core/time.hpp"

namespace threewe::map {
struct OccupancyGrid;
}

namespace threewe::backend {

/// A program that says where the robot is. Any thread may ask.
class ExternalLocalizer {
 public:
  /// What it has said so far.
  struct Report {
    std::optional<Pose2D> map_from_odom;  ///< empty until it has said so; `odom` as the odometry's samples have it
    Time updated{};                       ///< robot time at which it came last
    std::optional<std::array<double, 9>> covariance;  ///< of map_from_base (x, y, theta), row-major, where it is stated
    std::shared_ptr<const map::OccupancyGrid> map;    ///< null until it has come
    std::uint64_t map_version = 0;                    ///< counts the maps
    std::string missing;                              ///< what was refused or has not come, in words; may be empty
  };

  virtual ~ExternalLocalizer() = default;
  virtual Report report() const = 0;
};

/// A program that plans and drives, past our safety gate: while it does, the port sends no velocities. Any thread may
/// use it.
class ExternalNavigator {
 public:
  /// How a goal stands, in words of our own.
  enum class Outcome : std::uint8_t { running, reached, no_path, blocked, timeout, cancelled, lost, fault };
  /// How poses are driven to: one, by whatever way; along the path that they are, from where the robot stands; or to
  /// each of them in turn, by whatever way.
  enum class Way : std::uint8_t { to_pose, along_path, to_waypoints };
  struct Goal {
    std::vector<Pose2D> path;  ///< in `map`
    Way way = Way::to_pose;
  };
  /// How far the newest goal has come.
  struct Report {
    Outcome outcome = Outcome::running;
    std::string detail;                             ///< of a failure
    double distance_left = 0.0;                     ///< [m]
    double time_left = 0.0;                         ///< [s]
    std::size_t waypoint = 0;                       ///< to which of several poses the robot drives
    std::shared_ptr<const std::vector<Vec2>> plan;  ///< in `map`; null until one has come
  };

  virtual ~ExternalNavigator() = default;
  /// Begins a goal in place of the one before.
  virtual void start(const Goal& goal) = 0;
  /// The goal in progress is wanted no more. The port sends velocities again at once.
  virtual void cancel() = 0;
  virtual Report report() const = 0;
  /// What is wrong with the program, in words; empty while nothing is known to be.
  virtual std::string trouble() const = 0;
};

}  // namespace threewe::backend
