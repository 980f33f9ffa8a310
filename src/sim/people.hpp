// Pedestrian model: people walk closed routes, and wait for robots in their way.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

#include "sim/model.hpp"
#include "sim/state.hpp"
#include "threewe/scene/solid.hpp"

namespace threewe::sim {

inline constexpr double kPersonHeight = 1.75;  ///< [m]
inline constexpr double kKneeHeight = 0.46;    ///< [m]: below it, a person is two legs

/// One person. Plain data.
struct PersonState {
  double along = 0.0;  ///< [m] walked on the route, from its first waypoint
};
static_assert(std::is_trivially_copyable_v<PersonState>);

/// Where a person is on a route, as seen from above, and which way they walk (a unit vector).
struct PersonPlace {
  scene::Circle circle;
  Vec2 direction;
};
PersonPlace place_on(const scene::Person& person, const PersonState& state);
/// All of them.
std::vector<scene::Circle> circles_of(const Model& model, std::span<const PersonState> people);

/// How far the left leg has swung forward [m], of a person who keeps within 0.25 m; the right one is as far behind.
double swing_of(const PersonState& state);
/// Both legs of a person, below the knee: what robots touch, and what their sensors see. They swing with the way that
/// was walked, and stay within the person's circle.
std::array<scene::Circle, 2> legs_of(const scene::Person& person, const PersonState& state);
/// Those of all people.
std::vector<scene::Circle> legs_of(const Model& model, std::span<const PersonState> people);
inline constexpr double kLegRadius = 0.062;  ///< [m] of a person who keeps within 0.25 m, and so on
inline constexpr double kLegAside = 0.09;    ///< [m] from the middle

/// The people of a scene as an episode begins, each somewhere on the route, by the seed; farther on where a robot
/// stands there. Throws ConfigError when a robot leaves no room on a person's route.
std::vector<PersonState> begin_people(const Model& model, std::span<const RobotState> robots, std::uint64_t seed,
                                      std::uint32_t episode = 0);

/// Lets all people walk for one step: at their speed, unless a robot is in the metre ahead, or would be touched.
void walk(const Model& model, std::span<const RobotState> robots, std::span<PersonState> people);

}  // namespace threewe::sim
