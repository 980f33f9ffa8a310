// Semantic classes of surfaces: what images show besides objects, people and robots.
#pragma once

#include <array>
#include <string_view>

namespace threewe::scene {

/// The names of the ids 0 to 3 of pictures; nothing else may have them.
inline constexpr std::array<std::string_view, 4> kSurfaceNames = {"nothing", "floor", "wall", "ceiling"};

}  // namespace threewe::scene
