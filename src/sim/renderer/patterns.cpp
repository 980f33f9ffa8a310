// Every pattern is made from numbers that are the same everywhere.
#include "sim/renderer/patterns.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/exact.hpp"
#include "core/rng.hpp"

namespace threewe::sim::view {
namespace {

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
  const Noise boughs(seed, 5, 6);
  const Noise coarse(seed + 1, 16, 18);
  const Noise fine(seed + 2, 48, 52);
  return [=](double x, double y) {
    const double value = 0.35 * boughs(x, y) + 0.35 * coarse(x, y) + 0.30 * fine(x, y);
    return std::clamp(2.4 * (value - 0.5) + 0.55, 0.0, 1.0);
  };
}

// Blades in tufts, with bald spots.
Pattern grass(std::uint64_t seed) {
  const Noise tufts(seed, 7, 7);
  const Noise blades(seed + 1, 128, 40);
  const Noise across(seed + 2, 40, 128);
  return [=](double x, double y) {
    return std::clamp(0.5 + 0.7 * (tufts(x, y) - 0.5) + 0.6 * (blades(x, y) + across(x, y) - 1.0), 0.0, 1.0);
  };
}

// Stones of all tones, dark between them.
Pattern pebbles(std::uint64_t seed, int count) {
  const RngKey key{.seed = seed, .stream = Stream::camera};
  return [=](double x, double y) {
    double nearest = 1.0;
    double tone = 0.0;
    const int column = static_cast<int>(x * count);
    const int row = static_cast<int>(y * count);
    for (int j = row - 1; j <= row + 1; ++j) {
      for (int i = column - 1; i <= column + 1; ++i) {
        const int at = (j + count) % count * count + (i + count) % count;
        const auto cell = static_cast<std::uint64_t>(at);
        const double dx = x * count - (i + uniform(key, cell, 0));
        const double dy = y * count - (j + uniform(key, cell, 1));
        const double away = dx * dx + dy * dy;
        if (away < nearest) tone = uniform(key, cell, 2);
        nearest = std::min(nearest, away);
      }
    }
    return std::clamp(0.30 + 0.60 * tone - 0.55 * nearest + 0.2, 0.0, 1.0);
  };
}

// Slabs or bricks in rows, each shifted by half of one.
Pattern courses(std::uint64_t seed, int columns, int rows, double joint, double contrast) {
  const RngKey key{.seed = seed, .stream = Stream::camera};
  const Noise cloud(seed + 1, 16, 16);
  const Noise fine(seed + 2, 100, 100);
  return [=](double x, double y) {
    const auto row = static_cast<int>(wrapped(y) * rows);
    const double shifted = x + (row % 2 == 0 ? 0.0 : 0.5 / columns);
    if (from_joint(shifted, columns) < joint * columns || from_joint(y, rows) < joint * rows) return 0.22;
    const auto stone =
        static_cast<std::uint64_t>(row * columns) + static_cast<std::uint64_t>(wrapped(shifted) * columns);
    return std::clamp(
        0.66 + contrast * (uniform(key, stone) - 0.5) + 0.18 * (cloud(x, y) - 0.5) + 0.22 * (fine(x, y) - 0.5), 0.0,
        1.0);
  };
}

// Board with a strip of tape around it.
Pattern taped_board(std::uint64_t seed) {
  const Noise fibre(seed, 6, 90);
  const Noise stain(seed + 1, 4, 4);
  return [=](double x, double y) {
    const double tape = x > 0.44 && x < 0.56 ? 0.26 : 0.0;
    const bool fold = from_joint(y, 1) < 0.012;
    return std::clamp(0.5 + tape + 0.2 * (fibre(x, y) - 0.5) + 0.25 * (stain(x, y) - 0.5) - (fold ? 0.3 : 0.0), 0.0,
                      1.0);
  };
}

// Sheets of a hall's roof, with beams below them and rows of skylights.
Pattern roof_sheets() {
  return [](double x, double y) {
    if (from_joint(x, 2) < 0.05) return 0.12;
    if (y > 0.42 && y < 0.58) return 1.0;
    return from_joint(y, 16) < 0.2 ? 0.42 : 0.55;
  };
}

// Two panes in a frame, the sky brighter above than what is below it.
Pattern panes(std::uint64_t seed) {
  const Noise trees(seed, 9, 6);
  return [=](double x, double y) {
    const bool frame = from_joint(x, 1) < 0.05 || from_joint(y, 1) < 0.05 || from_joint(x, 2) < 0.045;
    if (frame) return 0.72;
    const double skyline = 0.30 + 0.16 * trees(x, 0.2);
    return y < skyline ? 0.52 + 0.22 * trees(x, y) : 0.90 + 0.10 * y;
  };
}

// A frame around a few shapes.
Pattern painting(std::uint64_t seed) {
  const Noise shapes(seed, 4, 4);
  const Noise strokes(seed + 1, 12, 60);
  return [=](double x, double y) {
    const double edge = std::min({x, y, 1.0 - x, 1.0 - y});
    if (edge < 0.04) return 0.06;
    if (edge < 0.14) return 0.98;
    const double level = std::floor(4.0 * shapes(x + 0.1 * y, y)) / 4.0;
    return std::clamp(0.25 + 0.75 * level + 0.12 * (strokes(x, y) - 0.5), 0.0, 1.0);
  };
}

// Clouds that leave two thirds of the sky free.
Pattern cumulus(std::uint64_t seed) {
  const Noise large(seed, 4, 4);
  const Noise middle(seed + 1, 11, 11);
  const Noise small(seed + 2, 30, 30);
  return [=](double x, double y) {
    const double value = 0.58 * large(x, y) + 0.28 * middle(x, y) + 0.14 * small(x, y);
    return smooth(std::clamp(4.0 * (value - 0.50), 0.0, 1.0));
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

}  // namespace

Pattern pattern(Material material) {
  switch (material) {
    case Material::floor_wood: return boards(100, 8, 0.003);
    case Material::floor_tile: return tiles_of_stone(110, 2, 0.004);
    case Material::floor_carpet: return clouds(120, 12, 100, 0.75);
    case Material::floor_concrete: return clouds(130, 6, 40, 0.35);
    case Material::floor_vinyl: return clouds(140, 5, 64, 0.55);
    case Material::floor_grass: return grass(300);
    case Material::floor_gravel: return pebbles(310, 28);
    case Material::floor_paving: return courses(320, 2, 4, 0.005, 0.30);
    case Material::floor_asphalt: return clouds(330, 24, 128, 0.8);
    case Material::shading: return clouds(150, 8, 64, 0.5);
    case Material::trim: return clouds(160, 4, 32, 0.5);
    case Material::ceiling: return ceiling_plates();
    case Material::roof: return roof_sheets();
    case Material::sky: return cumulus(170);
    case Material::window: return panes(180);
    case Material::picture: return painting(190);
    case Material::wood: return grain(200);
    case Material::metal: return brushed(210);
    case Material::plastic: return clouds(220, 4, 64, 0.3);
    case Material::fabric: return weave(230);
    case Material::leaf: return leaves(240);
    case Material::ceramic: return clouds(250, 4, 32, 0.3);
    case Material::glass: return clouds(260, 3, 8, 0.3);
    case Material::stone: return clouds(270, 12, 60, 0.5);
    case Material::paper: return spines(280);
    case Material::cardboard: return taped_board(340);
    case Material::brick: return courses(350, 4, 12, 0.006, 0.55);
    case Material::skin: return clouds(360, 3, 12, 0.3);
    case Material::rubber: return clouds(370, 4, 40, 0.5);
  }
  return [](double, double) { return 0.0; };
}

}  // namespace threewe::sim::view
