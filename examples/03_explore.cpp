// Wake up in an unknown place, look around until nothing is left to see, and come back.
#include <iostream>
#include <string_view>

#include "threewe/threewe.hpp"

int main(int argc, char** argv) {
  const bool quick = argc > 1 && std::string_view(argv[1]) == "--quick";
  threewe::Robot robot({.scene = "office_v2", .seed = 7});

  const threewe::ExplorationHandle exploration = robot.explore(quick ? 20.0 : 600.0);
  while (!exploration.motion->done()) {
    robot.sleep(5.0);
    const auto& progress = exploration.motion->progress();
    std::cout << threewe::to_seconds(robot.now()) << " s: " << progress.distance_driven << " m driven\n";
  }
  const threewe::ExploreResult seen = robot.wait(exploration);
  std::cout << to_string(seen.reason) << ": " << seen.explored_area << " m^2 seen in " << seen.duration << " s\n";

  const threewe::MoveResult back = robot.wait(robot.move_to(0.0, 0.0));
  std::cout << "back at the start: " << (back.success ? "yes" : "no") << ", " << back.distance_to_goal << " m off\n";
  return back.success ? 0 : 1;
}
