// Wall joints: where walls share corners.
#pragma once

#include "threewe/scene/scene.hpp"

namespace threewe::scene {

/// Whether two walls run in the same or in opposite directions.
bool parallel(const Wall& a, const Wall& b);

}  // namespace threewe::scene
