// Every tile is made when it is first needed, from numbers that are the same everywhere.
#include "sim/renderer/textures.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "core/rng.hpp"
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

// Brightness 0 to 1 at the middles of texels, `side` by `side`; it repeats.
class Level {
 public:
  explicit Level(int side) : side_(side), values_(static_cast<std::size_t>(side) * static_cast<std::size_t>(side)) {}

  int side() const { return side_; }
  double& at(int x, int y) { return values_[index(x, y)]; }
  double at(int x, int y) const { return values_[index(x, y)]; }

 private:
  std::size_t index(int x, int y) const {
    const auto wrap = [&](int i) { return static_cast<std::size_t>(i & (side_ - 1)); };
    return wrap(y) * static_cast<std::size_t>(side_) + wrap(x);
  }
  int side_;
  std::vector<double> values_;
};

template <class Value>
Level make_level(int side, Value value) {
  Level level(side);
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) level.at(x, y) = value(x, y);
  }
  return level;
}

Level halved(const Level& fine) {
  return make_level(fine.side() / 2, [&](int x, int y) {
    return 0.25 * (fine.at(2 * x, 2 * y) + fine.at(2 * x + 1, 2 * y) + fine.at(2 * x, 2 * y + 1) +
                   fine.at(2 * x + 1, 2 * y + 1));
  });
}

// Interpolated: texels that are seen from close by should not look like tiles.
Level doubled(const Level& coarse) {
  return make_level(2 * coarse.side(), [&](int x, int y) {
    const int near_x = x / 2;
    const int near_y = y / 2;
    const int far_x = near_x + (x % 2 ? 1 : -1);
    const int far_y = near_y + (y % 2 ? 1 : -1);
    const double near = 0.75 * coarse.at(near_x, near_y) + 0.25 * coarse.at(far_x, near_y);
    const double far = 0.75 * coarse.at(near_x, far_y) + 0.25 * coarse.at(far_x, far_y);
    return 0.75 * near + 0.25 * far;
  });
}

void pack(const Level& level, const MaterialSpec& material, std::uint8_t* texels) {
  for (int x = 0; x < level.side(); ++x) {
    for (int y = 0; y < level.side(); ++y) {
      const auto dark = static_cast<double>(material.dark);
      const double bright = dark + (static_cast<double>(material.light) - dark) * level.at(x, y);
      texels[x * texel_stride(level.side()) + y] =
          static_cast<std::uint8_t>(std::lround(static_cast<double>(kTexelOne) * bright));
    }
  }
}

std::vector<std::uint8_t> make_tiles() {
  constexpr int kPatternSide = kTileSide / 2;  // patterns are no finer than this
  std::vector<std::uint8_t> all(kOneTexel + 1);
  for (std::size_t m = 0; m < kMaterials; ++m) {
    const Pattern brightness = pattern(static_cast<Material>(m));
    const auto put = [&](const Level& level) {
      pack(level, kSpecs[m], all.data() + m * kTileSize + static_cast<std::size_t>(first_texel(level.side())));
    };
    Level level = make_level(kPatternSide, [&](int x, int y) {
      return std::clamp(brightness((x + 0.5) / kPatternSide, (y + 0.5) / kPatternSide), 0.0, 1.0);
    });
    put(doubled(level));
    for (; level.side() > 1; level = halved(level)) put(level);
    put(level);
  }
  all[kOneTexel] = static_cast<std::uint8_t>(kTexelOne);
  return all;
}

// What a material's surfaces may wear instead; nothing for one that keeps what it has.
std::span<const Material> worn_by(Material material) {
  using enum Material;
  static constexpr std::array kFloors = {floor_wood,  floor_tile,   floor_carpet, floor_concrete, floor_vinyl,
                                         floor_grass, floor_gravel, floor_paving, floor_asphalt};
  static constexpr std::array kWalls = {shading, brick, stone, floor_concrete, floor_tile, fabric};
  static constexpr std::array kCeilings = {ceiling, roof, shading, floor_vinyl};
  static constexpr std::array kThings = {wood,  metal, plastic, fabric,    leaf,  ceramic,
                                         glass, stone, paper,   cardboard, rubber};
  if (material == shading || material == brick) return kWalls;
  if (material == ceiling || material == roof) return kCeilings;
  if (std::ranges::find(kFloors, material) != kFloors.end()) return kFloors;
  if (std::ranges::find(kThings, material) != kThings.end()) return kThings;
  return {};
}

}  // namespace

Material pattern_of(std::uint32_t texture, Material material) {
  const std::span<const Material> worn = worn_by(material);
  if (texture == 0 || worn.empty()) return material;
  const RngKey key{.seed = texture, .stream = Stream::scene};
  return worn[random_bits(key, static_cast<std::uint64_t>(material), 1)[0] % worn.size()];
}

std::array<Material, kMaterials> patterns_of(std::uint32_t texture) {
  std::array<Material, kMaterials> patterns;
  for (std::size_t m = 0; m < kMaterials; ++m) patterns[m] = pattern_of(texture, static_cast<Material>(m));
  return patterns;
}

const MaterialSpec& spec(Material material) { return kSpecs[static_cast<std::size_t>(material)]; }

const std::vector<std::uint8_t>& tiles() {
  static const std::vector<std::uint8_t> all = make_tiles();
  return all;
}

double sample(Material material, int level, double u, double v) {
  const int side = kTileSide >> level;
  const auto texel = [&](double tiles) { return std::min(static_cast<int>(wrapped(tiles) * side), side - 1); };
  const int first = static_cast<int>(material) * kTileSize + first_texel(side);
  const int at = first + texel(u) * texel_stride(side) + texel(v);
  return view::tiles()[static_cast<std::size_t>(at)] / static_cast<double>(kTexelOne);
}

}  // namespace threewe::sim::view
