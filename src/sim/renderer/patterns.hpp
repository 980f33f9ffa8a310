// Texture generator: for every material, how bright it is at each point of a tile that repeats.
#pragma once

#include <functional>

#include "sim/renderer.hpp"

namespace threewe::sim::view {

/// Brightness, 0 to 1, at (x, y) in the unit square, y upwards on walls.
using Pattern = std::function<double(double, double)>;
Pattern pattern(Material material);

}  // namespace threewe::sim::view
