// Shared parts of the conformance checks of cameras.
#pragma once

#include "backend/conformance_bench.hpp"

namespace threewe::backend::conformance {

/// A connected robot with a camera; the check does not apply to one without.
Bench with_camera(const Context& context);
/// An image that was taken from now on.
RGBDImage next_image(Bench& bench);

}  // namespace threewe::backend::conformance
