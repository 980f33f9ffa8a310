// Surface textures that domain randomization draws.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "export/transform.hpp"
#include "sim/model.hpp"
#include "threewe/core/camera.hpp"

namespace threewe::backend::mujoco {

/// What pixels show, row by row.
struct Shown {
  std::span<const std::int16_t> ids;
  std::span<const float> depth;  ///< [m] along the optical axis, 0 where there is nothing
};

/// Darkens and brightens an image by the patterns of a variation's `texture`, in its `detail`: those that the embedded
/// renderer lays on the same surfaces, here along the scene's axes. People and robots stay plain.
void wear_patterns(const sim::Model& world, const models::Variation& variation, const CameraIntrinsics& camera,
                   const exports::Transform& scene_from_camera, const Shown& shown, std::span<std::uint8_t> color);

}  // namespace threewe::backend::mujoco
