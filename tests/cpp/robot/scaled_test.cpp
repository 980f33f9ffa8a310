// Robots half, and three times, as large and fast as the reference robot, in buildings scaled alike.
#include <doctest/doctest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include <fmt/format.h>

#include "scaled.hpp"
#include "threewe/backend/registry.hpp"
#include "threewe/robot/robot.hpp"
#include "threewe/scene/scene.hpp"

using namespace threewe;

namespace {

// Two rooms of 3 x 4 m, in the first a pillar, between them a doorway, in the second a screen; everything `by` times as
// large. The doorway is where walls end, so that it may be as narrow as it likes.
std::filesystem::path two_rooms(double by, double door) {
  const auto file =
      std::filesystem::temp_directory_path() / fmt::format("two_rooms_{:.0f}_{:.0f}.yaml", 100.0 * by, 100.0 * door);
  std::ofstream yaml(file);
  yaml << "name: " << file.stem().string() << "\ndescription: two rooms\n"
       << fmt::format("starts: [[{}, {}, 0]]\nwalls:\n", 0.8 * by, 0.8 * by);
  const auto wall = [&](Vec2 a, Vec2 b, double thickness) {
    yaml << fmt::format("  - {{a: [{}, {}], b: [{}, {}], thickness: {}, height: {}}}\n", by * a.x, by * a.y, by * b.x,
                        by * b.y, by * thickness, by * 2.6);
  };
  wall({0.0, 0.0}, {6.0, 0.0}, 0.1);
  wall({6.0, 0.0}, {6.0, 4.0}, 0.1);
  wall({6.0, 4.0}, {0.0, 4.0}, 0.1);
  wall({0.0, 4.0}, {0.0, 0.0}, 0.1);
  wall({3.0, 0.0}, {3.0, 2.0}, 0.1);
  wall({3.0, 2.0 + door}, {3.0, 4.0}, 0.1);
  wall({1.6, 1.3}, {2.0, 1.3}, 0.3);
  wall({4.4, 1.4}, {4.4, 4.0}, 0.1);
  return file;
}

struct Drive {
  MoveResult result;
  double off = 0.0;              // [m] in truth
  double collision_speed = 0.0;  // [m/s]
};

Drive drive_through(const std::string& hardware, double by, double door, std::uint64_t seed) {
  backend::WorldOptions options;
  options.scene = two_rooms(by, door).string();
  options.profiles = {testing::scaled(load_profile(hardware), by)};
  options.robots = {hardware};
  options.seed = seed;
  World world(backend::make_world("mock", options));
  Robot robot(world);
  const Vec2 goal{by * 4.4, by * 2.2};  // at (5.2, 3.0) in the building, behind the screen
  Drive drive;
  drive.result = robot.wait(robot.move_to(goal.x, goal.y, {.tolerance = 0.25 * by, .timeout = 180.0}));
  drive.off = distance(robot.simulation()->true_pose().position(), goal);
  drive.collision_speed = robot.simulation()->max_collision_speed();
  return drive;
}

}  // namespace

// The narrowest leaves 2.5 cm on either side of the reference robot, half of what it keeps free elsewhere: it creeps.
TEST_CASE("robots of any size drive through doorways of their size, wide and narrow") {
  for (const double by : {1.0, 0.5, 3.0}) {
    for (const double door : {0.5, 0.34, 0.27}) {
      CAPTURE(by);
      CAPTURE(door);
      const Drive drive = drive_through("3we_standard_v2", by, door, 1);
      CHECK(drive.result.success);
      CHECK(drive.off < 0.25 * by);
      CHECK(drive.collision_speed < 0.05 * by);
      CHECK(drive.result.duration < (door < 0.5 ? 120.0 : 20.0));
    }
  }
}

TEST_CASE("a differential robot half as large drives through doorways of its size") {
  for (const double by : {1.0, 0.5}) {
    for (const double door : {0.5, 0.34}) {
      CAPTURE(by);
      CAPTURE(door);
      const Drive drive = drive_through("turtlebot_like", by, door, 1);
      CHECK(drive.result.success);
      CHECK(drive.off < 0.25 * by);
      CHECK(drive.collision_speed < 0.05 * by);
    }
  }
}
