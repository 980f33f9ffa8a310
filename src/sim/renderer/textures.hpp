// Textures: for every material one small tile of brightness that repeats, at several sizes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "threewe/sim/renderer.hpp"

namespace threewe::sim::view {

inline constexpr std::size_t kMaterials = 29;
inline constexpr int kTileSide = 128;     ///< texels, at level 0; each level has half the side of the one before
inline constexpr int kTileLevels = 8;     ///< the last is one texel
inline constexpr int kTexelStride = 136;  ///< from one line of texels to the next, at every level
inline constexpr int kTileLines = 384;    ///< from one material's tile to the next

/// The first line of a level in its tile, for a level that is `side` texels wide. Lines are those of one u, since
/// pictures are drawn from top to bottom. Levels have one more line and one more texel in each than that, equal to
/// their first: a coordinate that rounds up to the far edge stays in the level.
constexpr int level_line(int side) { return 3 * (kTileSide - side); }

/// How a material takes colour: what is 0 in its tile is shown at `dark` times the colour, what is 1 at `light` times.
struct MaterialSpec {
  double tile_size;  ///< [m]
  float dark;
  float light;
};
const MaterialSpec& spec(Material material);

/// All tiles, one after the other. A texel is four bytes: its own brightness and those of its neighbours at +x, +y and
/// +x +y, so that one load is enough to interpolate.
const std::vector<std::uint32_t>& tiles();

/// The brightness, 0 to 255, of a material at (u, v) [tiles], interpolated between the texels of a level. The slow,
/// obvious twin of the kernel's.
double sample(Material material, int level, double u, double v);

}  // namespace threewe::sim::view
