// Robots and scenes with random mistakes: what is not refused can be simulated.
#include <doctest/doctest.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "hardware/sample_checks.hpp"
#include "mistakes.hpp"
#include "threewe/backend/registry.hpp"
#include "threewe/core/assets.hpp"

namespace threewe::backend {
namespace {

constexpr std::uint64_t kCases = 100;  // of each file

const std::string kHall = R"(name: hall
description: one of everything
starts: [[1, 2, 0]]
rooms:
  - {name: west, min: [0, 0], max: [3, 4], floor: tile, anchor: [1, 2]}
  - {name: east, min: [3, 0], max: [6, 4], floor: wood}
walls:
  - {a: [0, 0], b: [6, 0], thickness: 0.15}
  - {a: [6, 0], b: [6, 4], height: 2.2}
  - {a: [6, 4], b: [0, 4]}
  - {a: [0, 4], b: [0, 0]}
  - {a: [3, 0], b: [3, 4], doors: [{name: between, at: 2, width: 1}]}
patches:
  - {name: puddle, min: [0.5, 1], max: [2, 3], floor: tile, friction: 0.5}
people:
  - {name: ada, route: [[1, 1], [2, 1]], speed: 1.2}
objects:
  - {category: table, shape: square, pose: [5, 3.2]}
  - {category: chair, shape: wooden, pose: [5, 1, 1.5708], name: favourite}
)";

std::filesystem::path folder() {
  const auto folder = std::filesystem::temp_directory_path() / "threewe_mock_mistakes_test";
  std::filesystem::create_directories(folder);
  return folder;
}

std::string file_with(const std::string& name, const std::string& text) {
  std::ofstream(folder() / name) << text;
  return (folder() / name).string();
}

// Drives for 0.3 s; every sample is as the contract wants it.
void drive(const std::string& scene, const std::string& robot) {
  WorldOptions options;
  options.scene = scene;
  options.robots = {robot};
  const auto world = make_world("mock", options);
  RobotPort& port = world->robot(0);
  port.connect();
  port.command({0.3, 0.0, 0.5}, 1s);
  for (Time t = 20ms; t <= 300ms; t += 20ms) {
    world->advance_to(t);
    for (const Sample& sample : port.poll()) check_sample(port.features().sensors, sample, port.profile());
  }
}

TEST_CASE("robots with mistakes drive or are refused") {
  const std::string scene = file_with("hall.yaml", kHall);
  const std::string file = (folder() / "robot.yaml").string();
  for (const std::string name : {"3we_depth_v2", "turtlebot_like"}) {
    CAPTURE(name);
    std::ostringstream text;
    text << std::ifstream(find_asset("robots", name)).rdbuf();
    for (std::uint64_t seed = 0; seed < kCases; ++seed) {
      testing::read_with_mistakes(text.str(), seed, {file + ":", "robot: ", "start pose 0: "},
                                  [&](const std::string& spoilt) { drive(scene, file_with("robot.yaml", spoilt)); });
    }
  }
}

TEST_CASE("scenes with mistakes can be driven in or are refused") {
  const std::string file = (folder() / "hall.yaml").string();
  for (std::uint64_t seed = 0; seed < kCases; ++seed) {
    testing::read_with_mistakes(kHall, seed, {file + ":"}, [&](const std::string& spoilt) {
      drive(file_with("hall.yaml", spoilt), "turtlebot_like");
    });
  }
  std::filesystem::remove_all(folder());
}

}  // namespace
}  // namespace threewe::backend
