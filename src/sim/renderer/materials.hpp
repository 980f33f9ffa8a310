// Materials of surfaces: textures, colours, and how light falls on them.
#pragma once

#include <array>
#include <string_view>

#include "sim/renderer.hpp"

namespace threewe::sim::view {

/// Colours as people name them, red first.
constexpr Colour rgb(int r, int g, int b) {
  return {static_cast<float>(b), static_cast<float>(g), static_cast<float>(r)};
}
// those that belong to no room and no object
inline constexpr Colour kTrim = rgb(240, 238, 232);
inline constexpr Colour kOutsideColour = rgb(206, 200, 190);
inline constexpr Colour kBrick = rgb(186, 142, 118);
inline constexpr Colour kDaylight = rgb(226, 238, 246);

/// The faces of a solid: sides 0 to 3 of a box (edge i begins at corner i), one of a disc, top and bottom.
inline constexpr int kTopFace = 4;
inline constexpr int kBottomFace = 5;
inline constexpr int kRoundFace = 6;

/// How a face takes colour from its texture: colour * light * brightness * min(1, foot + rise * z), where brightness is
/// the texture's and z is the height above the floor [m].
struct SurfaceMaterial {
  Material material{};
  Colour colour;
  float light = 1.0F;
  float foot = 1.0F;
  float rise = 0.0F;
};

/// What things of one material may be coloured in.
struct Palette {
  std::string_view name;
  Material material;
  std::array<Colour, 8> tints;
};
/// The palette of a material as scenes name it; that of plastic for a name that it does not know.
int palette_of(std::string_view material);
const Palette& palette(int index);
/// The paint of a scene's i-th room.
Colour wall_colour(std::size_t room);

/// A floor as scenes name it; concrete for a name that it does not know. `light` is 1 for a well lit one.
SurfaceMaterial floor_material(std::string_view name, float light);
/// The ceiling of a room or, high up, the roof of a hall.
SurfaceMaterial ceiling_material(double height);
/// How bright a vertical face is that faces along `normal` (a unit vector of the scene's frame): in all, and of the
/// sun.
inline constexpr double kShade = 0.85;
inline constexpr double kSunShade = 0.15;
float side_shade(Vec2 normal);
/// An upright face of a solid, its colour left open: darker towards its foot.
SurfaceMaterial side_material(const VisibleSolid& solid, Material material, float shade);
SurfaceMaterial skirting_material(Vec2 normal);
SurfaceMaterial top_material(const VisibleSolid& solid, Colour colour);
SurfaceMaterial bottom_material(const VisibleSolid& solid, Colour colour);

/// The sky at a slope above the horizon, z / x of the ray; clouds and hills come on top.
Colour sky_colour(float slope);
/// What the sun adds to it, times `sun_share` of the direction.
Colour sun_glow(float slope);
/// 1 towards the sun, less the further from it. `direction` is of the ray in the scene's frame.
float sun_share(Vec2 direction);
/// What clouds are made of: they cover as much of the sky as their texture is bright.
SurfaceMaterial cloud_material();
/// How high above the eye they are [m].
inline constexpr double kCloudHeight = 150.0;
inline constexpr Colour kHills = rgb(118, 140, 132);
/// How much of the sky hills cover.
inline constexpr float kHillCover = 0.72F;
/// The slope up to which they reach in a direction: z / x of a ray (1, s).
double hill_slope(Vec2 direction);
/// How much of the ground under the sky is lost in haze, at a slope below the horizon.
float haze(double height, float slope);

}  // namespace threewe::sim::view
