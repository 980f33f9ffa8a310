// Server: simulated robots as nodes of ROS 2, for programs that drive robots of that kind.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "threewe/backend/world.hpp"

namespace threewe::ros2 {

/// How a world is served.
struct ServeOptions {
  std::vector<std::string> namespaces;  ///< one for each robot, such as "/robot_1"; empty for none
  double speed = 1.0;                   ///< robot time over wall time; 0 is as fast as can be
  bool lockstep = false;                ///< each robot's command drives for one control period; then time stands still
  bool map = false;                     ///< the scene's map, and where the robots truly are in it
};

/// The robots of a world, each a node `simulator` in its namespace:
///
/// - topics of its sensors, by the `link:` of its profile, else `scan`, `imu`, `odom`, `battery_state`,
///   `ultrasonic/NAME` and `camera/...`; all reliable, in the layout of Jazzy and Kilted
/// - `tf` (odom -> base), `tf_static` and `robot_description`, the URDF
/// - `cmd_vel`, in Twist and TwistStamped; a command ends after the time that the profile's link states, else 0.5 s
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
