// Skills: one small state machine for each, over the robot's public calls.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "agent/body.hpp"

namespace threewe::agent {

/// A skill in progress.
class SkillRun {
 public:
  virtual ~SkillRun() = default;
  /// Goes on; how it ended, once it has.
  virtual std::optional<Outcome> update(Body& body) = 0;
  /// Ends what it has begun.
  virtual void cancel() {}
};

/// Whether a step rests on what a camera shows.
bool needs_camera(const Body& body, const language::Step& step);
/// The run of a plan's step. Throws ContractError where the step names what is not known.
std::unique_ptr<SkillRun> begin_skill(Body& body, const language::Step& step);
/// Looks for a thing until the robot stands before it and has seen it there.
std::unique_ptr<SkillRun> begin_search(const language::ThingPhrase& thing);
/// Whether a route says anything of things; what cannot be understood does not.
bool names_things(const Body& body, const std::string& route);
/// Follows the clauses of a route through the places whose borders are known. Throws language::UnknownRoom where it
/// names another place, and ConfigError where it cannot be understood otherwise.
std::unique_ptr<SkillRun> begin_route(Body& body, const std::string& text);

}  // namespace threewe::agent
