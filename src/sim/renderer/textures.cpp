// Every tile is made when it is first needed, from numbers that are the same everywhere.
#include "sim/renderer/textures.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "sim/renderer/patterns.hpp"

namespace threewe::sim::view {
namespace {

constexpr std::array<MaterialSpec, kMaterials> kSpecs = {{
    {1.28, 0.80F, 1.08F},   // floor_wood
    {0.80, 0.76F, 1.04F},   // floor_tile
    {0.64, 0.82F, 1.12F},   // floor_carpet
    {2.00, 0.88F, 1.08F},   // floor_concrete
    {1.60, 0.92F, 1.06F},   // floor_vinyl
    {1.00, 0.97F, 1.02F},   // paint
    {1.00, 0.98F, 1.01F},   // trim
    {2.40, 0.86F, 1.16F},   // ceiling
    {480.0, 0.00F, 0.92F},  // sky: clouds
    {0.80, 0.84F, 1.10F},   // wood
    {0.50, 0.93F, 1.06F},   // metal
    {0.60, 0.97F, 1.03F},   // plastic
    {0.18, 0.88F, 1.08F},   // fabric
    {0.90, 0.45F, 1.25F},   // leaf
    {0.50, 0.94F, 1.06F},   // ceramic
    {1.00, 0.92F, 1.08F},   // glass
    {0.70, 0.86F, 1.08F},   // stone
    {0.36, 0.62F, 1.12F},   // paper
    {0.90, 0.62F, 1.22F},   // floor_grass
    {0.80, 0.66F, 1.16F},   // floor_gravel
    {1.60, 0.72F, 1.08F},   // floor_paving
    {1.20, 0.78F, 1.18F},   // floor_asphalt
    {0.60, 0.78F, 1.10F},   // cardboard
    {0.96, 0.72F, 1.12F},   // brick
    {3.20, 0.62F, 1.10F},   // roof
    {1.40, 0.30F, 1.12F},   // window
    {0.70, 0.25F, 1.30F},   // picture
    {0.40, 0.96F, 1.03F},   // skin
    {0.10, 0.80F, 1.10F},   // rubber
}};

double wrapped(double x) { return x - std::floor(x); }

// One level from brightnesses 0 to 255.
void pack(const std::vector<double>& values, int side, std::uint32_t* texels) {
  const auto byte = [&](int x, int y) {
    const int i = (y % side) * side + x % side;
    const double value = values[static_cast<std::size_t>(i)];
    return static_cast<std::uint32_t>(std::lround(std::clamp(value, 0.0, 255.0)));
  };
  for (int x = 0; x <= side; ++x) {
    for (int y = 0; y <= side; ++y) {
      texels[x * kTexelStride + y] =
          byte(x, y) | byte(x + 1, y) << 8U | byte(x, y + 1) << 16U | byte(x + 1, y + 1) << 24U;
    }
  }
}

std::vector<double> halved(const std::vector<double>& values, int side) {
  std::vector<double> half;
  const auto at = [&](int x, int y) {
    const int i = y * side + x;
    return values[static_cast<std::size_t>(i)];
  };
  for (int y = 0; y < side; y += 2) {
    for (int x = 0; x < side; x += 2) {
      half.push_back(0.25 * (at(x, y) + at(x + 1, y) + at(x, y + 1) + at(x + 1, y + 1)));
    }
  }
  return half;
}

std::vector<std::uint32_t> make_tiles() {
  std::vector<std::uint32_t> all(kMaterials * kTileLines * kTexelStride);
  for (std::size_t m = 0; m < kMaterials; ++m) {
    const Pattern brightness = pattern(static_cast<Material>(m));
    std::vector<double> values;
    for (int y = 0; y < kTileSide; ++y) {
      for (int x = 0; x < kTileSide; ++x) {
        const double value = brightness((x + 0.5) / kTileSide, (y + 0.5) / kTileSide);
        values.push_back(255.0 * std::clamp(value, 0.0, 1.0));
      }
    }
    for (int side = kTileSide; side >= 1; side /= 2) {
      const std::size_t line = m * kTileLines + static_cast<std::size_t>(level_line(side));
      pack(values, side, all.data() + line * kTexelStride);
      if (side > 1) values = halved(values, side);
    }
  }
  return all;
}

}  // namespace

const MaterialSpec& spec(Material material) { return kSpecs[static_cast<std::size_t>(material)]; }

const std::vector<std::uint32_t>& tiles() {
  static const std::vector<std::uint32_t> all = make_tiles();
  return all;
}

double sample(Material material, int level, double u, double v) {
  const int side = kTileSide >> level;
  const double x = wrapped(u) * side;
  const double y = wrapped(v) * side;
  const int x0 = std::min(static_cast<int>(x), side - 1);
  const int y0 = std::min(static_cast<int>(y), side - 1);
  const int line = static_cast<int>(material) * kTileLines + level_line(side) + x0;
  const int at = line * kTexelStride + y0;
  const std::uint32_t texel = tiles()[static_cast<std::size_t>(at)];
  const auto byte = [&](unsigned i) { return static_cast<double>(texel >> (8U * i) & 255U); };
  const double low = byte(0) + (x - x0) * (byte(1) - byte(0));
  const double high = byte(2) + (x - x0) * (byte(3) - byte(2));
  return low + (y - y0) * (high - low);
}

}  // namespace threewe::sim::view
