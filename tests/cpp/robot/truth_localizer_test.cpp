// A mind that is told where the robot is: it never drifts, and sees obstacles where they are.
#include "robot/truth_localizer.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "threewe/core/errors.hpp"
#include "threewe/robot/robot.hpp"
#include "threewe/scene/scene.hpp"
#include "threewe/scene/solid.hpp"

namespace threewe {
namespace {

Robot::Options knowing(const std::string& hardware, const Pose2D& map_from_start) {
  return {.hardware = hardware,
          .scene = "apartment_v1",
          .noise = NoiseLevel::ideal,
          .initial_pose = map_from_start,
          .autonomy = autonomy_with("truth")};
}

TEST_CASE("it believes what is true, and obstacles are where something stands") {
  for (const char* hardware : {"3we_standard_v2", "turtlebot_like"}) {
    CAPTURE(hardware);
    const Pose2D map_from_start{1.0, -2.0, 0.7};
    Robot robot(knowing(hardware, map_from_start));
    const Pose2D scene_from_map = robot.simulation()->start_pose() * inverse(map_from_start);
    const double height = robot.runtime().profile().lidar->height;
    const auto solids = robot.simulation()->scene().solids_between(height - 1e-6, height + 1e-6);
    for (int i = 0; i < 40; ++i) {
      robot.execute_action({0.8, 0.0, i < 20 ? 0.9 : -0.6}, 0.1);
      const Pose2D off = inverse(robot.simulation()->true_pose()) * scene_from_map * robot.get_pose();
      CHECK(norm(off.position()) < 1e-9);
      CHECK(std::abs(off.theta) < 1e-9);
      CHECK(robot.get_velocity() == robot.simulation()->true_velocity());

      const Pose2D scene_from_odom = scene_from_map * robot.get_transform("map", "odom");
      REQUIRE(!robot.runtime().obstacles().empty());
      for (const Vec2 p : robot.runtime().obstacles()) {
        CHECK(scene::distance_to(solids, scene_from_odom * p) < 0.01);
      }
    }
    CHECK(std::ranges::count(robot.get_map().data, map::OccupancyGrid::kUnknown) !=
          static_cast<std::ptrdiff_t>(robot.get_map().data.size()));
  }
}

TEST_CASE("a restored robot sees what it saw") {
  Robot robot(knowing("3we_standard_v2", {}));
  robot.execute_action({1.0, 0.0, 0.5}, 1.0);
  const auto snapshot = robot.simulation()->save();
  const auto drive_on = [&] {
    robot.execute_action({1.0, 0.3, -0.5}, 1.0);
    const auto points = robot.runtime().obstacles();
    return std::pair(robot.get_pose(), std::vector<Vec2>(points.begin(), points.end()));
  };
  const auto first = drive_on();
  robot.simulation()->restore(snapshot);
  CHECK(drive_on() == first);
}

TEST_CASE("restored in another world it knows the truth of that one") {
  Robot other(knowing("3we_standard_v2", {}));
  {
    Robot saved(knowing("3we_standard_v2", {}));
    saved.execute_action({1.0, 0.0, 0.5}, 1.0);
    other.simulation()->restore(saved.simulation()->save());
  }
  other.execute_action({1.0, 0.3, -0.5}, 1.0);
  const Pose2D truth = inverse(other.simulation()->start_pose()) * other.simulation()->true_pose();
  CHECK(distance(other.get_pose().position(), truth.position()) < 1e-9);
  CHECK(other.get_velocity() == other.simulation()->true_velocity());
}

TEST_CASE("it is asked for by name") {
  CHECK_THROWS_WITH_AS(autonomy_with("thruth"), "unknown localization 'thruth'; did you mean 'truth'?", ConfigError);
  Autonomy misspelt;
  misspelt.localization = "slm";
  CHECK_THROWS_WITH_AS(Robot({.autonomy = misspelt}), "unknown localization 'slm'; did you mean 'slam'?", ConfigError);
}

}  // namespace
}  // namespace threewe
