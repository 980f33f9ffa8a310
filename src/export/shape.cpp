#include "export/shape.hpp"

#include <algorithm>
#include <array>

namespace threewe::exports {
namespace {

struct MaterialColor {
  std::string_view material;
  Color color;
};

// Of objects, then of floors. Both may be of wood: the object's is the browner.
constexpr std::array<MaterialColor, 18> kColors = {{{"wood", {0.77, 0.60, 0.42}},
                                                    {"metal", {0.59, 0.60, 0.62}},
                                                    {"plastic", {0.38, 0.46, 0.53}},
                                                    {"fabric", {0.34, 0.43, 0.52}},
                                                    {"leaf", {0.33, 0.50, 0.28}},
                                                    {"ceramic", {0.75, 0.44, 0.31}},
                                                    {"glass", {0.64, 0.75, 0.75}},
                                                    {"stone", {0.74, 0.72, 0.69}},
                                                    {"paper", {0.78, 0.63, 0.45}},
                                                    {"cardboard", {0.77, 0.61, 0.43}},
                                                    {"tile", {0.82, 0.80, 0.77}},
                                                    {"carpet", {0.45, 0.49, 0.53}},
                                                    {"concrete", {0.63, 0.63, 0.61}},
                                                    {"vinyl", {0.69, 0.70, 0.67}},
                                                    {"grass", {0.48, 0.58, 0.29}},
                                                    {"gravel", {0.70, 0.66, 0.59}},
                                                    {"paving", {0.73, 0.70, 0.65}},
                                                    {"asphalt", {0.43, 0.44, 0.45}}}};

}  // namespace

Color color_of(std::string_view material) {
  constexpr std::size_t kPlastic = 2;
  const auto* const found = std::ranges::find(kColors, material, &MaterialColor::material);
  return found == kColors.end() ? kColors[kPlastic].color : found->color;
}

}  // namespace threewe::exports
