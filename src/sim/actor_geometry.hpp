// Actor geometry for the camera: people as articulated figures, other robots as bodies on wheels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "sim/model.hpp"
#include "sim/people.hpp"
#include "sim/renderer.hpp"

namespace threewe::sim {

/// Ids in pictures, one behind the other:
///   0 nothing, 1 floor, 2 wall, 3 ceiling,
///   `kFirstObjectId + i`           object i of the scene,
///   `person_id(scene, i)`          person i of the scene,
///   `robot_id(scene, i)`           robot i of the world.
std::int16_t person_id(const scene::Scene& scene, std::size_t person);
std::int16_t robot_id(const scene::Scene& scene, std::size_t robot);
/// The names of all ids, by id: those of objects and people are the scene's, robots are "robot_0", "robot_1", ...
/// Throws ConfigError if there are more than pictures have ids.
std::vector<std::string> id_names(const Model& model);

/// Fills `figures` with all people, and all robots, where they are (scene frame), but the one that looks (an index
/// beyond the last robot looks from elsewhere). People's clothes are a pure function of seed, episode and the person's
/// index. A person keeps within their circle, and a robot, above its wheels, fills its footprint: the camera sees them
/// where other sensors do.
void find_actors(const Model& model, std::span<const Pose2D> robots, std::size_t looking,
                 std::span<const PersonState> people, std::uint64_t seed, std::uint32_t episode,
                 std::vector<VisibleSolid>& figures);

}  // namespace threewe::sim
