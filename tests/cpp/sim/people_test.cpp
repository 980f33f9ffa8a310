#include "sim/people.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "sim/step.hpp"
#include "threewe/core/errors.hpp"

using namespace threewe;
using namespace threewe::sim;

namespace {

// A hall of 20 x 20 m, and somebody who walks round a rectangle of 4 x 2 m in it.
std::shared_ptr<const Model> hall(const std::vector<std::string>& robots = {"3we_standard_v2"},
                                  NoiseLevel noise = NoiseLevel::ideal) {
  scene::Scene scene;
  scene.name = "hall";
  scene.min = {-10.0, -10.0};
  scene.max = {10.0, 10.0};
  const Vec2 corners[] = {{-10.0, -10.0}, {10.0, -10.0}, {10.0, 10.0}, {-10.0, 10.0}};
  for (std::size_t i = 0; i < 4; ++i) scene.walls.push_back({corners[i], corners[(i + 1) % 4], 0.1, 2.5});
  scene.people.push_back({"walker", {{1.0, 0.0}, {5.0, 0.0}, {5.0, 2.0}, {1.0, 2.0}}, 1.0, 0.25});
  std::vector<RobotProfile> profiles;
  profiles.reserve(robots.size());
  for (const std::string& name : robots) profiles.push_back(with_noise(load_profile(name), noise));
  return make_model(std::make_shared<const scene::Scene>(scene), profiles);
}

// A world of one robot and the walker.
struct Walk {
  std::shared_ptr<const Model> model;
  std::vector<RobotState> robots;
  std::vector<PersonState> people;

  Walk(const Pose2D& robot, double along, NoiseLevel noise = NoiseLevel::ideal)
      : model(hall({"3we_standard_v2"}, noise)) {
    robots.push_back(begin(*model, 0, robot, 1));
    people.push_back({along});
  }
  void run(const Velocity& command, Duration duration) {
    for (Duration t{}; t < duration; t += kStep) step(*model, robots, {&command, 1}, people);
  }
  scene::Circle person() const { return place_on(model->scene->people[0], people[0]).circle; }
  // [m] between the robot's outline and the person's legs
  double gap() const {
    double gap = 1e9;
    for (const scene::Circle& leg : legs_of(*model, people)) {
      const Vec2 in_base = inverse(robots[0].pose) * leg.center;
      gap = std::min(gap, model->robots[0].body.footprint.signed_distance(in_base) - leg.radius);
    }
    return gap;
  }
};

}  // namespace

TEST_CASE("a person walks the route at their speed, round and round") {
  Walk world({-5.0, 0.0, 0.0}, 0.0);
  world.run({}, 2s);
  CHECK(distance(world.person().center, {3.0, 0.0}) < 1e-9);
  world.run({}, 3s);
  CHECK(distance(world.person().center, {5.0, 1.0}) < 1e-9);
  world.run({}, 8s);
  CHECK(distance(world.person().center, {2.0, 0.0}) < 1e-9);
  for (int i = 0; i < 100; ++i) {
    const scene::Circle before = world.person();
    world.run({}, 120ms);
    CHECK(distance(before.center, world.person().center) < 0.12 + 1e-9);
  }
}

TEST_CASE("the seed says where they begin, and never on a robot") {
  const auto model = hall();
  bool anywhere[12] = {};
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    const std::vector<RobotState> robots{begin(*model, 0, {3.0, 0.0, 0.3}, seed)};
    const auto people = begin_people(*model, robots, seed);
    REQUIRE(people.size() == 1);
    CHECK(people[0].along == begin_people(*model, robots, seed)[0].along);
    anywhere[static_cast<int>(people[0].along)] = true;
    const Vec2 center = place_on(model->scene->people[0], people[0]).circle.center;
    CHECK(model->robots[0].body.footprint.signed_distance(inverse(robots[0].pose) * center) > 0.25);
  }
  for (const bool part : anywhere) CHECK(part);
}

TEST_CASE("a person waits while a robot stands within a metre ahead, and goes on when it has left") {
  Walk world({3.0, 0.0, 0.0}, 0.0);
  world.run({}, 5s);
  CHECK(world.person().center.x == doctest::Approx(2.0).epsilon(0.01));
  CHECK(world.robots[0].max_collision_speed == 0.0);
  world.run({0.0, -0.5, 0.0}, 3s);
  CHECK(world.person().center.x > 3.0);
}

TEST_CASE("a robot that drives into a person is stopped and blamed; the person is not pushed") {
  Walk world({3.0, 1.0, -M_PI / 2}, 1.3);  // from the side, where the person does not look
  const Velocity command{1.0, 0.0, 0.0};
  double hardest = 0.0;
  for (int i = 0; i < 300; ++i) {
    const double along = world.people[0].along;
    world.run(command, kStep);
    CHECK((world.people[0].along == along || std::fabs(world.people[0].along - along - 0.01) < 1e-9));
    CHECK(world.gap() > 0.0);
    hardest = std::max(hardest, world.robots[0].max_collision_speed);
  }
  CHECK(hardest > 0.0);
}

TEST_CASE("thousands of steps among a person and robots: nobody overlaps, and who stands still is not blamed") {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    CAPTURE(seed);
    const RngKey key{.seed = seed, .stream = Stream::sampler};
    Walk world({uniform(key, 0, 0, 0.5, 5.5), 1.0, uniform(key, 0, 1, -3.0, 3.0)}, uniform(key, 0, 2, 0.0, 12.0));
    Velocity command;
    for (std::uint64_t i = 0; i < 600; ++i) {
      if (i % 50 == 0 && seed % 3 != 0) {
        command = {uniform(key, 1 + i, 0, -1.0, 1.0), uniform(key, 1 + i, 1, -1.0, 1.0),
                   uniform(key, 1 + i, 2, -3.0, 3.0)};
      }
      world.run(command, kStep);
      REQUIRE(world.gap() > 0.0);
    }
    if (seed % 3 == 0) CHECK(world.robots[0].max_collision_speed == 0.0);
  }
}

TEST_CASE("legs swing within a person's circle") {
  Walk world({-5.0, 0.0, 0.0}, 0.0);
  double least = 1.0;
  double most = -1.0;
  for (int i = 0; i < 1200; ++i) {
    world.run({}, kStep);
    const auto legs = legs_of(*world.model, world.people);
    REQUIRE(legs.size() == 2);
    for (const scene::Circle& leg : legs) {
      CHECK(distance(leg.center, world.person().center) + leg.radius < world.person().radius);
    }
    const double ahead =
        dot(legs[0].center - legs[1].center, place_on(world.model->scene->people[0], world.people[0]).direction);
    least = std::min(least, ahead);
    most = std::max(most, ahead);
  }
  CHECK(least < -0.16);
  CHECK(most > 0.16);
}

TEST_CASE("lidar and ultrasonics see the legs of a person where they are") {
  Walk world({1.0, -2.0, M_PI / 2}, 0.0);
  world.robots[0].pose.x = world.robots[0].start.x = 1.0 - 0.07;  // the left front sensor looks at x = 0.86
  world.run({}, 60ms);
  const scene::Circle leg = legs_of(*world.model, world.people)[1];  // the right one is nearer
  CHECK(world.robots[0].ultrasonic_range == doctest::Approx(leg.center.y - leg.radius + 2.0 - 0.125).epsilon(0.02));
  world.run({}, 40ms);
  const auto points = scan_points(world.model->robots[0], world.robots[0]);
  float nearest = 12.0F;
  for (const float range : points) nearest = std::min(nearest, range);
  const Vec2 lidar = world.robots[0].pose * world.model->robots[0].profile.lidar->base_from_lidar.position();
  CHECK(static_cast<double>(nearest) ==
        doctest::Approx(distance(legs_of(*world.model, world.people)[1].center, lidar) - leg.radius).epsilon(0.01));
}
