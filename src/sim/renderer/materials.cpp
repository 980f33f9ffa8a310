#include "sim/renderer/materials.hpp"

#include <algorithm>
#include <cmath>

#include "core/exact.hpp"
#include "sim/renderer/light.hpp"
#include "sim/renderer/textures.hpp"

namespace threewe::sim::view {
namespace {

constexpr std::array kWallColours = {rgb(232, 228, 218), rgb(208, 218, 214), rgb(226, 214, 196), rgb(212, 220, 228),
                                     rgb(224, 218, 206), rgb(200, 212, 196), rgb(230, 220, 208), rgb(206, 212, 222)};
constexpr Colour kCeiling = rgb(226, 226, 222);
constexpr Colour kRoof = rgb(150, 154, 158);
constexpr Colour kCloud = rgb(252, 252, 252);

struct FloorMaterial {
  std::string_view name;
  Material material;
  Colour colour;
};
constexpr std::array<FloorMaterial, 9> kFloors = {{{"wood", Material::floor_wood, rgb(184, 150, 114)},
                                                   {"tile", Material::floor_tile, rgb(208, 204, 196)},
                                                   {"carpet", Material::floor_carpet, rgb(116, 124, 134)},
                                                   {"concrete", Material::floor_concrete, rgb(160, 160, 156)},
                                                   {"vinyl", Material::floor_vinyl, rgb(176, 178, 170)},
                                                   {"grass", Material::floor_grass, rgb(122, 148, 74)},
                                                   {"gravel", Material::floor_gravel, rgb(178, 168, 150)},
                                                   {"paving", Material::floor_paving, rgb(186, 178, 166)},
                                                   {"asphalt", Material::floor_asphalt, rgb(110, 112, 116)}}};

constexpr std::array<Palette, 10> kPalettes = {{
    {"wood",
     Material::wood,
     {rgb(196, 154, 108), rgb(222, 190, 148), rgb(140, 96, 62), rgb(104, 72, 52), rgb(176, 128, 84), rgb(232, 226, 214),
      rgb(120, 116, 110), rgb(206, 170, 120)}},
    {"metal",
     Material::metal,
     {rgb(150, 154, 158), rgb(196, 198, 200), rgb(84, 88, 94), rgb(218, 220, 220), rgb(112, 122, 130),
      rgb(92, 106, 112), rgb(170, 164, 152), rgb(60, 64, 68)}},
    {"plastic",
     Material::plastic,
     {rgb(62, 66, 72), rgb(220, 218, 212), rgb(96, 118, 134), rgb(172, 92, 76), rgb(126, 142, 110), rgb(206, 172, 96),
      rgb(140, 144, 150), rgb(44, 48, 54)}},
    {"fabric",
     Material::fabric,
     {rgb(86, 110, 132), rgb(178, 120, 88), rgb(120, 132, 104), rgb(196, 182, 158), rgb(96, 92, 100), rgb(152, 84, 82),
      rgb(70, 96, 98), rgb(204, 164, 92)}},
    {"leaf",
     Material::leaf,
     {rgb(84, 128, 72), rgb(104, 144, 80), rgb(66, 110, 74), rgb(122, 148, 88), rgb(78, 120, 92), rgb(96, 132, 64),
      rgb(112, 138, 96), rgb(72, 116, 60)}},
    {"ceramic",
     Material::ceramic,
     {rgb(190, 112, 80), rgb(228, 224, 214), rgb(96, 104, 112), rgb(168, 150, 130), rgb(120, 138, 140),
      rgb(206, 186, 156), rgb(70, 74, 80), rgb(150, 96, 76)}},
    {"glass",
     Material::glass,
     {rgb(164, 190, 192), rgb(178, 200, 206), rgb(150, 176, 172), rgb(188, 202, 200), rgb(140, 164, 172),
      rgb(170, 186, 180), rgb(196, 210, 212), rgb(156, 180, 188)}},
    {"stone",
     Material::stone,
     {rgb(188, 184, 176), rgb(120, 120, 122), rgb(214, 208, 198), rgb(94, 96, 98), rgb(170, 162, 150),
      rgb(202, 200, 196), rgb(146, 140, 134), rgb(224, 222, 216)}},
    {"paper",
     Material::paper,
     {rgb(198, 160, 116), rgb(170, 110, 90), rgb(110, 130, 150), rgb(206, 190, 160), rgb(134, 148, 118),
      rgb(182, 150, 96), rgb(120, 104, 110), rgb(160, 176, 180)}},
    {"cardboard",
     Material::cardboard,
     {rgb(196, 156, 110), rgb(182, 142, 98), rgb(206, 170, 126), rgb(170, 132, 92), rgb(212, 180, 140),
      rgb(188, 150, 112), rgb(176, 136, 90), rgb(222, 206, 184)}},
}};

float lerp(float a, float b, float t) { return a + t * (b - a); }
Colour lerp(Colour a, Colour b, float t) { return {lerp(a.b, b.b, t), lerp(a.g, b.g, t), lerp(a.r, b.r, t)}; }
Colour scaled(Colour c, float by) { return {by * c.b, by * c.g, by * c.r}; }

}  // namespace

int palette_of(std::string_view material) {
  constexpr int kPlastic = 2;
  const auto found = std::ranges::find(kPalettes, material, &Palette::name);
  return found == kPalettes.end() ? kPlastic : static_cast<int>(found - kPalettes.begin());
}

const Palette& palette(int index) { return kPalettes[static_cast<std::size_t>(index)]; }

Colour wall_colour(std::size_t room) { return kWallColours[room % kWallColours.size()]; }

SurfaceMaterial floor_material(std::string_view name, float light) {
  constexpr std::size_t kConcrete = 3;
  const auto found = std::ranges::find(kFloors, name, &FloorMaterial::name);
  const FloorMaterial& shading = found == kFloors.end() ? kFloors[kConcrete] : *found;
  return {shading.material, shading.colour, light};
}

SurfaceMaterial ceiling_material(double height) {
  constexpr double kHall = 3.5;  // [m]
  return height > kHall ? SurfaceMaterial{Material::roof, kRoof} : SurfaceMaterial{Material::ceiling, kCeiling};
}

float side_shade(Vec2 normal) { return static_cast<float>(kShade + kSunShade * dot(normal, kSunward)); }

SurfaceMaterial side_material(const VisibleSolid& visible, Material material, float shade) {
  const scene::Solid& solid = visible.solid;
  SurfaceMaterial look{material, {}, shade};
  const double height = solid.z_max - solid.z_min;
  const double reach = std::min(0.45, height);  // [m]: as high above its lower edge a face is lit in full
  const double foot = 1.0 - 0.22 * std::min(1.0, reach / 0.45);  // how much it is lit there
  const double rise = (1.0 - foot) / reach;
  look.foot = static_cast<float>(foot - rise * solid.z_min);
  look.rise = static_cast<float>(rise);
  return look;
}

SurfaceMaterial skirting_material(Vec2 normal) { return {Material::trim, kTrim, 0.92F * side_shade(normal)}; }

SurfaceMaterial top_material(const VisibleSolid& solid, Colour colour) {
  return solid.id == kWallId ? SurfaceMaterial{Material::trim, kTrim} : SurfaceMaterial{solid.material, colour, 1.06F};
}

SurfaceMaterial bottom_material(const VisibleSolid& solid, Colour colour) {
  return solid.id == kWallId ? SurfaceMaterial{Material::trim, kTrim, 0.78F}
                             : SurfaceMaterial{solid.material, colour, 0.55F};
}

Colour sky_colour(float slope) {
  constexpr Colour kHorizon = rgb(222, 231, 238);
  constexpr Colour kZenith = rgb(88, 142, 204);
  constexpr float kSteepest = 0.9F;
  const float t = std::clamp(slope / kSteepest, 0.0F, 1.0F);
  return lerp(kHorizon, kZenith, t * (2.0F - t));
}

Colour sun_glow(float slope) {
  constexpr Colour kSun = rgb(78, 62, 34);
  const float above = std::max(slope, 0.0F) - 0.3F;
  return scaled(kSun, 1.0F / (1.0F + 6.0F * above * above));
}

float sun_share(Vec2 direction) {
  const double facing = dot(direction, kSunward) / norm(direction);
  const double towards = std::max(0.0, facing);
  return static_cast<float>(towards * towards * towards);
}

SurfaceMaterial cloud_material() { return {Material::sky, kCloud}; }

// A skyline made of waves around the horizon.
double hill_slope(Vec2 direction) {
  const double a = exact::atan2(direction.y, direction.x);
  const double elevation = 0.055 + 0.022 * exact::sin(3.0 * a + 0.7) + 0.014 * exact::sin(7.0 * a + 2.1) +
                           0.005 * exact::sin(19.0 * a) + 0.002 * exact::sin(61.0 * a + 1.3);
  return elevation * norm(direction);
}

float haze(double height, float slope) {
  constexpr double kFar = 90.0;  // [m]: here half of the ground is lost
  const double depth = slope < 0.0F ? height / -static_cast<double>(slope) : 0.0;
  return static_cast<float>(depth / (depth + kFar));
}

}  // namespace threewe::sim::view
