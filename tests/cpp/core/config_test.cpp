// Every way in which a configuration file can be wrong gives one error that says where and what would be right.
#include "core/config.hpp"

#include <doctest/doctest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "threewe/core/errors.hpp"

namespace threewe {
namespace {

ConfigNode parse(const std::string& text) { return ConfigNode::parse(text, "robot.yaml"); }

template <class F>
std::string message(F&& action) {
  try {
    action();
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "no error";
}

TEST_CASE("what is right is read as it stands") {
  ConfigNode root = parse(
      "name: demo\n"
      "mass: 2.5\n"
      "wheels: 4\n"
      "fast: true\n"
      "size: [0.25, 0.22]\n"
      "start: [1, 2, 6]\n"
      "here: [1, 2]\n"
      "drive: mecanum\n"
      "sensors:\n"
      "  - {kind: lidar, range: 12}\n"
      "  - {kind: imu}\n");
  CHECK(root.text("name") == "demo");
  CHECK(root.text("title", "none") == "none");
  CHECK(root.number("mass") == 2.5);
  CHECK(root.number("height", 0.15) == 0.15);
  CHECK(root.number("mass", 1.0) == 2.5);
  CHECK(root.number_in("mass", 0.0, 2.5) == 2.5);
  CHECK(root.integer_in("wheels", 1, 4) == 4);
  CHECK(root.at("fast").boolean());
  CHECK(root.at("size").vec2() == Vec2{0.25, 0.22});
  CHECK(root.at("start").pose() == Pose2D{1.0, 2.0, wrap_angle(6.0)});
  CHECK(root.at("here").pose() == Pose2D{1.0, 2.0, 0.0});
  CHECK(root.choice("drive", {"differential", "mecanum"}) == "mecanum");

  auto sensors = root.at("sensors").items();
  REQUIRE(sensors.size() == 2);
  CHECK(sensors[0].text("kind") == "lidar");
  CHECK(sensors[0].number("range") == 12.0);
  CHECK_FALSE(sensors[1].has("range"));
  sensors[0].finish();
  root.finish();
}

TEST_CASE("the fields of a mapping come in order") {
  const ConfigNode root = parse("zebra: 1\napple: 2\nmango: 3\n");
  const auto fields = root.fields();
  REQUIRE(fields.size() == 3);
  CHECK(fields[0].first == "zebra");
  CHECK(fields[1].first == "apple");
  CHECK(fields[2].first == "mango");
  CHECK(fields[2].second.number() == 3.0);
}

TEST_CASE("a file that is missing or malformed") {
  CHECK(message([] { ConfigNode::load("/does/not/exist.yaml"); }) == "/does/not/exist.yaml: cannot be read");
  CHECK(message([] { ConfigNode::load(std::filesystem::temp_directory_path()); }) ==
        std::filesystem::temp_directory_path().string() + ": cannot be read");
  CHECK(message([] { parse("a: 1\nb: [1, 2\nc: 3\n"); }).starts_with("robot.yaml:3: malformed YAML: "));
  CHECK(message([] { parse("a: 1\n\tb: 2\n"); }).starts_with("robot.yaml:2: malformed YAML: "));
  CHECK(message([] { parse("a: *nowhere\n"); }).starts_with("robot.yaml:1: malformed YAML: "));
}

TEST_CASE("a loaded file is named in errors") {
  const auto file = std::filesystem::temp_directory_path() / "threewe_config_test.yaml";
  std::ofstream(file) << "name: demo\nmass: heavy\n";
  ConfigNode root = ConfigNode::load(file);
  CHECK(root.text("name") == "demo");
  CHECK(message([&] { root.number("mass"); }) == file.string() + ":2: mass: expected a number");
  std::filesystem::remove(file);
}

TEST_CASE("a file that no robot and no place needs") {
  const std::string line = "- 1\n";
  std::string list;
  for (std::size_t i = 0; i < kMostItems; ++i) list += line;
  CHECK(parse(list).items().size() == kMostItems);
  CHECK(message([&] { parse(list + line).items(); }) == "robot.yaml:1: a list of 1001 items; at most 1000 are read");
  std::string mapping;
  for (std::size_t i = 0; i <= kMostItems; ++i) mapping += std::to_string(i) + ": 1\n";
  CHECK(message([&] { parse(mapping).fields(); }) == "robot.yaml:1: 1001 fields; at most 1000 are read");

  // aliases that stand for 9^9 numbers cost nothing until they are read
  std::string bomb = "a: &a [1, 1, 1, 1, 1, 1, 1, 1, 1]\n";
  for (char name = 'b'; name < 'i'; ++name) {
    const std::string last = std::string("*") + static_cast<char>(name - 1);
    bomb += std::string(1, name) + ": &" + name + " [" + last;
    for (int i = 1; i < 9; ++i) bomb += ", " + last;
    bomb += "]\n";
  }
  CHECK(message([&] { parse(bomb).at("h").vec2(); }) == "robot.yaml:8: h: expected [x, y]");
  CHECK(message([] { parse("a: " + std::string(100'000, '[')); }).starts_with("robot.yaml:1: malformed YAML: "));

  const auto file = std::filesystem::temp_directory_path() / "threewe_config_test.yaml";
  std::ofstream(file) << "name: demo\n";
  std::filesystem::resize_file(file, 100 << 20);  // with a hole, that takes no room
  CHECK(message([&] { ConfigNode::load(file); }) == file.string() + ":1: the file is larger than 1048576 bytes");
  std::filesystem::remove(file);
}

TEST_CASE("a file that is no text") {
  std::string bytes;
  for (int i = 1; i < 256; ++i) bytes += static_cast<char>(i);
  CHECK(message([&] { parse(bytes).at("name"); }) == "robot.yaml:2: expected UTF-8 text; save the file as that");
  CHECK(message([] { parse(std::string("a: 1\n\0", 6)).at("a"); }) ==
        "robot.yaml:2: expected UTF-8 text; save the file as that");
  CHECK(message([] { parse("%YAML 9999999999.1\n---\na: 1\n"); }).starts_with("robot.yaml:1: malformed YAML: "));
}

TEST_CASE("what belongs to nothing is told, and does not keep the reader for ever") {
  CHECK(message([] { parse("# a comment\n, and more\na: 1\n"); }) ==
        "robot.yaml:2: malformed YAML: nothing can begin like this");
  for (const char* text : {"a: 1\n}\n", "a: 1\n]\n", "}", "]", ",", "a: {b: 1}}\n", "- a\n,\n"}) {
    CAPTURE(text);
    CHECK(message([&] { parse(text); }).starts_with("robot.yaml:"));
  }
}

TEST_CASE("a file of two documents, of which one would be lost") {
  CHECK(message([] { parse("a: 1\n---\nb: 2\n"); }) == "robot.yaml:2: expected one document; a second begins here");
  CHECK(parse("---\na: 1\n...\n").number("a") == 1.0);
}

TEST_CASE("an empty file and a file that is no mapping") {
  CHECK(message([] { parse("").at("name"); }) == "robot.yaml:1: expected a mapping");
  CHECK(message([] { parse("# nothing\n").at("name"); }) == "robot.yaml:1: expected a mapping");
  CHECK(message([] { parse("[1, 2]\n").at("name"); }) == "robot.yaml:1: expected a mapping");
  CHECK(message([] { parse("just words\n").fields(); }) == "robot.yaml:1: expected a mapping");
  CHECK(message([] { parse("[1, 2]\n").finish(); }) == "robot.yaml:1: expected a mapping");
}

TEST_CASE("a value of the wrong kind") {
  const std::string text =
      "name: demo\n"
      "mass: heavy\n"
      "wheels: 4.5\n"
      "fast: maybe\n"
      "size: 3\n"
      "point: [1, 2, 3]\n"
      "pose: [1]\n"
      "body: {width: wide}\n"
      "list: [1, two]\n"
      "nothing:\n"
      "infinite: .inf\n"
      "not_a_number: .nan\n";
  ConfigNode root = parse(text);
  CHECK(message([&] { root.number("mass"); }) == "robot.yaml:2: mass: expected a number");
  CHECK(message([&] { root.integer_in("wheels", 1, 8); }) == "robot.yaml:3: wheels: expected a whole number");
  CHECK(message([&] { root.at("fast").boolean(); }) == "robot.yaml:4: fast: expected true or false");
  CHECK(message([&] { root.at("size").items(); }) == "robot.yaml:5: size: expected a list");
  CHECK(message([&] { root.at("size").vec2(); }) == "robot.yaml:5: size: expected a list");
  CHECK(message([&] { root.at("point").vec2(); }) == "robot.yaml:6: point: expected [x, y]");
  CHECK(message([&] { root.at("pose").pose(); }) == "robot.yaml:7: pose: expected [x, y, theta]");
  CHECK(message([&] { root.text("body"); }) == "robot.yaml:8: body: expected text");
  CHECK(message([&] { root.number("body"); }) == "robot.yaml:8: body: expected a number");
  CHECK(message([&] { root.at("body").number("width"); }) == "robot.yaml:8: body.width: expected a number");
  CHECK(message([&] { root.at("list").vec2(); }) == "robot.yaml:9: list[1]: expected a number");
  CHECK(message([&] { root.number("nothing"); }) == "robot.yaml:10: nothing: expected a number");
  CHECK(message([&] { root.text("nothing"); }) == "robot.yaml:10: nothing: expected text");
  CHECK(message([&] { root.number("infinite"); }) == "robot.yaml:11: infinite: expected a finite number");
  CHECK(message([&] { root.number("not_a_number"); }) == "robot.yaml:12: not_a_number: expected a finite number");
}

TEST_CASE("a value out of bounds or not among the choices") {
  ConfigNode root = parse("mass: -1\ndrive: mecanun\nwheels: 99999999999\nfar: [0, 1e30]\nheading: [0, 0, 90]\n");
  CHECK(message([&] { root.integer_in("wheels", 2, 4); }) == "robot.yaml:3: wheels: 99999999999 is outside [2, 4]");
  CHECK(message([&] { root.at("far").vec2(); }) == "robot.yaml:4: far[1]: 1e+30 is outside [-1000, 1000]");
  CHECK(message([&] { root.at("far").pose(5.0); }) == "robot.yaml:4: far[1]: 1e+30 is outside [-5, 5]");
  CHECK(message([&] { root.at("heading").pose(); }) ==
        "robot.yaml:5: heading[2]: 90 is outside [-6.2832, 6.2832]");  // degrees
  CHECK(message([&] { root.number_in("mass", 0.0, 100.0); }) == "robot.yaml:1: mass: -1 is outside [0, 100]");
  CHECK(message([&] { root.choice("drive", {"differential", "mecanum"}); }) ==
        "robot.yaml:2: drive: unknown drive 'mecanun'; did you mean 'mecanum'?");
  CHECK(message([&] { root.choice("drive", {"tracks"}); }) ==
        "robot.yaml:2: drive: unknown drive 'mecanun'; known: tracks");
}

TEST_CASE("a field that is missing") {
  ConfigNode root = parse("name: demo\nbody:\n  height: 0.15\n");
  CHECK(message([&] { root.at("mass"); }) == "robot.yaml:1: missing field 'mass'");
  ConfigNode body = root.at("body");
  CHECK(message([&] { body.at("width"); }) == "robot.yaml:3: body: missing field 'width'");
}

TEST_CASE("a field that nobody knows") {
  ConfigNode root = parse("name: demo\nmas: 2.5\n");
  CHECK(root.text("name") == "demo");
  CHECK(root.number("mass", 1.0) == 1.0);
  CHECK(message([&] { root.finish(); }) == "robot.yaml:2: unknown field 'mas'; did you mean 'mass'?");

  ConfigNode nested = parse("body:\n  height: 0.15\n  quite_different: 1\n");
  ConfigNode body = nested.at("body");
  CHECK(body.number("height") == 0.15);
  CHECK(message([&] { body.finish(); }) == "robot.yaml:3: body: unknown field 'quite_different'; known: height");
}

TEST_CASE("a field that stands twice, and a name that is no text") {
  ConfigNode twice = parse("mass: 1\nname: demo\nmass: 2\n");
  CHECK(twice.text("name") == "demo");
  CHECK(twice.has("mass"));
  CHECK(message([&] { twice.finish(); }) == "robot.yaml:3: field 'mass' stands twice, first in line 1");
  CHECK(message([&] { parse("a: 1\nb: 2\na: 3\n").fields(); }) ==
        "robot.yaml:3: field 'a' stands twice, first in line 1");
  CHECK(message([] { parse("[1, 2]: 3\n").finish(); }) == "robot.yaml:1: a field's name must be text");
  CHECK(message([] { parse("[1, 2]: 3\n").fields(); }) == "robot.yaml:1: a field's name must be text");
}

}  // namespace
TEST_CASE("what is not UTF-8 is refused with its line") {
  const auto line_of = [](const std::string& text) -> std::string {
    try {
      ConfigNode::parse("a: 1\nb: " + text + "\n", "file.yaml");
      return "";
    } catch (const ConfigError& error) {
      return error.what();
    }
  };
  for (const char* good : {"Caf\xC3\xA9", "\xE2\x82\xAC", "\xF0\x9F\xA4\x96"}) CHECK(line_of(good).empty());
  for (const char* bad : {"Caf\xE9", "\xC0\xAF", "\xED\xA0\x80", "\xF5\x80\x80\x80", "\xE2\x82", "\x80", "\xE0\x80\x80",
                          "\xF4\x90\x80\x80"}) {
    CHECK(line_of(bad) == "file.yaml:2: expected UTF-8 text; save the file as that");
  }
  CHECK(line_of(std::string(4, '\0')) == "file.yaml:2: expected UTF-8 text; save the file as that");  // as in UTF-32
}

}  // namespace threewe
