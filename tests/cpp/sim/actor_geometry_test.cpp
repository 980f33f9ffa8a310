#include "sim/actor_geometry.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "core/exact.hpp"
#include "sim/ray_tracer.hpp"
#include "sim/step.hpp"
#include "threewe/core/errors.hpp"

using namespace threewe;
using namespace threewe::sim;

namespace {

// A clinic with people, and two robots in it.
struct Room {
  std::shared_ptr<const Model> model;
  std::vector<RobotState> robots;
  std::vector<PersonState> people;

  explicit Room(std::uint64_t seed = 0) {
    const auto scene = std::make_shared<const scene::Scene>(scene::Scene::load("dynamic_v1"));
    model = make_model(scene, {load_profile("3we_depth_v2"), load_profile("turtlebot_like")});
    robots.reserve(2);
    for (std::size_t i = 0; i < 2; ++i) robots.push_back(begin(*model, i, scene->starts[i], seed));
    people = begin_people(*model, robots, seed);
  }
  std::vector<VisibleSolid> figures(std::size_t looking, std::uint64_t seed = 0, std::uint32_t episode = 0) const {
    std::vector<VisibleSolid> all;
    const std::vector<Pose2D> poses{robots[0].pose, robots[1].pose};
    find_actors(*model, poses, looking, people, seed, episode, all);
    return all;
  }
};

// The corners of a box, or points around a disc.
std::vector<Vec2> outline(const scene::Solid& solid) {
  constexpr std::size_t kAround = 32;
  const bool is_box = solid.shape == scene::Solid::Shape::box;
  std::vector<Vec2> points;
  points.reserve(kAround);
  for (std::size_t i = 0; i < (is_box ? solid.corners.size() : kAround); ++i) {
    const double angle = 2.0 * exact::kPi / kAround * static_cast<double>(i);
    points.push_back(is_box ? solid.corners[i] : solid.center + rotate({solid.radius, 0.0}, angle));
  }
  return points;
}

}  // namespace

TEST_CASE("ids go through objects, people and robots, and each has a name") {
  const Room world;
  const scene::Scene& scene = *world.model->scene;
  const auto names = id_names(*world.model);
  REQUIRE(names.size() == 4 + scene.objects.size() + scene.people.size() + 2);
  const auto name_of = [&](int id) { return names[static_cast<std::size_t>(id)]; };
  CHECK(name_of(kNothingId) == "nothing");
  CHECK(name_of(kFloorId) == "floor");
  CHECK(name_of(kWallId) == "wall");
  CHECK(name_of(kCeilingId) == "ceiling");
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    CHECK(name_of(kFirstObjectId + static_cast<int>(i)) == scene.objects[i].name);
  }
  for (std::size_t i = 0; i < scene.people.size(); ++i) CHECK(name_of(person_id(scene, i)) == scene.people[i].name);
  CHECK(name_of(robot_id(scene, 0)) == "robot_0");
  CHECK(name_of(robot_id(scene, 1)) == "robot_1");
}

TEST_CASE("more objects, people and robots than there are ids are refused") {
  Model model;
  scene::Scene scene;
  scene.objects.resize(32763);
  scene.people.resize(1);
  model.scene = std::make_shared<const scene::Scene>(scene);
  CHECK_NOTHROW(id_names(model));
  scene.people.resize(2);
  model.scene = std::make_shared<const scene::Scene>(scene);
  CHECK_THROWS_AS(id_names(model), ConfigError);
}

TEST_CASE("everybody is a figure of some height, but the robot that looks") {
  const Room world;
  const scene::Scene& scene = *world.model->scene;
  const auto height_of = [&](const std::vector<VisibleSolid>& figures, std::int16_t id) {
    double height = 0.0;
    for (const VisibleSolid& v : figures) height = v.id == id ? std::max(height, v.solid.z_max) : height;
    return height;
  };
  const auto seen = world.figures(0);
  for (std::size_t i = 0; i < scene.people.size(); ++i) CHECK(height_of(seen, person_id(scene, i)) == kPersonHeight);
  CHECK(height_of(seen, robot_id(scene, 0)) == 0.0);
  CHECK(height_of(seen, robot_id(scene, 1)) == world.model->robots[1].profile.body.height);
  const auto from_elsewhere = world.figures(7);
  CHECK(height_of(from_elsewhere, robot_id(scene, 0)) == world.model->robots[0].profile.body.height);
}

TEST_CASE("people keep within their circles, robots within their footprints") {
  constexpr double kLens = 0.002;  // [m] that a robot's camera sticks out
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    CAPTURE(seed);
    Room world(seed);
    const scene::Scene& scene = *world.model->scene;
    for (PersonState& person : world.people) person.along += 0.07 * static_cast<double>(seed);
    const auto circles = circles_of(*world.model, world.people);
    for (const VisibleSolid& v : world.figures(7)) {
      CHECK(v.solid.z_min < v.solid.z_max);
      CHECK(v.solid.z_min >= 0.0);
      for (const Vec2 point : outline(v.solid)) {
        if (v.id < robot_id(scene, 0)) {
          const auto& circle = circles[static_cast<std::size_t>(v.id - person_id(scene, 0))];
          CHECK(distance(point, circle.center) <= circle.radius + 1e-9);
        } else {
          const auto i = static_cast<std::size_t>(v.id - robot_id(scene, 0));
          const Vec2 in_base = inverse(world.robots[i].pose) * point;
          CHECK(world.model->robots[i].body.footprint.signed_distance(in_base) <= kLens);
        }
      }
    }
  }
}

TEST_CASE("at the height of the lidars, a robot is as wide as its footprint") {
  const Room world;
  for (std::size_t i = 0; i < 2; ++i) {
    const double plane = world.model->robots[0].profile.lidar->height;
    const Footprint& footprint = world.model->robots[i].body.footprint;
    const auto fills = [&](const VisibleSolid& v) {
      if (v.id != robot_id(*world.model->scene, i) || v.solid.z_min > plane || v.solid.z_max <= plane) return false;
      return std::ranges::all_of(v.solid.corners, [&](Vec2 corner) {
        return std::fabs(footprint.signed_distance(inverse(world.robots[i].pose) * corner)) < 1e-9;
      });
    };
    CHECK(std::ranges::any_of(world.figures(7), fills));
  }
}

TEST_CASE("at the height of the lidars, people are the legs that the lidar sees") {
  Room world;
  for (std::size_t i = 0; i < world.people.size(); ++i) world.people[i].along += 0.3 * static_cast<double>(i);
  const double plane = world.model->robots[0].profile.lidar->height;
  const std::vector<scene::Circle> legs = legs_of(*world.model, world.people);
  std::size_t next = 0;
  std::vector<bool> seen(legs.size());
  for (const VisibleSolid& v : world.figures(7)) {
    if (v.id >= robot_id(*world.model->scene, 0) || v.solid.z_min > plane || v.solid.z_max <= plane) continue;
    const auto leg = std::ranges::find_if(legs, [&](const scene::Circle& circle) {
      return distance(circle.center, v.solid.center) < 1e-9 && std::fabs(circle.radius - v.solid.radius) < 1e-12;
    });
    REQUIRE(leg != legs.end());
    seen[static_cast<std::size_t>(leg - legs.begin())] = true;
    ++next;
  }
  CHECK(next == legs.size());
  for (const bool leg : seen) CHECK(leg);
}

TEST_CASE("clothes are a pure function of seed, episode and person") {
  const Room world;
  const auto colours = [&](std::uint64_t seed, std::uint32_t episode) {
    std::vector<Colour> all;
    const auto figures = world.figures(0, seed, episode);
    all.reserve(figures.size());
    for (const VisibleSolid& v : figures) all.push_back(v.colour);
    return all;
  };
  CHECK(colours(3, 4) == colours(3, 4));
  CHECK(colours(3, 4) != colours(3, 5));
  CHECK(colours(3, 4) != colours(4, 4));
}

TEST_CASE("the camera sees people and robots as the ray tracer does") {
  int people = 0;
  int robots = 0;
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    const Room world(seed);
    const scene::Scene& scene = *world.model->scene;
    const Renderer renderer(scene);
    const Shading shading{seed, 0};
    const auto figures = world.figures(7, seed);

    // from 1.5 m beside somebody, or from 0.6 m beside a robot
    const bool at_robot = seed % 3 == 0;
    const auto one = static_cast<std::size_t>(seed) % world.people.size();
    const Vec2 target = at_robot ? world.robots[1].pose.position() : circles_of(*world.model, world.people)[one].center;
    const Vec2 eye = target - rotate({at_robot ? 0.6 : 1.5, 0.0}, 0.5 * static_cast<double>(seed));
    const CameraPose view{{eye.x, eye.y, 0.5 * static_cast<double>(seed)}, 0.165};
    const CameraIntrinsics camera = make_intrinsics(64, 48, 1.2);
    constexpr std::size_t kPixels = 3072;
    std::vector<std::int16_t> ids(kPixels);
    std::vector<float> depth(kPixels);
    RenderScratch scratch;
    renderer.render(camera, view, shading, {{}, depth, ids}, scratch, figures);

    const RayTracer tracer(scene, camera, view, shading, figures);
    int wrong = 0;
    for (int row = 0; row < 48; ++row) {
      for (int column = 0; column < 64; ++column) {
        const int at = 64 * row + column;
        const auto i = static_cast<std::size_t>(at);
        const Hit hit = tracer.cast(column + 0.5, row + 0.5);
        const bool same = hit.id == ids[i] && (hit.id == kNothingId ||
                                               std::fabs(static_cast<double>(depth[i]) - hit.depth) < 1e-4 * hit.depth);
        wrong += same ? 0 : 1;
        people += ids[i] >= person_id(scene, 0) && ids[i] < robot_id(scene, 0) ? 1 : 0;
        robots += ids[i] >= robot_id(scene, 0) ? 1 : 0;
      }
    }
    CAPTURE(seed);
    CHECK(wrong == 0);
  }
  CHECK(people > 1000);
  CHECK(robots > 500);
}
