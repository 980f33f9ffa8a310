// The random numbers of many lidar points at once, vectorised.
#pragma once

#include <cstddef>
#include <cstdint>

#include "threewe/core/rng.hpp"

namespace threewe::models {

/// Points that are drawn at a time.
inline constexpr std::size_t kDrawn = 64;

/// What scatters a point, standard normal, and what decides whether it is lost, a random word.
struct PointDraws {
  alignas(64) double scatter[kDrawn];
  alignas(64) std::uint64_t fate[kDrawn];  // below 2^32
};

/// The draws of points from `first` on, at least `count` of them, at most kDrawn: of each point, scatter of the first
/// two words of `random_bits(key, point)` by `normal_quantile`, and the third word.
void draw_points(const RngKey& key, std::uint64_t first, std::size_t count, PointDraws& draws);

}  // namespace threewe::models
