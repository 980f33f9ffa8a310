// Wake up in an unknown place, look around until nothing is left to see, and come back.
#include <cstdio>
#include <string_view>

#include "threewe/threewe.hpp"

int main(int argc, char** argv) {
  const bool quick = argc > 1 && std::string_view(argv[1]) == "--quick";
  threewe::Robot robot({.scene = "office_v2", .seed = 7});

  const threewe::ExplorationHandle exploration = robot.explore(quick ? 20.0 : 600.0);
  while (!exploration.motion->done()) {
    robot.sleep(5.0);
    const auto& progress = exploration.motion->progress();
    std::printf("%5.0f s: %5.1f m driven\n", threewe::to_seconds(robot.world().now()), progress.distance_driven);
  }
  const threewe::ExploreResult seen = robot.wait(exploration);
  std::printf("%s: %.0f m^2 seen in %.0f s\n", to_string(seen.reason).data(), seen.explored_area, seen.duration);

  const threewe::MoveResult back = robot.wait(robot.move_to(0.0, 0.0));
  std::printf("back at the start: %s, %.2f m off\n", back.success ? "yes" : "no", back.distance_to_goal);
  return back.success ? 0 : 1;
}
