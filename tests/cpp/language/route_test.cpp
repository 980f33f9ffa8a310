// Routes of people, who do not keep to the words in which VLN instructions are written.
#include "language/route.hpp"

#include <doctest/doctest.h>

#include <array>
#include <string>

namespace threewe::language {
namespace {

const RouteNames kNames{.rooms = {"kitchen", "office 1", "open office", "children's room"},
                        .things = {"chair", "office chair", "desk", "door", "plant"}};

// A route in the words in which it is written.
std::string canonical(const char* text) {
  // the key draws the first synonym or another one: read again, all mean the same
  const Route route = parse_route(text, kNames);
  CAPTURE(to_text(route, {}));
  CHECK(parse_route(to_text(route, {}), kNames) == route);
  std::string kinds;
  for (const Clause& clause : route) {
    constexpr std::array kKinds = {"turn", "pass", "approach", "cross", "stop_at", "middle", "inside", "here"};
    constexpr std::array kSides = {" left", " right", " ahead", " behind"};
    kinds += kinds.empty() ? "" : "; ";
    kinds += kKinds.at(static_cast<std::size_t>(clause.kind));
    if (clause.kind <= Clause::Kind::pass) kinds += kSides.at(static_cast<std::size_t>(clause.side));
    for (const std::string& name : {clause.thing.noun, clause.from, clause.room})
      kinds += name.empty() ? "" : " " + name;
    if (clause.door && clause.door->side) kinds += kSides.at(static_cast<std::size_t>(*clause.door->side));
  }
  return kinds;
}

TEST_CASE("people's words for a route are read") {
  CHECK(canonical("make a left, then take a right turn and turn back") == "turn left; turn right; turn behind");
  CHECK(canonical("turn to your right and go straight") == "turn right; turn ahead");
  CHECK(canonical("take a door on the left") == "cross left");
  CHECK(canonical("pass through the second door to your right into the kitchen") == "cross kitchen right");
  CHECK(canonical("pass the plant and stop near a chair") == "pass ahead plant; stop_at chair");
  CHECK(canonical("walk to the kitchen, walk to the office chair") == "cross kitchen; approach office chair");
  CHECK(canonical("walk to the open office and stop") == "cross open office; here");
  CHECK(canonical("go out of office 1 through the door and wait here") == "cross office 1; here");
  CHECK(canonical("stop at the kitchen") == "inside kitchen");
  CHECK(canonical("Enter the children's room. Stop in front of the desk!") == "cross children's room; stop_at desk");
}

TEST_CASE("a room without such a name is not the same as a text that cannot be understood") {
  CHECK_THROWS_WITH_AS(
      parse_route("enter the kichen", kNames),
      "instruction not understood at word 3, 'kichen': wanted a room; unknown room 'kichen'; did you mean 'kitchen'?",
      UnknownRoom);
  try {
    parse_route("stop at the lamp", kNames);
    FAIL("must not be understood");
  } catch (const UnknownRoom&) {
    FAIL("a lamp is no room");
  } catch (const ConfigError&) {
  }
}

}  // namespace
}  // namespace threewe::language
