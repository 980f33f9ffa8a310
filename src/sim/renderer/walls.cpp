#include "sim/renderer/walls.hpp"

#include <algorithm>
#include <cmath>

#include "core/exact.hpp"
#include "core/rng.hpp"
#include "sim/renderer/sides.hpp"
#include "sim/renderer/textures.hpp"

namespace threewe::sim::view {
namespace {

using scene::Solid;

constexpr double kSill = 0.85;  // [m]

// The same room in front of all of a piece of wall; null if there is none.
const scene::Room* room_before(const scene::Scene& scene, const Side& side, double begin, double end, double gap) {
  const auto room_at = [&](double along) { return scene.room_at(side.corner + along * side.axis + gap * side.normal); };
  const scene::Room* room = room_at(begin);
  return room && room_at(end) == room ? room : nullptr;
}

// Light that falls through a window into a room.
void let_sun_in(const Side& side, const Decor& window, const scene::Room& room, std::vector<SunPatch>& sun) {
  const double facing = -dot(side.normal, kSunward);  // the side looks into the room, the sun comes from behind it
  if (facing < 0.2) return;
  const auto on_floor = [&](double along, double height) {
    const Vec2 point = side.corner + along * side.axis - (height / kSunSlope) * kSunward;
    return Vec2{std::clamp(point.x, room.min.x, room.max.x), std::clamp(point.y, room.min.y, room.max.y)};
  };
  sun.push_back({{on_floor(window.begin, window.low), on_floor(window.begin, window.high),
                  on_floor(window.end, window.high), on_floor(window.end, window.low)}});
}

void hang_pictures(const scene::Scene& scene, const Side& side, int face, std::uint64_t key, std::vector<Decor>& all) {
  constexpr double kSpacing = 2.6;  // [m]
  constexpr double kLow = 1.05;     // [m]
  const double size = spec(Material::picture).tile_size;
  const RngKey random{.seed = key, .stream = Stream::camera};
  const int count = static_cast<int>(side.length / kSpacing);
  for (int i = 0; i < count; ++i) {
    const double begin = side.length * (i + 0.5) / count - 0.5 * size;
    const auto draw = random_bits(random, static_cast<std::uint64_t>(i))[0];
    if (draw % 3 == 0 || !room_before(scene, side, begin, begin + size, 0.2)) continue;
    const Colour tint = palette(palette_of("fabric")).tints[draw / 3 % 8];
    all.push_back({face, begin, begin + size, kLow, kLow + size, SurfaceMaterial{Material::picture, tint}});
  }
}

void set_windows(const scene::Scene& scene, const Side& side, int face, WallDecor& decor) {
  constexpr double kSpacing = 2.2;  // [m]
  const double size = spec(Material::window).tile_size;
  const int count = static_cast<int>(side.length / kSpacing);
  for (int i = 0; i < count; ++i) {
    const double begin = side.length * (i + 0.5) / count - 0.5 * size;
    const scene::Room* room = room_before(scene, side, begin, begin + size, 0.2);
    if (!room) continue;
    const Decor window{face, begin, begin + size, kSill, kSill + size, SurfaceMaterial{Material::window, kDaylight}};
    decor.all.push_back(window);
    let_sun_in(side, window, *room, decor.sun);
  }
}

}  // namespace

WallDecor decorate(const scene::Scene& scene) {
  constexpr double kLowest = 2.3;   // [m], walls lower than this stay bare
  constexpr double kBeyond = 0.35;  // [m] behind the back of a wall
  WallDecor decor;
  for (std::size_t i = 0; i < scene.walls.size(); ++i) {
    decor.first.push_back(decor.all.size());
    const scene::Wall& wall = scene.walls[i];
    if (!scene.ceiling || wall.height < kLowest) continue;
    const Sides sides = make_sides({scene::solid_of(wall), Material::shading, kWallId}, false);
    for (const int face : {0, 2}) {  // the long sides
      const Side& side = sides[static_cast<std::size_t>(face)];
      const Vec2 behind = side.corner + 0.5 * side.length * side.axis - (wall.thickness + kBeyond) * side.normal;
      if (scene.room_at(behind)) {
        hang_pictures(scene, side, face, 4 * i + static_cast<std::size_t>(face), decor.all);
      } else {
        set_windows(scene, side, face, decor);
      }
    }
  }
  decor.first.push_back(decor.all.size());
  for (std::size_t i = 0; i < decor.all.size(); ++i) decor.all[i].detail = 0.125F * static_cast<float>(1 + 5 * i % 8);
  return decor;
}

std::vector<Solid> lintels(const scene::Scene& scene) {
  constexpr double kNear = 1e-6;  // [m]
  std::vector<Solid> all;
  for (const scene::Door& door : scene.doors) {
    // the piece of wall that ends where the doorway begins tells its direction
    for (const scene::Wall& wall : scene.walls) {
      const bool at_b = std::fabs(distance(wall.b, door.center) - 0.5 * door.width) < kNear;
      const bool at_a = std::fabs(distance(wall.a, door.center) - 0.5 * door.width) < kNear;
      const Vec2 along = wall.b - wall.a;
      const Vec2 across = door.center - (at_b ? wall.b : wall.a);
      const bool in_line = std::fabs(cross(along, across)) < kNear * norm(along);
      if ((!at_a && !at_b) || !in_line || wall.height <= kDoorHeight) continue;
      Solid lintel =
          scene::make_box({door.center.x, door.center.y, exact::atan2(along.y, along.x)}, door.width, wall.thickness);
      lintel.z_min = kDoorHeight;
      lintel.z_max = wall.height;
      all.push_back(lintel);
      break;
    }
  }
  return all;
}

}  // namespace threewe::sim::view
