// Two robots share a world and drive at the same time.
#include <iostream>

#include "threewe/threewe.hpp"

int main() {
  threewe::World::Options options;
  options.scene = "office_v2";
  options.robots = {"3we_standard_v2", "turtlebot_like"};
  options.poses = {{0.0, 0.0, 0.0}, {0.0, 1.0, 0.0}};
  // both speak of the scene's frame
  options.initial_poses = options.poses;
  threewe::World world(options);
  threewe::Robot first(world, 0);
  threewe::Robot second(world, 1);

  // both motions begin here; robot time goes by while one of them is waited for
  const threewe::MotionHandle one = first.move_to(2.0, 0.0);
  const threewe::MotionHandle other = second.move_to(2.0, 1.0);
  const threewe::MoveResult a = first.wait(one);
  const threewe::MoveResult b = second.wait(other);

  std::cout << "first:  " << to_string(a.reason) << " after " << a.duration << " s\n"
            << "second: " << to_string(b.reason) << " after " << b.duration << " s\n";
  return a.success && b.success ? 0 : 1;
}
