// Whether options fit together.
#pragma once

#include "threewe/env/options.hpp"

namespace threewe::env {

inline constexpr std::size_t kMostRobots = 8;      // in one world
inline constexpr std::size_t kMostTaskFields = 8;  // that a task adds

/// The options with their defaults filled in. Throws ConfigError naming what does not fit.
Options checked(Options options);

}  // namespace threewe::env
