// Instructions in English say what they should, and are understood as they were meant.
#include "task/interpreter.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <set>

#include "core/exact.hpp"
#include "draw.hpp"
#include "task/small_house.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::task {
namespace {

const SemanticMap& house() {
  static const MappedScene scene(small_house());
  return scene.map;
}

Clause random_clause(Draw& draw) {
  const auto any_of = [&](const auto& of) {
    return of[static_cast<std::size_t>(draw.whole(0, static_cast<int>(of.size()) - 1))];
  };
  const auto side = [&] { return draw.whole(0, 1) == 0 ? Side::left : Side::right; };
  const auto noun = [&] {
    const Landmark& landmark =
        house().landmarks()[static_cast<std::size_t>(draw.whole(0, static_cast<int>(house().landmarks().size()) - 1))];
    return draw.whole(0, 1) == 0 ? landmark.noun : landmark.general;
  };
  const auto thing = [&](bool with_side) {
    Thing t;
    t.which = static_cast<Thing::Which>(draw.whole(0, 3));
    t.ordinal = t.which == Thing::Which::nth ? draw.whole(1, kLastOrdinal) : 0;
    t.noun = noun();
    if (with_side && draw.whole(0, 1) == 0) t.side = side();
    if (with_side && draw.whole(0, 2) == 0) t.next_to = noun();
    return t;
  };
  Clause c;
  c.kind = static_cast<Clause::Kind>(draw.whole(0, 7));
  switch (c.kind) {
    case Clause::Kind::turn: c.side = static_cast<Side>(draw.whole(0, 3)); break;
    case Clause::Kind::pass:
      c.side = side();
      c.thing = thing(false);
      break;
    case Clause::Kind::approach:
    case Clause::Kind::stop_at: c.thing = thing(true); break;
    case Clause::Kind::cross: {
      const int how = draw.whole(0, 3);
      if (how > 0) {
        c.door = DoorPhrase{.ordinal = draw.whole(0, kLastOrdinal), .side = std::nullopt};
        if (draw.whole(0, 1) == 0) c.door->side = static_cast<Side>(draw.whole(0, 3));
        if (how == 2) c.from = any_of(house().rooms());
      }
      if (how != 1) c.room = any_of(house().rooms());
      break;
    }
    case Clause::Kind::stop_in_middle: c.room = any_of(house().rooms()); break;
    case Clause::Kind::stop_inside: c.room = draw.whole(0, 1) == 0 ? any_of(house().rooms()) : ""; break;
    case Clause::Kind::stop_here: break;
  }
  return c;
}

TEST_CASE("what is written is read as it was meant") {
  std::set<Clause::Kind> kinds;
  for (std::uint64_t seed = 0; seed < cases(5000); ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    Instruction instruction;
    for (int i = draw.whole(1, 7); i > 0; --i) instruction.push_back(random_clause(draw));
    // "just inside" without a room can only end an instruction
    for (std::size_t i = 0; i + 1 < instruction.size(); ++i) {
      if (instruction[i].kind == Clause::Kind::stop_inside) instruction[i].room = "study";
      kinds.insert(instruction[i].kind);
    }
    const std::string text = to_text(instruction, {.seed = seed, .stream = Stream::sampler});
    CAPTURE(text);
    CHECK(parse(text, house()) == instruction);
    CHECK(to_text(instruction, {.seed = seed, .stream = Stream::sampler}) == text);
    CHECK((text.front() >= 'A' && text.front() <= 'Z'));
    CHECK(text.back() == '.');
  }
  CHECK(kinds.size() == 8);
}

TEST_CASE("what cannot be understood says where, and what would be right") {
  const auto message = [](const char* text) -> std::string {
    try {
      parse(text, house());
    } catch (const ConfigError& error) {
      return error.what();
    }
    return {};
  };
  CHECK(
      message("Dance.") ==
      "instruction not understood at word 1, 'dance': wanted something to do, such as 'turn', 'go', 'enter' or 'stop'");
  CHECK(
      message("Turn left and enter the kichen.") ==
      "instruction not understood at word 6, 'kichen': wanted a room; unknown room 'kichen'; did you mean 'kitchen'?");
  CHECK(message("Stop at the plnat.") ==
        "instruction not understood at word 4, 'plnat': wanted a thing; unknown thing 'plnat'; did you mean 'plant'?");
  CHECK(message("Turn.") == "instruction not understood at its end: wanted left, right or around");
  CHECK(message("Walk past.") == "instruction not understood at its end: wanted 'the' and a thing");
  CHECK(message("Take the second window.") == "instruction not understood at word 4, 'window': wanted 'door'");
}

// The room in which somebody ends up who starts in the west of the corridor, or "nowhere", or "anywhere".
std::string room_after(const char* text, Pose2D start = {0.0, 0.0, 0.0}) {
  const std::vector<Reading> found = readings(parse(text, house()), house(), start);
  std::set<std::string> rooms;
  for (const Reading& reading : found) rooms.insert(house().rooms()[house().room_at(reading.end).value()]);
  if (rooms.size() > 1) return "anywhere";
  return rooms.empty() ? "nowhere" : *rooms.begin();
}

TEST_CASE("left and right, and the order of doors, are those of somebody who walks") {
  const Pose2D from_east{11.0, 0.0, exact::kPi};  // 12.0 m less the start's 0.6: in the east, looking west
  CHECK(room_after("Take the first door on your left. Stop just inside.") == "kitchen");
  CHECK(room_after("Take the second door on your left. Stop just inside.") == "study");
  CHECK(room_after("Take the third door on your left. Stop just inside.") == "bedroom");
  CHECK(room_after("Take the fourth door on your left. Stop just inside.") == "nowhere");
  CHECK(room_after("Take the second door on your right. Stop just inside.") == "office 2");
  CHECK(room_after("Take the door on your right. Stop just inside.") == "anywhere");
  CHECK(room_after("Take the first door on your right. Stop just inside.", from_east) == "bedroom");
  CHECK(room_after("Take the second door on your left. Stop just inside.", from_east) == "office 1");
  CHECK(room_after("Turn around and take the first door on your left. Stop just inside.", from_east) == "nowhere");
  CHECK(room_after("Turn around and take the first door on your left. Stop just inside.", {11.0, 0.0, 0.0}) ==
        "office 2");

  // out of the study, and on
  const Pose2D in_study{5.4, 3.0, -0.5 * exact::kPi};  // looking south, towards its door
  CHECK(room_after("Leave the study through the door ahead of you. Turn left and take the first door on your left. "
                   "Stop just inside.",
                   in_study) == "bedroom");
  CHECK(room_after("Go through the door, turn right and take the first door on your left. Stop just inside.",
                   in_study) == "office 1");
  CHECK(room_after("Leave the kitchen through the door. Stop just inside.", in_study) == "nowhere");
}

TEST_CASE("things are told apart by side, number, neighbour and distance") {
  const auto end_of = [](const char* text, std::size_t count) {
    const std::vector<Reading> found = readings(parse(text, house()), house(), {0.0, 0.0, 0.0});
    CHECK_MESSAGE(found.size() == count, text);
    return found.empty() ? Vec2{} : found.front().end + Vec2{0.6, 5.0};  // as the scene was drawn
  };
  end_of("Enter the study and stop at the chair.", 3);
  end_of("Enter the study and stop at the wooden chair.", 2);
  CHECK(distance(end_of("Enter the study and stop at the armchair.", 1), {7.4, 7.5}) < 1.0);
  CHECK(distance(end_of("Enter the study and stop at the wooden chair on your left.", 1), {4.6, 9.5}) < 1.0);
  CHECK(distance(end_of("Enter the study and stop at the wooden chair on your right.", 1), {7.4, 9.5}) < 1.0);
  CHECK(distance(end_of("Enter the study and stop at the second chair on your right.", 1), {7.4, 9.5}) < 1.0);
  CHECK(distance(end_of("Enter the study and stop at the nearest chair.", 1), {7.4, 7.5}) < 1.0);
  CHECK(distance(end_of("Enter the study and stop at the wooden chair next to the shelf.", 1), {7.4, 9.5}) < 1.0);
  end_of("Enter the study and stop at the refrigerator.", 0);
  end_of("Enter the study and stop in the middle of the kitchen.", 0);
  CHECK(distance(end_of("Enter the study and stop in the middle of the study.", 1), {6.0, 8.0}) < 0.2);
}

TEST_CASE("what is passed, and where one turns, must fit") {
  CHECK(room_after("Walk past the plant on your right, then take the second door on your left. Stop just inside.") ==
        "study");
  CHECK(room_after("Walk past the plant on your left, then take the second door on your left. Stop just inside.") ==
        "nowhere");
  CHECK(room_after("Walk past the plant on your right, then take the first door on your left. Stop just inside.") ==
        "nowhere");
  CHECK(room_after("Turn left and enter the bedroom. Stop just inside.") == "nowhere");  // it lies ahead
  CHECK(room_after("Go straight ahead and enter the bedroom. Stop just inside.") == "bedroom");
  CHECK(room_after(
            "Walk to the nearest plant on your right, turn left and take the door on your right. Stop just inside.") ==
        "nowhere");
  CHECK(room_after("Walk to the nearest plant on your right. Enter the bedroom. Stop just inside.") == "bedroom");
  CHECK(room_after("Enter the bedroom.") == "nowhere");  // nobody said stop
  CHECK(readings(parse("Stop at the plant.", house()), house(), {50.0, 0.0, 0.0}).empty());
}

TEST_CASE("a text, a map and a start are all that is needed to follow") {
  const auto reading = follow("Take the third door on your left and stop just inside.", house(), {});
  REQUIRE(reading);
  CHECK(reading->way.size() == 3);
  CHECK(reading->way.back() == reading->end);
  CHECK_FALSE(follow("Take the third door on your left and dance.", house(), {}));
}

}  // namespace
}  // namespace threewe::task
