// Procedural scene generator: furnished buildings drawn from a seed.
#pragma once

#include <cstdint>

#include "threewe/scene/scene.hpp"

namespace threewe::scene {

/// What kind of place is wanted.
struct GeneratorOptions {
  double difficulty = 0.5;  ///< 0 to 1: from sparse rooms with wide doors to crowded ones with narrow doors
  Vec2 size{14.0, 10.0};    ///< [m] of the building, each side 6 to 40
};

/// A building with furnished rooms, named `generated_SEED`. Every room has a door and can be reached from the start by
/// all robots that come with the library; (2, 1) is free. A pure function of its arguments, the same on every machine.
/// Throws ConfigError where an option is out of its range.
Scene generate(std::uint64_t seed, const GeneratorOptions& options = {});

}  // namespace threewe::scene
