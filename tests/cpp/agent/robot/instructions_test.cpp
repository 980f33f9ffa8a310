// Instructions of a robot in C++: the offline form, under the names that it has in Python.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "threewe/core/errors.hpp"
#include "threewe/threewe.hpp"

using namespace threewe;

TEST_CASE("a robot finds a plant, and knows of it afterwards") {
  Robot robot({.scene = "office_v2", .seed = 3});
  CHECK(robot.get_things().empty());
  const ExecutionResult result = robot.execute_instruction("find the plant");
  CHECK(result.success);
  CHECK(result.verified);
  CHECK(result.answer.find("plant") != std::string::npos);
  REQUIRE(result.steps.size() == 1);
  CHECK(result.steps.front().text == "search(kind=plant)");
  REQUIRE(result.steps.front().arguments.size() == 1);
  CHECK(result.steps.front().arguments.front().name == "kind");
  CHECK(std::get<std::string>(result.steps.front().arguments.front().value) == "plant");
  CHECK(result.steps.front().verified);
  CHECK(result.steps.front().picture.image() == robot.get_camera_image());
  CHECK(result.distance == doctest::Approx(robot.simulation()->distance_driven()).epsilon(0.2));

  const std::vector<semantics::MappedThing> things = robot.get_things();
  const auto found = std::ranges::find(things, result.steps.front().thing, &semantics::MappedThing::id);
  REQUIRE(found != things.end());
  CHECK(robot.get_thing_labels().at(found->kind()) == "plant");
  CHECK(distance(found->position, robot.get_pose().position()) < 1.7);
}

TEST_CASE("places are those that were named") {
  Robot robot;
  robot.name_place("dock");
  robot.name_place("square", {{1.5, -0.5}, {2.5, -0.5}, {2.5, 0.5}, {1.5, 0.5}});
  REQUIRE(robot.get_places().size() == 2);
  CHECK(robot.get_places().back().name == "square");
  CHECK(robot.execute_instruction("go to the square").success);
  CHECK(distance(robot.get_pose().position(), {2.0, 0.0}) < 0.5);
  CHECK(robot.execute_instruction("go to the garage").reason == "not_understood");
  CHECK(robot.execute_instruction("drive through the wall").reason == "refused");
  CHECK(robot.execute_instruction("go to the dock", {.timeout = 0.5}).reason == "budget");
  CHECK(robot.execute_instruction("turn left, turn left, turn left", {.max_steps = 2}).reason == "budget");
}

TEST_CASE("places are kept in a file") {
  const auto file = std::filesystem::temp_directory_path() / "instructions_test_places.yaml";
  Robot robot;
  robot.name_place("dock");
  robot.save_places(file);
  Robot other;
  other.name_place("home");
  REQUIRE(other.load_places(file).size() == 1);
  REQUIRE(other.get_places().size() == 2);
  CHECK(other.get_places().back().name == "dock");
  std::filesystem::remove(file);
  CHECK_THROWS_AS(other.load_places(file), ConfigError);
  CHECK_THROWS_AS(other.save_places("places.txt"), ConfigError);
}

TEST_CASE("bad input is one error") {
  Robot robot;
  CHECK_THROWS_WITH_AS(robot.execute_instruction("explore", {.max_steps = 0}), "max_steps must be >= 1, got 0",
                       ContractError);
  CHECK_THROWS_WITH_AS(robot.execute_instruction("explore", {.timeout = std::nan("")}),
                       "timeout must be >= 0 s, got nan", ContractError);
  CHECK_THROWS_WITH_AS(robot.name_place("square", {{0, 0}, {1, 0}}), "polygon must have three points or more, got 2",
                       ContractError);
  CHECK_THROWS_AS(robot.name_place("start"), ContractError);
  robot.emergency_stop();
  CHECK_THROWS_AS(robot.execute_instruction("explore"), EmergencyStopError);
}

TEST_CASE("without a camera, what needs one is an error, and the rest works") {
  Robot blind({.hardware = "turtlebot_like"});
  CHECK_THROWS_WITH_AS(blind.execute_instruction("turn left, then find the plant"),
                       "robot 'turtlebot_like' has no camera, which search needs", HardwareError);
  blind.name_place("dock");
  CHECK(blind.get_places().size() == 1);
  CHECK(blind.get_things().empty());
  const ExecutionResult result = blind.execute_instruction("turn left 30 degrees");
  CHECK(result.success);
  CHECK(result.steps.front().picture.image().color.empty());
}
