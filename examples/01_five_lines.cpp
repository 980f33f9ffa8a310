// Drive to a place two metres ahead and one to the left.
#include <cstdio>

#include "threewe/threewe.hpp"

int main() {
  threewe::Robot robot;
  const threewe::MoveResult result = robot.wait(robot.move_to(2.0, 1.0));
  std::printf("Success: %s\n", result.success ? "true" : "false");
  return result.success ? 0 : 1;
}
