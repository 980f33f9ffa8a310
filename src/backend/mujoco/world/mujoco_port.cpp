#include "backend/mujoco/world/mujoco_port.hpp"

#include <optional>
#include <utility>

#include "backend/mujoco/world/mujoco_world.hpp"
#include "threewe/models/lidar.hpp"
#include "threewe/models/ultrasonic.hpp"

namespace threewe::backend::mujoco {

MujocoPort::MujocoPort(const MujocoWorld& world, const RobotProfile& profile)
    : SimulatedPort(world, profile, simulated_features(profile, false)),
      world_(world),
      truth_(world.scene_, profile.body, world.physics_, world.state_) {}

void MujocoPort::collect() {
  if (!connected()) return;
  const RobotState& state = world_.state_;
  const RobotModel& robot = world_.robot_;
  const RobotProfile& simulated = robot.profile;
  const auto pinged = ping_ready(robot, state);
  std::size_t ultrasonic = 0;  // sensors of that kind so far
  for (std::size_t i = 0; i < features().sensors.size(); ++i) {
    switch (features().sensors[i].type) {
      case SensorType::lidar:
        if (scan_ready(robot, state)) {
          const LidarSpec& lidar = *simulated.lidar;
          send(i, models::scan_time(lidar, state.time() - lidar.turn), state.time() + lidar.latency,
               models::make_scan(lidar, scan_points(robot, state)));
        }
        break;
      case SensorType::imu:
        if (imu_ready(robot, state)) send(i, state.time(), state.time() + simulated.imu->latency, state.imu);
        break;
      case SensorType::odometry:
        if (odometry_ready(robot, state)) {
          send(i, state.time(), state.time() + simulated.odometry.latency, state.odometry.reading);
        }
        break;
      case SensorType::battery:
        if (battery_ready(robot, state)) send(i, state.time(), state.time(), state.battery);
        break;
      case SensorType::ultrasonic:
        if (pinged == ultrasonic++) {
          const UltrasonicSpec& spec = *simulated.ultrasonics;
          send(i, state.time(), state.time() + spec.latency, models::range_data(spec, state.ultrasonic_range));
        }
        break;
      case SensorType::camera: break;
    }
  }
}

}  // namespace threewe::backend::mujoco
