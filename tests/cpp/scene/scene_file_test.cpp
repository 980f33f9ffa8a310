// Every mistake in a scene's file is one error that names the line, what is wrong and what would be right.
#include <doctest/doctest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "core/exact.hpp"
#include "threewe/core/assets.hpp"
#include "threewe/core/errors.hpp"
#include "threewe/scene/scene.hpp"

namespace threewe::scene {
namespace {

// A hall of 6 x 4 m with a wall across it.
const std::string kHall = R"(name: hall
description: two rooms
starts:
  - [1, 2, 0]
rooms:
  - {name: west, min: [0, 0], max: [3, 4], floor: tile, anchor: [1, 2]}
  - {name: east, min: [3, 0], max: [6, 4], floor: wood}
walls:
  - {a: [0, 0], b: [6, 0], thickness: 0.15}
  - {a: [6, 0], b: [6, 4]}
  - {a: [6, 4], b: [0, 4]}
  - {a: [0, 4], b: [0, 0]}
  - {a: [3, 0], b: [3, 4], doors: [{name: between, at: 2, width: 1}]}
objects:
  - {category: table, shape: square, pose: [5, 3.2]}
  - {category: chair, shape: wooden, pose: [5, 1, 1.5708], name: favourite}
)";

// The hall with `from` replaced by `to`.
std::string changed(const std::string& from, const std::string& to) {
  std::string text = kHall;
  const auto at = text.find(from);
  REQUIRE_MESSAGE(at != std::string::npos, from);
  return text.replace(at, from.size(), to);
}

void check_fails(const std::string& from, const std::string& to, const std::string& message) {
  CAPTURE(to.substr(0, 200));
  try {
    Scene::parse(changed(from, to), "hall.yaml");
    FAIL_CHECK("nothing was thrown");
  } catch (const ConfigError& error) {
    const std::string what = error.what();
    CHECK_MESSAGE(what.find(message) != std::string::npos, what, " does not contain ", message);
  }
}

TEST_CASE("a scene is read into the frame of its first start") {
  const Scene hall = Scene::parse(kHall, "hall.yaml");
  CHECK(hall.name == "hall");
  CHECK(hall.starts.front() == Pose2D{0.0, 0.0, 0.0});
  CHECK(hall.rooms[0].min == Vec2{-1.0, -2.0});
  CHECK(hall.rooms[1].anchor == Vec2{3.5, 0.0});
  CHECK(hall.min.x == doctest::Approx(-1.06));
  CHECK(hall.max.y == doctest::Approx(2.06));
  CHECK(hall.min.y == doctest::Approx(-2.075));
  CHECK(hall.walls.size() == 6);
  CHECK(hall.doors.front().center == Vec2{2.0, 0.0});
  CHECK(hall.objects[0].name == "table_1");
  CHECK(hall.objects[1].name == "favourite");
  CHECK(hall.objects[1].pose == Pose2D{4.0, -1.0, 0.5 * exact::kPi});
}

TEST_CASE("a start that heads north turns the scene without a rounding") {
  const Scene hall = Scene::parse(changed("[1, 2, 0]", "[1, 2, 1.5708]"), "hall.yaml");
  CHECK(hall.starts.front() == Pose2D{0.0, 0.0, 0.0});
  CHECK(hall.rooms[0].min == Vec2{-2.0, -2.0});
  CHECK(hall.rooms[0].max == Vec2{2.0, 1.0});
  CHECK(hall.doors.front().center == Vec2{0.0, -2.0});
  CHECK(hall.objects[1].pose == Pose2D{-1.0, -4.0, 0.0});
}

TEST_CASE("walls leave their doorways open and fill their corners") {
  const Scene hall = Scene::parse(kHall, "hall.yaml");
  const auto solids = hall.solids_between(0.0, 2.0);
  const auto inside = [&](Vec2 p) {
    for (const Solid& s : solids) {
      if (distance_to(s, p) <= 0.0) return true;
    }
    return false;
  };
  CHECK_FALSE(inside({2.0, 0.0}));
  CHECK_FALSE(inside({2.0, 0.49}));
  CHECK(inside({2.0, 0.51}));
  for (const Vec2 corner : {Vec2{-1.05, -2.07}, {5.05, -2.07}, {5.05, 2.05}, {-1.05, 2.05}}) CHECK(inside(corner));
}

TEST_CASE("bad fields name the line and the nearest right name") {
  check_fails(
      "description:", "descripton:", "hall.yaml:2: missing field 'description'; is 'descripton' meant to be it?");
  check_fails("objects:", "extra: 1\nobjects:", "hall.yaml:14: unknown field 'extra'");
  check_fails("floor: tile", "flor: tile", "hall.yaml:6: rooms[0]: missing field 'floor'; is 'flor' meant to be it?");
  check_fails("floor: tile", "floor: tiles", "did you mean 'tile'");
  check_fails("floor: wood", "floor: wood, ceiling: low", "hall.yaml:7: rooms[1]: unknown field 'ceiling'");
  check_fails("thickness: 0.15", "thicknes: 0.15", "did you mean 'thickness'");
  check_fails("thickness: 0.15", "thickness: thin", "hall.yaml:9: walls[0].thickness: expected a number");
  check_fails("thickness: 0.15", "thickness: .nan", "hall.yaml:9: walls[0].thickness: expected a finite number");
  check_fails("width: 1}", "width: 1, angle: 3}", "hall.yaml:13: walls[4].doors[0]: unknown field 'angle'");
  check_fails("shape: square", "shape: square, color: red", "hall.yaml:15: objects[0]: unknown field 'color'");
  check_fails("category: table", "category: tabel",
              "hall.yaml:15: objects[0].category: unknown category 'tabel'; did you mean 'table'");
  check_fails("shape: square", "shape: sqare",
              "hall.yaml:15: objects[0].shape: unknown shape 'sqare'; did you mean 'square'");
  check_fails("[5, 3.2]", "[5]", "hall.yaml:15: objects[0].pose: expected [x, y, theta]");
  check_fails("rooms:", "rooms: [", "hall.yaml:");
}

TEST_CASE("rooms must be rectangles that do not overlap") {
  check_fails("min: [0, 0], max: [3, 4]", "min: [3, 0], max: [0, 4]",
              "hall.yaml:6: rooms[0]: room 'west' is inside out");
  check_fails("max: [3, 4]", "max: [3, 0.1]", "hall.yaml:6: rooms[0]: room 'west' is inside out");
  check_fails("min: [3, 0]", "min: [2.5, 0]", "hall.yaml:7: rooms[1]: room 'east' overlaps room 'west'");
  check_fails("max: [6, 4]", "max: [7, 4]", "hall.yaml:7: rooms[1]: room 'east' reaches beyond the walls");
  check_fails("name: east", "name: west", "hall.yaml:7: rooms[1]: there are two rooms named 'west'");
  check_fails("anchor: [1, 2]", "anchor: [4, 2]", "hall.yaml:6: rooms[0].anchor: the anchor of 'west' is outside");
}

TEST_CASE("walls must have a length and not lie in each other") {
  check_fails("a: [6, 0], b: [6, 4]", "a: [6, 0], b: [6, 0]", "hall.yaml:10: walls[1]: a wall must be longer");
  check_fails("thickness: 0.15", "thickness: -0.1", "hall.yaml:9: walls[0].thickness: -0.1 is outside");
  check_fails("a: [6, 4], b: [0, 4]", "a: [5, 0.05], b: [0, 0.05]", "hall.yaml:11: walls[2]: wall 2 overlaps wall 0");
  check_fails("a: [6, 4], b: [0, 4]", "a: [1, 0.02], b: [5, 0.05]", "walls[2]: wall 2 overlaps wall 0");  // aslant
  check_fails("walls:", "walls: []\nmore:", "hall.yaml:8: walls: a scene needs at least one wall");
}

TEST_CASE("a scene that is too large is refused before anything is made of it") {
  check_fails("a: [0, 4], b: [0, 0]", "a: [0, 4], b: [0, 1.0e9]",
              "hall.yaml:12: walls[3].b[1]: 1000000000 is outside [-1000, 1000]");
  check_fails("a: [0, 4], b: [0, 0]", "a: [0, 4], b: [-500, 600]",
              "hall.yaml:9: walls: the walls span 506 x 600 m; at most 100000 m2 are read");
  check_fails("[5, 3.2]", "[1.0e30, 1]", "hall.yaml:15: objects[0].pose[0]: 1e+30 is outside [-1000, 1000]");
  check_fails("[5, 3.2]", "[5, 3.2, 90]", "hall.yaml:15: objects[0].pose[2]: 90 is outside [-6.2832, 6.2832]");
  const auto walls = [](int count) {
    std::string text = "walls:\n";
    for (int i = 0; i < count; ++i) text += "  - {a: [0, 0], b: [1, 0]}\n";
    return text;
  };
  check_fails("walls:\n", walls(996), "hall.yaml:9: walls: a list of 1001 items; at most 1000 are read");
  check_fails("walls:\n", walls(1'000'000), "hall.yaml:1: the file is larger than 1048576 bytes");
}

TEST_CASE("doors must fit into their wall") {
  check_fails("width: 1}", "width: 5}",
              "hall.yaml:13: walls[4].doors[0]: door 'between' is wider than its wall (4.00 m)");
  check_fails("at: 2", "at: 3.8", "hall.yaml:13: walls[4].doors[0]: door 'between' reaches beyond its wall");
  check_fails("width: 1}", "width: 0}", "hall.yaml:13: walls[4].doors[0].width: 0 is outside");
  check_fails("width: 1}", "width: 1}, {name: second, at: 2.9, width: 1}", "door 'second' overlaps another door");
  check_fails("width: 1}", "width: 1}, {name: between, at: 0.6, width: 1}", "there are two doors named 'between'");
  check_fails("objects:", "  - {a: [2, 2], b: [6, 2]}\nobjects:",
              "hall.yaml:13: walls[4].doors[0]: door 'between' is blocked by another wall");
  CHECK_NOTHROW(Scene::parse(changed("at: 2, width: 1", "at: 0.55, width: 1.1"), "hall.yaml"));  // in the corner
}

TEST_CASE("objects must stand free") {
  check_fails("[5, 3.2]", "[5, 3.7]", "hall.yaml:15: objects[0]: 'table_1' overlaps a wall");
  check_fails("[5, 3.2]", "[5, 8]", "hall.yaml:15: objects[0]: 'table_1' is outside the walls");
  check_fails("[5, 1, 1.5708]", "[4.6, 2.8, 0]", "hall.yaml:16: objects[1]: 'favourite' overlaps 'table_1'");
  check_fails("name: favourite", "name: table_1", "hall.yaml:16: objects[1]: there are two things named 'table_1'");
  check_fails("name: favourite", "name: floor", "hall.yaml:16: objects[1]: 'floor' cannot be the name");
  check_fails("name: favourite", "name: robot_0", "hall.yaml:16: objects[1]: 'robot_0' cannot be the name");
}

TEST_CASE("a chair may be pushed under a table") {
  CHECK_NOTHROW(Scene::parse(changed("[5, 1, 1.5708]", "[5, 2.7, 1.5708]"), "hall.yaml"));
}

TEST_CASE("robots need room where they start and where they are sent") {
  check_fails("[1, 2, 0]", "[0.2, 2, 0]", "hall.yaml:4: starts[0]: the start is within 0.25 m of a wall");
  check_fails("[1, 2, 0]", "[1, 2, 0]\n  - [5, 1, 0]",
              "hall.yaml:5: starts[1]: the start is within 0.25 m of 'favourite'");
  check_fails("[1, 2, 0]", "[1, 2, 0]\n  - [50, 1, 0]", "hall.yaml:5: starts[1]: the start is outside the walls");
  check_fails("[1, 2, 0]", "[1, 2, 0.5]", "hall.yaml:4: starts[0]: the first start must head along an axis");
  check_fails("starts:\n  - [1, 2, 0]", "starts: []", "hall.yaml:3: starts: a scene needs at least one start");
  check_fails("anchor: [1, 2]", "anchor: [2.9, 1]", "hall.yaml:6: rooms[0]: the anchor of 'west' is within 0.25 m");
}

TEST_CASE("patches of floor have their own grip") {
  const auto patch = [](const std::string& fields) { return "patches: [{name: puddle, " + fields + "}]\nobjects:"; };
  const Scene hall =
      Scene::parse(changed("objects:", patch("min: [0.5, 1], max: [2, 3], floor: tile, friction: 0.6")), "hall.yaml");
  CHECK(hall.patches.front().min == Vec2{-0.5, -1.0});
  CHECK(hall.friction_at({0.0, 0.0}) == 0.6);
  CHECK(hall.friction_at({3.0, 0.0}) == 1.0);
  CHECK(hall.ceiling);
  CHECK_FALSE(Scene::parse(changed("rooms:", "ceiling: false\nrooms:"), "hall.yaml").ceiling);

  check_fails("objects:", patch("min: [0.5, 1], max: [2, 3], floor: tile, friction: 0.0"),
              "hall.yaml:14: patches[0].friction: 0 is outside [0.2, 1.5]");
  check_fails("objects:", patch("min: [0.5, 1], max: [2, 3], floor: tile, friction: 60"), "60 is outside [0.2, 1.5]");
  check_fails("objects:", patch("min: [0.5, 1], max: [2, 3], floor: gras, friction: 1"), "did you mean 'grass'");
  check_fails("objects:", patch("min: [2, 1], max: [0.5, 3], floor: tile, friction: 1"),
              "hall.yaml:14: patches[0]: patch 'puddle' is inside out");
  check_fails("objects:", patch("min: [2, 1], max: [7, 3], floor: tile, friction: 1"),
              "hall.yaml:14: patches[0]: patch 'puddle' reaches beyond the walls");
  check_fails("objects:",
              "patches:\n  - {name: a, min: [0, 0], max: [2, 2], floor: tile, friction: 1}\n"
              "  - {name: b, min: [1, 1], max: [3, 3], floor: tile, friction: 1}\nobjects:",
              "hall.yaml:16: patches[1]: patch 'b' overlaps patch 'a'");
}

TEST_CASE("people walk closed routes that lead through nothing") {
  const auto walk = [](const std::string& route, const std::string& rest = "speed: 1.2") {
    return "people:\n  - {name: ada, route: " + route + ", " + rest + "}\nobjects:";
  };
  const Scene hall = Scene::parse(changed("objects:", walk("[[1, 1], [1, 3], [2, 3]]")), "hall.yaml");
  CHECK(hall.people.front() == Person{"ada", {{0.0, -1.0}, {0.0, 1.0}, {1.0, 1.0}}, 1.2, 0.25});
  CHECK_NOTHROW(Scene::parse(changed("objects:", walk("[[1, 2], [4.2, 2]]")), "hall.yaml"));  // through the door

  check_fails("objects:", walk("[[1, 1], [1, 3], [4, 3]]"),
              "hall.yaml:15: people[0].route[1]: from here 'ada' walks through a wall");
  check_fails("objects:", walk("[[1, 2], [4, 2], [4, 0.5]]"),
              "hall.yaml:15: people[0].route[2]: from here 'ada' walks through a wall");  // on the way back
  check_fails("objects:", walk("[[1, 2], [1, -2]]"), "people[0].route[0]: from here 'ada' walks through a wall");
  check_fails("objects:", walk("[[7, 2], [8, 2]]"), "people[0].route[0]: here 'ada' walks outside the walls");
  check_fails("objects:", walk("[[1, 2], [1.0e30, 2]]"), "people[0].route[1][0]: 1e+30 is outside");
  check_fails("objects:", walk("[[1, 2], [5, 2], [5, 0.9]]"), "walks through 'favourite'");
  check_fails("objects:",
              "people:\n  - {name: ada, route: [[1, 1], [1, 3]], speed: 1}\n"
              "  - {name: bob, route: [[0.6, 2], [2, 2]], speed: 1}\nobjects:",
              "hall.yaml:16: people[1]: the way of 'bob' crosses that of 'ada'");
  check_fails("objects:", walk("[[1, 2]]"), "hall.yaml:15: people[0].route: expected two or more waypoints");
  check_fails("objects:", walk("[[1, 2], [1, 2]]"), "people[0].route[1]: waypoints must be at least 0.1 m apart");
  std::string long_route = "[1, 2]";
  for (int i = 0; i < 50; ++i) long_route += ", [2, 2], [1, 2]";
  check_fails("objects:", walk("[" + long_route + "]"), "people[0].route: a list of 101 items; at most 100 are read");
  check_fails("objects:", walk("[[1, 2], [2, 2], [1, 2]]"), "the way from the last back to the first is implied");
  check_fails("objects:", walk("[[1, 2], [2, 2]]", "speed: 20"), "people[0].speed: 20 is outside [0.1, 2.5]");
  check_fails("objects:", walk("[[1, 2], [2, 2]]", "sped: 1"), "is 'sped' meant to be it?");
}

TEST_CASE("a file must be named as its scene is") {
  const auto folder = std::filesystem::temp_directory_path() / "threewe_scene_file_test";
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "hall.yaml") << kHall;
  std::ofstream(folder / "palace.yaml") << kHall;
  CHECK(Scene::load((folder / "hall.yaml").string()).name == "hall");
  CHECK_THROWS_WITH_AS(Scene::load((folder / "palace.yaml").string()),
                       doctest::Contains("palace.yaml:1: name: expected 'palace'"), ConfigError);
  std::filesystem::remove_all(folder);
}

TEST_CASE("an unknown scene names the nearest known one") {
  CHECK_THROWS_WITH_AS(Scene::load("ofice_v2"), doctest::Contains("did you mean 'office_v2'"), ConfigError);
  CHECK_THROWS_WITH_AS(Scene::load("nowhere/hall.yaml"), doctest::Contains("does not exist"), ConfigError);
  CHECK_THROWS_WITH_AS(Scene::load(std::string(10'000, 'x') + ".yaml"), doctest::Contains("not exist"), ConfigError);
  CHECK_THROWS_WITH_AS(Scene::load(std::string(10'000, 'x')), doctest::Contains("unknown scene"), ConfigError);
}

TEST_CASE("mistakes in an object's file are reported there") {
  const auto folder = std::filesystem::temp_directory_path() / "threewe_object_file_test";
  std::filesystem::create_directories(folder / "objects");
  add_asset_directory(folder);
  const auto fails = [&](const std::string& part, const std::string& message) {
    CAPTURE(part);
    std::ofstream(folder / "objects/lamp.yaml") << "category: lamp\nshapes:\n  tall:\n    - " << part << "\n";
    CHECK_THROWS_WITH_AS(
        Scene::parse(changed("category: table, shape: square", "category: lamp, shape: tall"), "hall.yaml"),
        doctest::Contains(message.c_str()), ConfigError);
  };
  fails("{box: [0.1], z: [0, 1], material: wood}", "lamp.yaml:4: shapes.tall[0].box: expected [length, width]");
  fails("{box: [0.1, 0], z: [0, 1], material: wood}", "lamp.yaml:4: shapes.tall[0].box[1]: 0 is outside");
  fails("{cylinder: -1, z: [0, 1], material: wood}", "lamp.yaml:4: shapes.tall[0].cylinder: -1 is outside");
  fails("{z: [0, 1], material: wood}", "lamp.yaml:4: shapes.tall[0]: expected either 'box' or 'cylinder'");
  fails("{cylinder: 0.1, z: [1, 0], material: wood}", "lamp.yaml:4: shapes.tall[0].z: expected 0 <= from < to");
  fails("{cylinder: 0.1, z: [0, 1], material: wod}", "did you mean 'wood'");
  fails("{cylinder: 0.1, z: [0, 1], material: wood}\n  tall: []",
        "lamp.yaml:5: shapes: field 'tall' stands twice, first in line 3");
  fails("{cylinder: 0.1, at: [20, 0], z: [0, 1], material: wood}", "lamp.yaml:4: shapes.tall[0].at[0]: 20 is outside");
  fails("{cylinder: 0.1, z: [0, 1], material: wood, glow: 1}", "lamp.yaml:4: shapes.tall[0]: unknown field 'glow'");
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace threewe::scene
