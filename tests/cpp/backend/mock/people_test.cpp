// People in the mock backend: they walk, are seen and heard, wait for robots, and are never pushed.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/rng.hpp"
#include "threewe/backend/registry.hpp"
#include "threewe/scene/scene.hpp"
#include "threewe/scene/truth_view.hpp"

using namespace threewe;
using namespace threewe::backend;
using scene::PersonPose;

namespace {

// A clinic with eight people on their ways.
std::unique_ptr<World> clinic(std::uint64_t seed, std::vector<Pose2D> starts = {},
                              NoiseLevel noise = NoiseLevel::ideal) {
  WorldOptions options;
  options.scene = "dynamic_v1";
  options.robots = {"3we_standard_v2"};
  options.noise = noise;
  options.seed = seed;
  options.poses = std::move(starts);
  auto world = make_world("mock", options);
  world->robot(0).connect();
  return world;
}

const scene::TruthView& truth(World& world) {
  const TruthService* service = world.truth_service();
  if (service == nullptr) throw std::logic_error("no simulated world");  // g++ fears a null
  return service->truth(0);
}
std::vector<PersonPose> people(World& world) { return truth(world).people(); }
void wait(World& world, Duration duration) { world.advance_to(world.now() + duration); }

const scene::Person& visitor() {
  static const scene::Scene scene = scene::Scene::load("dynamic_v1");
  return scene.people[0];
}

// The middle of the visitor's first leg, facing whoever comes along it.
Pose2D in_the_visitors_way() {
  const Vec2 from = visitor().route[0];
  const Vec2 to = visitor().route[1];
  const Vec2 middle = 0.5 * (from + to);
  return {middle.x, middle.y, std::atan2(from.y - to.y, from.x - to.x)};
}

double distance_to_route(const scene::Person& person, Vec2 point) {
  double least = 1e9;
  for (std::size_t i = 0; i < person.route.size(); ++i) {
    const Vec2 a = person.route[i];
    const Vec2 along = person.route[(i + 1) % person.route.size()] - a;
    const double t = std::clamp(dot(point - a, along) / dot(along, along), 0.0, 1.0);
    least = std::min(least, distance(point, a + t * along));
  }
  return least;
}

// [m] between the robot's outline and the middle of the nearest person, whose legs are around it
double gap(World& world) {
  double least = 1e9;
  for (const PersonPose& person : people(world)) {
    const Vec2 in_base = inverse(truth(world).true_pose()) * person.pose.position();
    const Footprint& footprint = world.robot(0).profile().body.footprint;
    least = std::min(least, footprint.signed_distance(in_base));
  }
  return least;
}

}  // namespace

TEST_CASE("people walk their routes at their speeds, each facing the way they walk") {
  const auto world = clinic(1);
  const auto& scene = truth(*world).scene();
  std::map<std::string, double> walked;
  for (int i = 0; i < 200; ++i) {
    const auto before = people(*world);
    wait(*world, 100ms);
    const auto after = people(*world);
    REQUIRE(after.size() == scene.people.size());
    for (std::size_t p = 0; p < after.size(); ++p) {
      CAPTURE(scene.people[p].name);
      CHECK(after[p].name == scene.people[p].name);
      CHECK(after[p].radius == scene.people[p].radius);
      CHECK(distance_to_route(scene.people[p], after[p].pose.position()) < 1e-9);
      const Vec2 step = after[p].pose.position() - before[p].pose.position();
      CHECK(norm(step) <= 0.1 * scene.people[p].speed + 1e-9);
      // straight on, the step is along the heading
      if (before[p].pose.theta == after[p].pose.theta) {
        CHECK(std::fabs(cross(rotate({1.0, 0.0}, after[p].pose.theta), step)) < 1e-9);
      }
      walked[after[p].name] += norm(step);
    }
  }
  for (const auto& [name, metres] : walked) {
    CAPTURE(name);
    CHECK(metres > 5.0);
  }
}

TEST_CASE(
    "somebody waits a metre from a robot that stands in their way, seen by its lidar and its ultrasonic sensors") {
  const auto world = clinic(2, {in_the_visitors_way()});
  wait(*world, 40s);
  const PersonPose waiting = people(*world)[0];
  wait(*world, 5s);
  CHECK(people(*world)[0] == waiting);
  CHECK(truth(*world).true_pose() == in_the_visitors_way());
  CHECK(truth(*world).max_collision_speed() == 0.0);

  const Vec2 in_base = inverse(truth(*world).true_pose()) * waiting.pose.position();
  CHECK(in_base.x == doctest::Approx(1.0).epsilon(0.02));
  float lidar = 0.0F;
  std::map<std::string, double> heard;
  const RobotPort& port = world->robot(0);
  const RobotProfile& profile = port.profile();
  for (const Sample& sample : world->robot(0).poll()) {
    if (const auto* scan = std::get_if<LaserScan>(&sample.data))
      lidar = *std::min_element(scan->ranges.begin() + 165, scan->ranges.begin() + 195);  // ahead
    if (const auto* echo = std::get_if<RangeData>(&sample.data)) {
      heard[port.features().sensors[sample.sensor].name] = echo->range;
    }
  }
  const double from_lidar = in_base.x - profile.lidar->base_from_lidar.x;
  CHECK(static_cast<double>(lidar) > from_lidar - waiting.radius);  // a leg, within the person's circle
  CHECK(static_cast<double>(lidar) < from_lidar + waiting.radius);
  const double from_front = in_base.x - profile.ultrasonics->mounts[0].base_from_ultrasonic.x;
  CHECK(heard.at("ultrasonic_front_left") > from_front - waiting.radius - 1e-6);
  CHECK(heard.at("ultrasonic_front_left") < from_front);
}

TEST_CASE("a robot that drives about among people never pushes one, and touches nobody without being stopped") {
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    CAPTURE(seed);
    const auto world = clinic(seed, {}, NoiseLevel::realistic);
    const auto& scene = truth(*world).scene();
    const RngKey key{.seed = seed, .stream = Stream::sampler};
    for (std::uint64_t i = 0; i < 1500; ++i) {
      const auto before = people(*world);
      world->robot(0).command(
          {uniform(key, i / 50, 0, 0.0, 1.0), uniform(key, i / 50, 1, -0.5, 0.5), uniform(key, i / 50, 2, -1.0, 1.0)},
          world->now() + 200ms);
      wait(*world, 20ms);
      REQUIRE(gap(*world) > 0.0);
      for (std::size_t p = 0; p < before.size(); ++p) {
        const Vec2 position = people(*world)[p].pose.position();
        REQUIRE(distance_to_route(scene.people[p], position) < 1e-9);
        REQUIRE(distance(position, before[p].pose.position()) <= 0.02 * scene.people[p].speed + 1e-9);
      }
    }
  }
}

TEST_CASE("people are saved, restored and reset with the world; another seed has them elsewhere") {
  const auto world = clinic(3);
  const auto begin = people(*world);
  CHECK(people(*clinic(3)) == begin);
  CHECK_FALSE(people(*clinic(4)) == begin);

  wait(*world, 7s);
  const auto saved = world->save();
  wait(*world, 5s);
  const auto later = people(*world);
  world->restore(saved);
  CHECK_FALSE(people(*world) == later);
  wait(*world, 5s);
  CHECK(people(*world) == later);

  world->reset({.seed = 3});
  CHECK(people(*world) == begin);
  world->reset({.seed = 4});
  CHECK(people(*world) == people(*clinic(4)));
}

TEST_CASE("a robot may start where somebody would begin: they begin farther on their route") {
  int moved_on = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    CAPTURE(seed);
    const auto alone = people(*clinic(seed));
    const auto world = clinic(seed, {alone[0].pose});
    CHECK(gap(*world) > 0.0);
    CHECK(truth(*world).true_pose().position() == alone[0].pose.position());
    CHECK(distance_to_route(visitor(), people(*world)[0].pose.position()) < 1e-9);
    const double way = distance(people(*world)[0].pose.position(), alone[0].pose.position());
    CHECK(way > visitor().radius);
    CHECK(way < 1.0);
    moved_on += people(*world)[1] == alone[1] ? 1 : 0;
  }
  CHECK(moved_on == 20);  // nobody else notices
}
