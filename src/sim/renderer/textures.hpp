// Textures: for every material one small tile of brightness that repeats, at several sizes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "sim/renderer.hpp"

namespace threewe::sim::view {

inline constexpr std::size_t kMaterials = 29;
inline constexpr int kTileSide = 256;  ///< texels, at level 0; each level has half the side of the one before
inline constexpr int kTileLevels = 9;  ///< the last is one texel
inline constexpr int kTileSize = kTileSide * kTileSide * 3 / 2;  ///< from one material's tile to the next

/// From one line of texels of a level to the next. Lines are those of one u. Those of small levels lie close together,
/// those of large ones not at powers of two, which would crowd a few places of the cache.
constexpr int texel_stride(int side) { return side < 64 ? side : side + side / 8; }
/// The first texel of a level in its tile, for a level that is `side` texels wide.
constexpr int first_texel(int side) { return kTileSize - (side * side * 3 + 1) / 2; }

/// How a material takes colour: what is 0 in its tile is shown at `dark` times the colour, what is 1 at `light` times.
struct MaterialSpec {
  double tile_size;  ///< [m]
  float dark;
  float light;
};
const MaterialSpec& spec(Material material);

/// What a material's surfaces wear instead in an episode whose `Shading::texture` is this: another for the same use.
/// Itself for 0; some keep what they have.
Material pattern_of(std::uint32_t texture, Material material);
/// The same of each.
std::array<Material, kMaterials> patterns_of(std::uint32_t texture);

/// All tiles, one after the other, and one more texel, whose brightness is 1. A texel is its brightness, in 1/170.
const std::vector<std::uint8_t>& tiles();
inline constexpr float kTexelOne = 170.0F;
inline constexpr std::size_t kOneTexel = kMaterials * kTileSize;

/// The brightness of a material at (u, v) [tiles] on a level. The slow, obvious twin of the kernel's.
double sample(Material material, int level, double u, double v);

}  // namespace threewe::sim::view
