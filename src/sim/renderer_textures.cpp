// Every tile is made when it is first needed, from numbers that are the same everywhere.
#include "sim/renderer_textures.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "threewe/core/exact.hpp"
#include "threewe/core/rng.hpp"

namespace threewe::sim::view {
namespace {

constexpr std::array<MaterialSpec, kMaterials> kSpecs = {{
    {1.28, 0.80F, 1.08F},  // floor_wood
    {0.80, 0.76F, 1.04F},  // floor_tile
    {0.64, 0.82F, 1.12F},  // floor_carpet
    {2.00, 0.88F, 1.08F},  // floor_concrete
    {1.60, 0.92F, 1.06F},  // floor_vinyl
    {1.00, 0.97F, 1.02F},  // paint
    {1.00, 0.98F, 1.01F},  // trim
    {2.40, 0.86F, 1.16F},  // ceiling
    {1.00, 0.00F, 1.00F},  // sky
    {0.80, 0.84F, 1.10F},  // wood
    {0.50, 0.93F, 1.06F},  // metal
    {0.60, 0.97F, 1.03F},  // plastic
    {0.18, 0.88F, 1.08F},  // fabric
    {0.40, 0.45F, 1.25F},  // leaf
    {0.50, 0.94F, 1.06F},  // ceramic
    {1.00, 0.92F, 1.08F},  // glass
    {0.70, 0.86F, 1.08F},  // stone
    {0.36, 0.62F, 1.12F},  // paper
}};

double smooth(double t) { return t * t * (3.0 - 2.0 * t); }
double wrapped(double x) { return x - std::floor(x); }

// Smooth noise in [0, 1] that repeats after one tile, with `x_cells` by `y_cells` random values.
class Noise {
 public:
  Noise(std::uint64_t seed, int x_cells, int y_cells) : x_cells_(x_cells), y_cells_(y_cells) {
    const RngKey key{.seed = seed, .stream = Stream::camera};
    for (int i = 0; i < x_cells * y_cells; ++i) values_.push_back(uniform(key, static_cast<std::uint64_t>(i)));
  }
  double operator()(double x, double y) const {
    const double fx = wrapped(x) * x_cells_;
    const double fy = wrapped(y) * y_cells_;
    const int x0 = static_cast<int>(fx) % x_cells_;
    const int y0 = static_cast<int>(fy) % y_cells_;
    const double tx = smooth(fx - std::floor(fx));
    const double ty = smooth(fy - std::floor(fy));
    const double low = at(x0, y0) + tx * (at(x0 + 1, y0) - at(x0, y0));
    const double high = at(x0, y0 + 1) + tx * (at(x0 + 1, y0 + 1) - at(x0, y0 + 1));
    return low + ty * (high - low);
  }

 private:
  double at(int x, int y) const {
    const int i = (y % y_cells_) * x_cells_ + x % x_cells_;
    return values_[static_cast<std::size_t>(i)];
  }
  int x_cells_;
  int y_cells_;
  std::vector<double> values_;
};

// How far x in [0, 1) is from the joints between `count` equal pieces [pieces].
double from_joint(double x, int count) {
  const double t = wrapped(x * count);
  return std::min(t, 1.0 - t);
}

using Pattern = std::function<double(double, double)>;  // brightness at (x, y) in the unit square

// Boards along x, each of its own tone, with grain along it.
Pattern boards(std::uint64_t seed, int rows, double joint) {
  const Noise tone(seed, 2, rows);
  const Noise grain(seed + 1, 4, 64);
  const Noise fine(seed + 2, 8, 128);
  const RngKey key{.seed = seed + 3, .stream = Stream::camera};
  return [=](double x, double y) {
    const auto row = static_cast<std::uint64_t>(wrapped(y) * rows);
    const double shift = uniform(key, row);
    const auto board = static_cast<std::uint64_t>(wrapped(x + shift) * 2.0);
    const double own = uniform(key, row * 2 + board, 1);
    const double value = 0.50 + 0.30 * (own - 0.5) + 0.28 * (grain(x + own, y) - 0.5) + 0.18 * (fine(x, y) - 0.5);
    const bool gap = from_joint(y, rows) < joint * rows || from_joint(x + shift, 2) < joint * 2;
    return gap ? 0.12 : value;
  };
}

// Wood in one piece, its grain along x.
Pattern grain(std::uint64_t seed) {
  const Noise waves(seed, 3, 14);
  const Noise lines(seed + 1, 3, 48);
  const Noise fine(seed + 2, 10, 128);
  return [=](double x, double y) {
    const double bend = 0.03 * waves(x, y);
    return 0.5 + 0.5 * (lines(x, y + bend) - 0.5) + 0.35 * (waves(x, y + bend) - 0.5) + 0.2 * (fine(x, y) - 0.5);
  };
}

Pattern tiles_of_stone(std::uint64_t seed, int count, double joint) {
  const RngKey key{.seed = seed, .stream = Stream::camera};
  const Noise cloud(seed + 1, 12, 12);
  return [=](double x, double y) {
    if (from_joint(x, count) < joint * count || from_joint(y, count) < joint * count) return 0.15;
    const auto i = static_cast<std::uint64_t>(wrapped(x) * count) * 8 + static_cast<std::uint64_t>(wrapped(y) * count);
    return 0.78 + 0.16 * (uniform(key, i) - 0.5) + 0.16 * (cloud(x, y) - 0.5);
  };
}

Pattern clouds(std::uint64_t seed, int coarse, int fine, double fine_share) {
  const Noise large(seed, coarse, coarse);
  const Noise small(seed + 1, fine, fine);
  return [=](double x, double y) { return (1.0 - fine_share) * large(x, y) + fine_share * small(x, y); };
}

// Panels of light in a grid of plates.
Pattern ceiling_plates() {
  return [](double x, double y) {
    const bool lamp = x >= 0.25 && x < 0.5 && y >= 0.125 && y < 0.625;
    if (lamp) return from_joint(x, 4) < 0.04 || from_joint(y - 0.125, 2) < 0.02 ? 0.35 : 1.0;
    return from_joint(x, 4) < 0.04 || from_joint(y, 4) < 0.04 ? 0.15 : 0.36;
  };
}

Pattern weave(std::uint64_t seed) {
  const Noise thread(seed, 64, 64);
  return [=](double x, double y) {
    const bool over = (static_cast<int>(x * 32) + static_cast<int>(y * 32)) % 2 == 0;
    return 0.5 + (over ? 0.10 : -0.10) + 0.5 * (thread(x, y) - 0.5);
  };
}

Pattern leaves(std::uint64_t seed) {
  const Noise coarse(seed, 9, 11);
  const Noise fine(seed + 1, 26, 30);
  return [=](double x, double y) {
    const double value = 0.5 * coarse(x, y) + 0.5 * fine(x, y);
    return std::clamp(2.2 * (value - 0.5) + 0.5, 0.0, 1.0);
  };
}

// Backs of books, or sheets, side by side.
Pattern spines(std::uint64_t seed) {
  const RngKey key{.seed = seed, .stream = Stream::camera};
  return [=](double x, double y) {
    const auto book = static_cast<std::uint64_t>(wrapped(x) * 10);
    if (from_joint(x, 10) < 0.07) return 0.05;
    const double band = wrapped(y * 2 + uniform(key, book, 1));
    return std::clamp(0.25 + 0.75 * uniform(key, book) + (band < 0.08 ? 0.2 : 0.0), 0.0, 1.0);
  };
}

Pattern brushed(std::uint64_t seed) {
  const Noise lines(seed, 2, 96);
  return [=](double x, double y) { return 0.25 + 0.5 * lines(x, y); };
}

std::array<Pattern, kMaterials> patterns() {
  return {boards(100, 8, 0.003),
          tiles_of_stone(110, 2, 0.004),
          clouds(120, 12, 100, 0.75),
          clouds(130, 6, 40, 0.35),
          clouds(140, 5, 64, 0.55),
          clouds(150, 8, 64, 0.5),
          clouds(160, 4, 32, 0.5),
          ceiling_plates(),
          [](double, double) { return 0.0; },
          grain(200),
          brushed(210),
          clouds(220, 4, 64, 0.3),
          weave(230),
          leaves(240),
          clouds(250, 4, 32, 0.3),
          clouds(260, 3, 8, 0.3),
          clouds(270, 12, 60, 0.5),
          spines(280)};
}

// One level from brightnesses 0 to 255.
void pack(const std::vector<double>& values, int side, std::uint32_t* texels) {
  const auto byte = [&](int x, int y) {
    const int i = (y % side) * side + x % side;
    const double value = values[static_cast<std::size_t>(i)];
    return static_cast<std::uint32_t>(std::lround(std::clamp(value, 0.0, 255.0)));
  };
  for (int y = 0; y <= side; ++y) {
    for (int x = 0; x <= side; ++x) {
      texels[y * kTexelStride + x] =
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
  std::vector<std::uint32_t> all(kMaterials * kTileRows * kTexelStride);
  const auto all_patterns = patterns();
  for (std::size_t m = 0; m < kMaterials; ++m) {
    std::vector<double> values;
    for (int y = 0; y < kTileSide; ++y) {
      for (int x = 0; x < kTileSide; ++x) {
        const double value = all_patterns[m]((x + 0.5) / kTileSide, (y + 0.5) / kTileSide);
        values.push_back(255.0 * std::clamp(value, 0.0, 1.0));
      }
    }
    for (int side = kTileSide; side >= 1; side /= 2) {
      const std::size_t row = m * kTileRows + static_cast<std::size_t>(level_row(side));
      pack(values, side, all.data() + row * kTexelStride);
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
  const int row = static_cast<int>(material) * kTileRows + level_row(side) + y0;
  const int at = row * kTexelStride + x0;
  const std::uint32_t texel = tiles()[static_cast<std::size_t>(at)];
  const auto byte = [&](unsigned i) { return static_cast<double>(texel >> (8U * i) & 255U); };
  const double low = byte(0) + (x - x0) * (byte(1) - byte(0));
  const double high = byte(2) + (x - x0) * (byte(3) - byte(2));
  return low + (y - y0) * (high - low);
}

}  // namespace threewe::sim::view
