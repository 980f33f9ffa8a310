// Validation of environment options.
#pragma once

#include <span>

#include "threewe/env/options.hpp"

namespace threewe::env {

inline constexpr std::size_t kMostWorlds = 1'000'000;
inline constexpr std::size_t kMostRobots = 8;      // in one world
inline constexpr std::size_t kMostTaskFields = 8;  // that a task adds
inline constexpr int kMostImageSide = 2048;        // [px] of a picture that is drawn at every step, in some seconds

/// The options with their defaults filled in. Throws ConfigError naming what does not fit.
Options checked(Options options);
/// Throws ContractError for a world, or a robot in it, that is not there.
void check_place(std::size_t world, std::size_t worlds, std::size_t robot = 0, std::size_t robots = 1);
/// The rays that a task reads. Throws ConfigError for a robot without the lidar that they come from.
std::size_t rays_of(const task::Task& task, const RobotProfile& robot);
/// Throws ContractError where actions are not of the shape (rows, 3), or one is not finite.
void check_actions(std::span<const float> actions, std::size_t rows);

}  // namespace threewe::env
