// What skills work with: the robot's public calls, and what it has seen.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "agent/coverage.hpp"
#include "semantics/semantic_map.hpp"
#include "threewe/language/command.hpp"
#include "threewe/robot/runtime.hpp"

namespace threewe::agent {

/// The robot, its memory and its start.
struct Body {
  Runtime& robot;
  semantics::SemanticMap map;
  Coverage coverage;
  Vec2 start;
  std::uint64_t looks = 0;  ///< pictures that were looked at
  Time looked{};            ///< when the newest of them was taken

  Vec2 position() const { return robot.pose().map_from_base().position(); }
  /// The ways that its map knows to be free.
  Reachable reachable() const;
  /// The heading [rad] from where it stands to a point.
  double heading_to(Vec2 point) const;
};

/// How a skill ended.
struct Outcome {
  std::string reason;    ///< "done", "not_found" or a motion's reason
  std::string detail{};  ///< says more; may be empty
  std::string answer{};  ///< as a sentence; may be empty
  std::uint64_t thing = 0;
  bool verified = false;
};

/// A motion that runs until it ends.
class Drive {
 public:
  void begin(Body& body, const nav::Goal& goal) { motion_ = body.robot.start(goal); }
  bool active() const { return motion_ != nullptr; }
  /// The motion's result, once, when it has ended.
  std::optional<MoveResult> take();
  void cancel();

 private:
  MotionHandle motion_;
};

/// The things that a phrase means, the most probable first; those of `tried` left out, and those that are less probably
/// of that kind. An unknown kind, color or place is a ContractError that names the nearest known ones.
std::vector<semantics::MappedThing> things_meant(const Body& body, const language::ThingPhrase& thing,
                                                 const std::vector<std::uint64_t>& tried = {},
                                                 double least_probability = 0.5);
/// A phrase in words: "red chair next to the desk in the lobby".
std::string in_words(const language::ThingPhrase& thing);
/// A mapped thing in words: "red chair at (1.0, 2.0)".
std::string in_words(const Body& body, const semantics::MappedThing& thing);

}  // namespace threewe::agent
