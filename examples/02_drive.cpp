// Drive by hand: velocities, readings, what the safety gate does about a wall, and the emergency stop.
#include <cstdio>
#include <string_view>

#include "threewe/threewe.hpp"

int main(int argc, char** argv) {
  const bool quick = argc > 1 && std::string_view(argv[1]) == "--quick";
  threewe::Robot robot;

  // a velocity holds for half a second unless it is renewed
  for (int i = 0; i < (quick ? 5 : 20); ++i) {
    robot.set_velocity(0.3, 0.0, 0.4);
    robot.sleep(0.2);
  }
  robot.stop();
  robot.sleep(0.5);
  const threewe::Pose2D pose = robot.get_pose();
  const threewe::LaserScan& scan = robot.get_lidar_scan();
  std::printf("at (%.2f, %.2f), heading %.2f rad; %.2f m to what is ahead\n", pose.x, pose.y, pose.theta,
              static_cast<double>(scan.ranges[scan.ranges.size() / 2]));

  // straight on until the gate says no: it stops the robot before what the lidar sees
  for (int i = 0; i < (quick ? 50 : 500); ++i) robot.execute_action({1.0, 0.0, 0.0}, 0.04);
  std::printf("contact at %.2f m/s\n", robot.simulation()->max_collision_speed());

  // an emergency stop is at once and stays until it is released
  robot.emergency_stop();
  try {
    robot.set_velocity(0.1, 0.0, 0.0);
  } catch (const threewe::EmergencyStopError& error) {
    std::printf("refused: %s\n", error.what());
  }
  robot.release_emergency_stop();
  return 0;
}
