// Instruction generator: English for a path.
#pragma once

#include <optional>
#include <vector>

#include "core/rng.hpp"
#include "task/interpreter.hpp"

namespace threewe::task {

/// Where an instruction ends.
struct Ending {
  Clause::Kind kind{};  ///< one of the stops
  std::size_t room = 0;
  std::size_t landmark = 0;            ///< stop_at
  std::optional<std::size_t> opening;  ///< through which the room is entered; any for stop_in_middle
  Vec2 place;
};

/// What can truly be said about a path that starts at a pose, in one of many ways that are drawn from `key`. Nothing
/// where the path cannot be put into words, or ends in another way. Whether what is said suffices is another question.
std::optional<Instruction> describe(const SemanticMap& map, const Pose2D& start, const std::vector<Vec2>& path,
                                    const Ending& ending, const RngKey& key);

}  // namespace threewe::task
