#include "sim/renderer/light.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/numbers.hpp"

namespace threewe::sim::view {
namespace {

using scene::Solid;

// Light at the corners of the cells.
class Grid {
 public:
  explicit Grid(std::span<const VisibleSolid> solids) {
    constexpr double kMargin = 0.5;  // [m]
    Vec2 low{kInfinity, kInfinity};
    Vec2 high{-kInfinity, -kInfinity};
    for (const VisibleSolid& visible : solids) {
      const auto [a, b] = scene::bounds(visible.solid);
      low = {std::min(low.x, a.x), std::min(low.y, a.y)};
      high = {std::max(high.x, b.x), std::max(high.y, b.y)};
    }
    origin_ = low - Vec2{kMargin, kMargin};
    width_ = static_cast<int>((high.x - low.x + 2.0 * kMargin) / FloorLight::kCell) + 2;
    height_ = static_cast<int>((high.y - low.y + 2.0 * kMargin) / FloorLight::kCell) + 2;
    light_.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), 1.0);
  }

  // Changes the light at all points of a rectangle by `change(point, light)`.
  template <class Change>
  void for_each(Vec2 low, Vec2 high, Change change) {
    const auto index = [](double x) { return static_cast<int>(std::floor(x / FloorLight::kCell)); };
    const int last_x = std::min(index(high.x - origin_.x), width_ - 1);
    const int last_y = std::min(index(high.y - origin_.y), height_ - 1);
    for (int y = std::max(index(low.y - origin_.y), 0); y <= last_y; ++y) {
      for (int x = std::max(index(low.x - origin_.x), 0); x <= last_x; ++x) {
        change(origin_ + FloorLight::kCell * Vec2{static_cast<double>(x), static_cast<double>(y)}, at(x, y));
      }
    }
  }

  FloorLight pack() {
    FloorLight packed{
        origin_, width_, height_, static_cast<int>(std::bit_width(static_cast<unsigned>(width_ - 1))), {}};
    const auto byte = [&](int x, int y) {
      const double light = at(std::min(x, width_ - 1), std::min(y, height_ - 1));
      return static_cast<std::uint32_t>(std::lround(255.0 / FloorLight::kBrightest * light));
    };
    packed.cells.resize(static_cast<std::size_t>(height_) << static_cast<unsigned>(packed.line_bits));
    for (int y = 0; y < height_; ++y) {
      for (int x = 0; x < width_; ++x) {
        packed.cells[packed.index(x, y)] =
            byte(x, y) | byte(x + 1, y) << 8U | byte(x, y + 1) << 16U | byte(x + 1, y + 1) << 24U;
      }
    }
    return packed;
  }

 private:
  double& at(int x, int y) {
    return light_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x)];
  }
  Vec2 origin_;
  int width_ = 0;
  int height_ = 0;
  std::vector<double> light_;
};

// Little light comes to the floor beside what stands on it, or hangs low above it.
void darken_around(const Solid& solid, Grid& grid) {
  constexpr double kReach = 0.45;   // [m]
  constexpr double kHighest = 0.9;  // [m], what hangs higher leaves no mark
  constexpr double kDarkest = 0.48;
  const double weight = kDarkest * (1.0 - solid.z_min / kHighest);
  if (weight <= 0.0) return;
  const auto [a, b] = scene::bounds(solid);
  const Vec2 reach{kReach, kReach};
  grid.for_each(a - reach, b + reach, [&](Vec2 point, double& light) {
    const double near = std::max(0.0, 1.0 - scene::distance_to(solid, point) / kReach);
    light = std::min(light, 1.0 - weight * near * near);
  });
}

// A shadow is the solid's outline, moved away from the sun the further the higher it is.
void cast_shadow(const Solid& solid, Grid& grid) {
  constexpr double kShadow = 0.66;
  constexpr double kStep = 0.25;  // [m] of height
  const int steps = static_cast<int>((solid.z_max - solid.z_min) / kStep) + 1;
  const auto [a, b] = scene::bounds(solid);
  for (int i = 0; i <= steps; ++i) {
    const double z = solid.z_min + (solid.z_max - solid.z_min) * i / steps;
    const Vec2 shift = (-z / kSunSlope) * kSunward;
    grid.for_each(a + shift, b + shift, [&](Vec2 point, double& light) {
      if (scene::distance_to(solid, point - shift) == 0.0) light = std::min(light, kShadow);
    });
  }
}

void let_sun_in(const SunPatch& patch, Grid& grid) {
  constexpr double kSunlit = 1.32;
  Solid outline;
  outline.corners = patch.corners;
  const auto [a, b] = scene::bounds(outline);
  grid.for_each(a, b, [&](Vec2 point, double& light) {
    if (scene::distance_to(outline, point) == 0.0) light *= kSunlit;
  });
}

}  // namespace

double FloorLight::at(Vec2 point) const {
  const double x = std::clamp((point.x - origin.x) / kCell, 0.0, width - 1.0);
  const double y = std::clamp((point.y - origin.y) / kCell, 0.0, height - 1.0);
  const int x0 = static_cast<int>(x);
  const int y0 = static_cast<int>(y);
  const std::uint32_t cell = cells[index(x0, y0)];
  const auto byte = [&](unsigned i) { return static_cast<double>(cell >> (8U * i) & 255U); };
  const double low = byte(0) + (x - x0) * (byte(1) - byte(0));
  const double high = byte(2) + (x - x0) * (byte(3) - byte(2));
  return kBrightest / 255.0 * (low + (y - y0) * (high - low));
}

FloorLight make_light(std::span<const VisibleSolid> solids, bool is_open, std::span<const SunPatch> sun) {
  if (solids.empty()) return {};
  Grid grid(solids);
  for (const VisibleSolid& visible : solids) {
    darken_around(visible.solid, grid);
    if (is_open) cast_shadow(visible.solid, grid);
  }
  for (const SunPatch& patch : sun) let_sun_in(patch, grid);
  return grid.pack();
}

}  // namespace threewe::sim::view
