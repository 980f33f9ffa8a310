// Instruction interpreter: where an instruction leads, by the map alone.
#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "language/route.hpp"
#include "task/semantic_map.hpp"

namespace threewe::task {

using language::Clause, language::DoorPhrase, language::kLastOrdinal, language::Side, language::Thing;
using Instruction = language::Route;

/// What a text says, with the names of rooms and things of a map. Throws ConfigError where it cannot be understood.
Instruction parse(std::string_view text, const SemanticMap& map);

/// What is nearer than this to the line of walking [m] may be meant by "left" as well as by "right".
inline constexpr double kAside = 0.3;

/// One way to understand an instruction.
struct Reading {
  std::vector<Vec2> way;  ///< the start, crossings of openings, things walked to, the end
  Vec2 end;
};

/// A walker on the way through a map.
struct Walker {
  Vec2 at;
  Vec2 heading;  ///< of length 1
  std::size_t room = 0;
  std::optional<std::size_t> opening;  ///< through which the room was entered
  Vec2 since;                          ///< the middle of that opening, or the start
  bool turned = false;                 ///< just now: what comes next lies ahead
};

/// A walker at the start of an episode; nothing outside all rooms.
std::optional<Walker> walker_at(const SemanticMap& map, const Pose2D& start);
/// The axis of the scene that a heading is nearest to.
Vec2 along_axis(Vec2 heading);
/// Where a door that leads out in a direction is for a walker who looks along an axis.
Side side_of(Vec2 axis, Vec2 out);
/// A heading turned to a side.
Vec2 turned(Vec2 heading, Side side);
/// Whether a point may be meant after "turn left" and the like: within 60 degrees of the new heading.
bool lies_ahead(Vec2 heading, Vec2 to);
/// Whether a thing is passed on a side (either, for ahead) on the straight way from `a` to `b`, within 2 m.
bool is_passed(Vec2 a, Vec2 b, Vec2 thing, Side side);

/// Indices of the landmarks in the walker's room that may be meant.
std::vector<std::size_t> candidates(const SemanticMap& map, const Walker& walker, const Thing& thing);
/// Indices of the openings of the walker's room that may be meant. They do not turn back.
std::vector<std::size_t> candidates(const SemanticMap& map, const Walker& walker, const Clause& cross);
/// The walker behind an opening, or at a landmark.
Walker through(const SemanticMap& map, Walker walker, std::size_t opening);
Walker up_to(const SemanticMap& map, Walker walker, std::size_t landmark);

/// All ways to understand an instruction for a robot that starts at a pose; none where it makes no sense there. An
/// instruction without a stop leads nowhere.
std::vector<Reading> readings(const Instruction& instruction, const SemanticMap& map, const Pose2D& start);

/// Where a walker ends up who has a text, a map and a start, and nothing else: the first of the readings. Nothing where
/// the text cannot be understood or makes no sense there.
std::optional<Reading> follow(std::string_view text, const SemanticMap& map, const Pose2D& start);

}  // namespace threewe::task
