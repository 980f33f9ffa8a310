#include "agent/landmarks.hpp"

#include <doctest/doctest.h>

using namespace threewe;
using agent::Candidate;
using agent::Nouns;
using agent::Walker;
using language::Clause;
using language::Side;
using language::Thing;
using semantics::MappedThing;
using semantics::Place;

namespace {

const std::vector<std::string> kLabels = {"background", "chair", "plant", "desk"};
const Place kRoom{.name = "room", .polygon = {{0, -3}, {10, -3}, {10, 3}, {0, 3}}};

MappedThing thing(std::uint64_t id, std::size_t kind, Vec2 at, double sure = 0.9) {
  MappedThing made;
  made.id = id;
  made.position = at;
  made.kinds.assign(kLabels.size(), (1.0 - sure) / 2.0);
  made.kinds[0] = 0.0;
  made.kinds[kind] = sure;
  made.views = 5;
  return made;
}

// Along the x axis.
Walker walker() { return {.at = {0, 0}, .heading = {1, 0}, .since = {0, 0}}; }

std::uint64_t meant(const std::vector<MappedThing>& things, const Thing& phrase, const Walker& from = walker()) {
  const std::vector<Candidate> found = rank(from, kRoom, things, Nouns(kLabels), phrase);
  return found.empty() ? 0 : found.front().thing.id;
}

}  // namespace

TEST_CASE("of several things, the one is meant that all that is said fits") {
  const std::vector things = {thing(1, 1, {2, 1}), thing(2, 1, {4, 1}), thing(3, 1, {6, -1}), thing(4, 2, {6, 1}),
                              thing(5, 3, {6.8, -1})};
  CHECK(meant(things, {.noun = "plant"}) == 4);
  CHECK(meant(things, {.noun = "fern"}) == 4);  // a shape of plants
  CHECK(meant(things, {.which = Thing::Which::nearest, .noun = "chair"}) == 1);
  CHECK(meant(things, {.which = Thing::Which::farthest, .noun = "chair"}) == 3);
  CHECK(meant(things, {.which = Thing::Which::nth, .ordinal = 2, .noun = "chair"}) == 2);
  CHECK(meant(things, {.noun = "chair", .side = Side::right}) == 3);
  CHECK(meant(things, {.which = Thing::Which::nth, .ordinal = 2, .noun = "chair", .side = Side::left}) == 2);
  CHECK(meant(things, {.noun = "chair", .next_to = "desk"}) == 3);
  CHECK(meant({}, {.noun = "chair"}) == 0);
}

TEST_CASE("turns, and things that are passed, say which one is meant") {
  const std::vector things = {thing(1, 1, {2, 2.5}), thing(2, 1, {8, 0}), thing(3, 2, {5, -1})};
  Walker turned = walker();
  turned.heading = {0, 1};
  turned.turned = true;
  CHECK(meant(things, {.noun = "chair"}, turned) == 1);
  Clause pass;
  pass.kind = Clause::Kind::pass;
  pass.side = Side::right;
  pass.thing.noun = "plant";
  Walker passing = walker();
  passing.passing.push_back(&pass);
  CHECK(meant(things, {.noun = "chair"}, passing) == 2);
}

TEST_CASE("what no view is sure of is taken, where nothing fits better") {
  CHECK(meant({thing(1, 1, {2, 0}, 0.95), thing(2, 2, {4, 0}, 0.4)}, {.noun = "plant"}) == 2);
  const Nouns nouns(kLabels);
  CHECK_FALSE(nouns.has_kind("bunk bed"));  // these labels have no beds
  CHECK(nouns.has_kind("yucca"));
  CHECK_FALSE(nouns.is_kind("yucca"));
  CHECK(nouns.is_kind("plant"));
}

TEST_CASE("a thing stands where the map says, and one stops beside it on the side from which one came") {
  map::OccupancyGrid grid;
  grid.width = 220;
  grid.height = 140;
  grid.origin = {-0.5, -3.5};
  grid.data.assign(static_cast<std::size_t>(grid.width) * static_cast<std::size_t>(grid.height), 4);
  for (double x = 5.025; x < 6.0; x += 0.05) {
    for (double y = -1.975; y < 2.0; y += 0.05) grid.data[grid.index(grid.cell({x, y}))] = 100;
  }
  const Vec2 at = agent::by_the_map(grid, {0, 0}, {4.2, 0});
  CHECK(at.x > 5.0);
  CHECK(norm(agent::by_the_map(grid, {0, 0}, {5.2, 0}) - Vec2{5.2, 0}) < 1e-9);
  CHECK(norm(agent::by_the_map(grid, {0, 0}, {0, 2}) - Vec2{0, 2}) < 1e-9);  // nothing there at all

  const agent::Reachable reachable(grid, {1, 0}, 0.2);
  const auto stand = agent::place_at(grid, reachable, kRoom, {5.2, 0}, {1, 0});
  REQUIRE(stand);
  CHECK(stand->x > 4.2);
  CHECK(stand->x < 5.0);
  CHECK(std::fabs(stand->y) < 0.5);
  const auto other = agent::place_at(grid, reachable, kRoom, {5.2, 0}, {9, 0});
  REQUIRE(other);
  CHECK(other->x > 6.0);
}
