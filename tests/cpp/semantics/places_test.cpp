#include "semantics/places.hpp"

#include <filesystem>

#include <doctest/doctest.h>

#include "threewe/core/errors.hpp"

using namespace threewe;
using semantics::parse_places;
using semantics::Place;

namespace {

std::string message(const std::string& text, const map::OccupancyGrid* within = nullptr) {
  try {
    (void)parse_places(text, "places.yaml", within);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return {};
}

std::string of(const std::string& place) { return "version: 1\nplaces:\n  - " + place + "\n"; }

}  // namespace

TEST_CASE("places come back from a file as they were") {
  const std::vector<Place> places = {
      {.name = "kitchen", .polygon = {{0.0, 0.0}, {4.0, 0.0}, {4.0, 3.5}}},
      {.name = R"(the "old" lab: no. 7, {x} # it's)", .polygon = {{-1.25, 2.0}}},
      {.name = "caf\xC3\xA9", .polygon = {{1.0, 1.0}}, .origin = "seen"},
  };
  const auto file = std::filesystem::temp_directory_path() / "places_test.yaml";
  semantics::save_places(places, file);
  const std::vector<Place> read = semantics::load_places(file);
  std::filesystem::remove(file);
  REQUIRE(read.size() == places.size());
  for (std::size_t i = 0; i < places.size(); ++i) {
    CHECK(read[i].name == places[i].name);
    CHECK(read[i].polygon == places[i].polygon);
    CHECK(read[i].origin == places[i].origin);
  }
  CHECK(parse_places(semantics::to_yaml({}), "none.yaml").empty());
  CHECK_THROWS_AS(semantics::save_places(places, "places.txt"), ConfigError);
  CHECK_THROWS_AS(semantics::save_places(places, "/nowhere/at/all/places.yaml"), ConfigError);
}

TEST_CASE("each mistake in a places file is one error with its line") {
  map::OccupancyGrid grid;
  grid.width = grid.height = 100;
  grid.data.assign(10000, 0);
  CHECK(message("version: 2\nplaces: []\n").starts_with("places.yaml:1: version"));
  CHECK(message("places: []\n").find("version") != std::string::npos);
  CHECK(message("version: 1\n").find("places") != std::string::npos);
  CHECK(message(of("{point: [0, 0]}")).starts_with("places.yaml:3: "));
  CHECK(message(of("{name: '', point: [0, 0]}")).find("expected a name") != std::string::npos);
  CHECK(message(of("{name: start, point: [0, 0]}")).find("'start' is where the robot began") != std::string::npos);
  CHECK(message(of("{name: a, point: [0, 0]}\n  - {name: a, point: [1, 0]}")) ==
        "places.yaml:4: places[1].name: place 'a' is there already");
  CHECK(message(of("{name: a, polygon: [[0, 0], [1, 0]]}")) ==
        "places.yaml:3: places[0].polygon: expected three points or more, got 2");
  CHECK(message(of("{name: a}")) == "places.yaml:3: places[0]: expected either a point or a polygon");
  CHECK(message(of("{name: a, point: [0, 0], polygon: []}")) ==
        "places.yaml:3: places[0]: expected either a point or a polygon");
  CHECK(message(of("{name: a, point: [0, .nan]}")).starts_with("places.yaml:3: places[0].point[1]"));
  CHECK(message(of("{name: a, point: [0, .inf]}")).starts_with("places.yaml:3: places[0].point[1]"));
  CHECK(message(of("{name: a, point: [0]}")) == "places.yaml:3: places[0].point: expected [x, y]");
  CHECK(message(of("{name: a, point: [0, 0], color: red}")).find("color") != std::string::npos);
  CHECK(message(of("{name: a, point: [0, 0], origin: sean}")).find("seen") != std::string::npos);
  CHECK(message(of("{name: a, point: [6, 1]}"), &grid) ==
        "places.yaml:3: places[0].point: (6, 1) is outside of the map, which goes from (0, 0) to (5, 5)");
  CHECK(message(of("{name: a, point: [4, 1]}"), &grid).empty());
  CHECK_THROWS_AS((void)semantics::load_places("/nowhere.yaml"), ConfigError);
}
