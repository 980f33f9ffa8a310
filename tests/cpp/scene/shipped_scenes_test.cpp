// The scenes that come with the library are places where a robot can work.
#include <doctest/doctest.h>

#include <algorithm>
#include <map>
#include <memory>
#include <set>

#include "core/config.hpp"
#include "scene/episodes.hpp"
#include "scene/scene_tables.hpp"
#include "threewe/core/assets.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::scene {
namespace {

const std::vector<std::string> kShipped = {"office_v2",    "corridor_v1", "apartment_v1", "warehouse_v1",
                                           "cluttered_v1", "outdoor_v1",  "dynamic_v1"};
const std::vector<Footprint> kRobots = {Footprint::rectangle(0.25, 0.22), Footprint::rectangle(0.28, 0.31),
                                        Footprint({{0.041, -0.09}, {0.041, 0.09}, {-0.11, 0.09}, {-0.11, -0.09}})};

TEST_CASE("scene_names lists what can be loaded") {
  const auto names = scene_names();
  for (const std::string& name : kShipped) CHECK(std::ranges::find(names, name) != names.end());
  for (const std::string& name : names) CHECK(Scene::load(name).name == name);
}

TEST_CASE("every room, every start and (2, 1) can be reached") {
  for (const std::string& name : scene_names()) {
    for (const Footprint& robot : kRobots) {
      CAPTURE(name);
      const SceneTables tables(std::make_shared<const Scene>(Scene::load(name)), robot, 0.2);
      const Scene& scene = tables.scene();
      CHECK_FALSE(tables.collides({2.0, 1.0, 0.0}));
      CHECK(tables.clearance({2.0, 1.0, 0.0}) > 0.1);
      CHECK(tables.geodesic({0.0, 0.0}, {2.0, 1.0}) < 3.0);
      const GeodesicField from_start = tables.geodesic_field({0.0, 0.0});
      for (const Pose2D& start : scene.starts) {
        CHECK_FALSE(tables.collides(start));
        CHECK(from_start.length_from(start.position()) < 50.0);
      }
      for (const Room& room : scene.rooms) {
        CAPTURE(room.name);
        CHECK(scene.room_at(room.anchor) == &room);
        CHECK(from_start.length_from(room.anchor) < 50.0);
      }
    }
  }
}

TEST_CASE("a robot passes gaps as wide as it is, wherever its base is in it") {
  const auto scene = std::make_shared<const Scene>(Scene::load("office_v2"));
  CHECK(SceneTables(scene, kRobots[0], 0.2).passing_radius() == doctest::Approx(0.11));
  CHECK(SceneTables(scene, kRobots[2], 0.2).passing_radius() == doctest::Approx(0.0755));
}

TEST_CASE("a robot with 25 cm around it still gets into every room") {
  for (const std::string& name : scene_names()) {
    CAPTURE(name);
    const Scene scene = Scene::load(name);
    const Obstacles obstacles(scene.solids_between(0.0, 0.2));
    const CellSet wide = cells_with_clearance(
        obstacles, distance_field(occupied_cells(grid_over(scene), obstacles.solids())), 0.25 + 0.11);
    const CellSet reached = connected_cells(wide, {0.0, 0.0});
    for (const Room& room : scene.rooms) {
      CAPTURE(room.name);
      std::size_t cells = 0;
      for (std::size_t i = 0; i < reached.cells.size(); ++i) {
        cells += reached.cells[i] && scene.room_at(reached.frame.center(reached.frame.cell(i))) == &room ? 1U : 0U;
      }
      CHECK(static_cast<double>(cells) * kCellSize * kCellSize > 0.5);
    }
  }
}

TEST_CASE("the lidar sees whatever a low robot could touch") {
  for (const std::string& name : scene_names()) {
    const Scene scene = Scene::load(name);
    for (const Solid& solid : scene.solids_between(0.0, 0.2)) {
      CAPTURE(name);
      CAPTURE(solid.object);
      const bool seen = solid.z_min <= 0.13 && solid.z_max > 0.19;
      // what the lidar's plane misses lies above or below something that it meets
      const auto covers = [&](const Solid& other) {
        return other.object == solid.object && other.z_min <= 0.13 && other.z_max > 0.19 &&
               distance_to(other, solid.center) <= 0.0;
      };
      CHECK((seen || std::ranges::any_of(scene.solids(), covers)));
    }
  }
}

TEST_CASE("rooms and doors are named once, and rooms can be asked for by name") {
  for (const std::string& name : scene_names()) {
    const Scene scene = Scene::load(name);
    CHECK(scene.room(scene.rooms.front().name).name == scene.rooms.front().name);
    CHECK(scene.room_at({1000.0, 0.0}) == nullptr);
  }
  CHECK_THROWS_WITH_AS(Scene::load("office_v2").room("kitchn"), doctest::Contains("did you mean 'kitchen'"),
                       ConfigError);
}

TEST_CASE("categories that robots must recognise come in at least four shapes") {
  for (const char* category :
       {"chair", "desk", "table", "shelf", "plant", "couch", "monitor", "refrigerator", "bed", "door", "cup", "box"}) {
    CAPTURE(category);
    ConfigNode root = ConfigNode::load(find_asset("objects", category));
    CHECK(root.at("shapes").fields().size() >= 4);
  }
}

TEST_CASE("every category that robots look for stands in several scenes, several times") {
  std::map<std::string, std::set<std::string>> scenes;
  std::map<std::string, int> count;
  for (const std::string& name : kShipped) {
    for (const Object& object : Scene::load(name).objects) {
      scenes[object.category].insert(name);
      ++count[object.category];
    }
  }
  for (const char* category :
       {"chair", "desk", "door", "plant", "monitor", "couch", "table", "shelf", "refrigerator", "bed", "cup", "box"}) {
    CAPTURE(category);
    CHECK(scenes[category].size() >= 3);
    CHECK(count[category] >= 8);
  }
}

TEST_CASE("episodes are 2 to 15 m long, some of them with a detour") {
  for (const std::string& name : kShipped) {
    CAPTURE(name);
    const SceneTables tables(std::make_shared<const Scene>(Scene::load(name)), kRobots.front(), 0.2);
    int detours = 0;
    for (std::uint32_t i = 0; i < 25; ++i) {
      const Episode episode = sample_episode(tables, 7, i);
      CHECK(episode.geodesic >= kShortestEpisode);
      CHECK(episode.geodesic <= kLongestEpisode);
      detours += episode.geodesic > kDetour * distance(episode.start.position(), episode.goal) ? 1 : 0;
    }
    CHECK(detours >= 2);
  }
}

TEST_CASE("only outdoors there is no ceiling and the floor is uneven, only one scene has people") {
  for (const std::string& name : kShipped) {
    CAPTURE(name);
    const Scene scene = Scene::load(name);
    CHECK(scene.ceiling == (name != "outdoor_v1"));
    CHECK(scene.patches.empty() == (name != "outdoor_v1"));
    CHECK(scene.people.empty() == (name != "dynamic_v1"));
  }
}

TEST_CASE("every shape of every category can be read") {
  std::string text =
      "name: depot\ndescription: everything\nstarts: [[-20, -20]]\nwalls: [{a: [-30, -30], b: [500, -30]}, "
      "{a: [500, -30], b: [500, 30]}]\nobjects:\n";
  int x = 0;
  for (const std::string& category : asset_names("objects")) {
    ConfigNode root = ConfigNode::load(find_asset("objects", category));
    for (const auto& [shape, parts] : root.at("shapes").fields()) {
      text += "  - {category: " + category + ", shape: " + shape + ", pose: [" + std::to_string(x += 5) + ", 0]}\n";
    }
  }
  CHECK(Scene::parse(text, "depot.yaml").objects.size() == static_cast<std::size_t>(x) / 5);
}

TEST_CASE("a slice lists closed outlines, counter-clockwise, each once") {
  const Scene scene = Scene::load("office_v2");
  for (const Slice& slice : {scene.at_height(0.18), scene.between(0.0, 2.0)}) {
    CHECK(slice.segments.size() % 4 == 0);
    std::set<std::array<double, 4>> seen;
    for (std::size_t i = 0; i < slice.segments.size(); i += 4) {
      const auto* s = &slice.segments[i];
      for (std::size_t k = 0; k < 4; ++k) {
        CHECK(s[k].b == s[(k + 1) % 4].a);
        CHECK(s[k].object == s[0].object);
        CHECK(cross(s[k].b - s[k].a, s[(k + 1) % 4].b - s[(k + 1) % 4].a) > 0.0);
      }
      CHECK(seen.insert({s[0].a.x, s[0].a.y, s[2].a.x, s[2].a.y}).second);
    }
  }
}

TEST_CASE("a table is legs to a lidar and a board to what is taller") {
  const Scene scene = Scene::parse(
      "name: hall\ndescription: one table\nstarts: [[-2, 0]]\nwalls: [{a: [-4, -4], b: [4, -4]}, {a: [4, -4], b: [4, "
      "4]}]\n"
      "objects: [{category: table, shape: square, pose: [0, 0]}]\n",
      "hall.yaml");
  const auto of_table = [](const Slice& slice) {
    return std::pair(std::ranges::count(slice.segments, 0, &Segment::object),
                     std::ranges::count(slice.circles, 0, &Circle::object));
  };
  CHECK(of_table(scene.at_height(0.18)) == std::pair<std::ptrdiff_t, std::ptrdiff_t>(0, 4));
  CHECK(of_table(scene.at_height(0.73)) == std::pair<std::ptrdiff_t, std::ptrdiff_t>(4, 0));
  CHECK(of_table(scene.at_height(0.75)) == std::pair<std::ptrdiff_t, std::ptrdiff_t>(0, 0));
  CHECK(of_table(scene.between(0.0, 1.0)) == std::pair<std::ptrdiff_t, std::ptrdiff_t>(4, 4));
  CHECK(of_table(scene.between(0.0, 0.72)) == std::pair<std::ptrdiff_t, std::ptrdiff_t>(0, 4));
}

}  // namespace
}  // namespace threewe::scene
