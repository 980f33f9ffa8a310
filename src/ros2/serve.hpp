// Server: simulated robots as nodes of ROS 2, for programs that drive robots of that kind.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "threewe/backend/world.hpp"
#include "threewe/map/occupancy_grid.hpp"

namespace threewe::ros2 {

/// What is shown of a served robot's autonomy stack, which drives it to goals.
class ServedAutonomy {
 public:
  virtual ~ServedAutonomy() = default;
  /// Counts the map's changes: equal numbers mean equal maps.
  virtual std::uint64_t map_version() const = 0;
  virtual map::OccupancyGrid map() const = 0;
  virtual Pose2D map_from_odom() const = 0;
  /// The path being followed, in `map`; empty while none is.
  virtual std::vector<Vec2> path() const = 0;
  /// Drives to a pose in a frame, `map`, `odom` or `base`, in place of where it was going.
  virtual void go_to(const std::string& frame, const Pose2D& pose) = 0;
};

/// How a world is served.
struct ServeOptions {
  std::vector<std::string> namespaces;  ///< one for each robot, such as "/robot_1"; empty for none
  double speed = 1.0;                   ///< robot time over wall time; 0 is as fast as can be
  bool lockstep = false;                ///< each robot's command drives for one control period; then time stands still
  bool map = false;                     ///< the scene's map, and where the robots truly are in it
  /// Of each robot, where they have one: its map, where the robot is in it, its plan and goals are topics, too.
  std::vector<ServedAutonomy*> autonomies = {};  // NOLINT(readability-redundant-member-init): g++ warns
};

/// The robots of a world, each a node `simulator` in its namespace:
///
/// - topics of its sensors, by the `link:` of its profile, else `scan`, `imu`, `odom`, `battery_state`,
///   `ultrasonic/NAME` and `camera/...`; all reliable, in the layout of Jazzy and Kilted
/// - `tf` (odom -> base), `tf_static` and `robot_description`, the URDF
/// - `cmd_vel`, in Twist and TwistStamped; a command ends after the time that the profile's link states, else 0.5 s
/// - with an autonomy stack `map`, map -> odom in `tf`, `plan`, and `goal_pose`, which is driven to
/// - `/clock`, of the first one; all stamps are robot time
///
/// One thread at a time may use it.
class Server {
 public:
  virtual ~Server() = default;
  /// Serves for a time [wall].
  virtual void run(Duration wall) = 0;
  /// Robot time.
  virtual Time now() const = 0;
};

/// Connects to all robots of a simulated world. Throws ConfigError for namespaces that ROS does not take or that do not
/// fit the robots, for a speed that is none, for a world that is not simulated, and as `make_world` does where the DDS
/// library is missing.
std::unique_ptr<Server> serve(std::unique_ptr<backend::World> world, const ServeOptions& options);

}  // namespace threewe::ros2
