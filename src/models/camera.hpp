// Camera noise model: mounting, colour noise and depth noise.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "core/rng.hpp"
#include "threewe/hardware/profile.hpp"
#include "threewe/models/randomization.hpp"

namespace threewe::models {

/// The camera of one robot in one episode: moved on its mount, and as noisy as the variation says.
CameraSpec varied(const CameraSpec& spec, const Variation& variation);

/// What an episode's light, exposure and colour jitter multiply blue, green and red by: 0 at least.
std::array<double, 3> color_gains(const Variation& variation, const RngKey& key);

/// Adds noise of its own to every colour of image number `image`: (H, W, 3), in place. It stays within 0 to 255.
void add_color_noise(const CameraSpec& spec, const RngKey& key, std::uint64_t image, std::span<std::uint8_t> color);

/// Turns true depths [m] along the optical axis, 0 where there is nothing, into what is measured of them: (H, W), in
/// place. The noise grows with the square of the depth; what is out of range is invalid, 0.
void measure_depth(const DepthSpec& spec, const RngKey& key, std::uint64_t image, std::span<float> depth);

}  // namespace threewe::models
