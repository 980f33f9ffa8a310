#include "sim/renderer_place.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>

#include <fmt/format.h>

#include "sim/renderer_textures.hpp"
#include "threewe/core/errors.hpp"
#include "threewe/core/rng.hpp"

namespace threewe::sim::view {
namespace {

using scene::Solid;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Colours are written as people name them, red first.
constexpr Colour rgb(int r, int g, int b) {
  return {static_cast<float>(b), static_cast<float>(g), static_cast<float>(r)};
}

constexpr std::array kWallPaints = {rgb(232, 228, 218), rgb(208, 218, 214), rgb(226, 214, 196), rgb(212, 220, 228),
                                    rgb(224, 218, 206), rgb(200, 212, 196), rgb(230, 220, 208), rgb(206, 212, 222)};
constexpr Colour kOutsidePaint = rgb(206, 200, 190);
constexpr Colour kTrim = rgb(240, 238, 232);
constexpr Colour kCeiling = rgb(226, 226, 222);

struct FloorPaint {
  std::string_view name;
  Material material;
  Colour colour;
};
constexpr std::array<FloorPaint, 5> kFloors = {{{"wood", Material::floor_wood, rgb(184, 150, 114)},
                                                {"tile", Material::floor_tile, rgb(208, 204, 196)},
                                                {"carpet", Material::floor_carpet, rgb(116, 124, 134)},
                                                {"concrete", Material::floor_concrete, rgb(160, 160, 156)},
                                                {"vinyl", Material::floor_vinyl, rgb(176, 178, 170)}}};

struct Palette {
  std::string_view name;
  Material material;
  std::array<Colour, 8> tints;
};
constexpr std::array<Palette, 9> kPalettes = {{
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
}};

int palette_of(std::string_view material) {
  const auto found = std::ranges::find(kPalettes, material, &Palette::name);
  return found == kPalettes.end() ? 2 : static_cast<int>(found - kPalettes.begin());
}

Look floor_look(std::string_view name) {
  const auto found = std::ranges::find(kFloors, name, &FloorPaint::name);
  const FloorPaint& paint = found == kFloors.end() ? kFloors[3] : *found;
  return make_look(paint.material, paint.colour, 1.0F);
}

// Under a ceiling are scenes that have rooms and whose walls all end at one height.
double find_ceiling(const scene::Scene& scene) {
  if (scene.rooms.empty() || scene.walls.empty()) return kInfinity;
  const double height = scene.walls.front().height;
  const bool level = std::ranges::all_of(scene.walls, [&](const auto& wall) { return wall.height == height; });
  return level && height >= kDoorHeight ? height : kInfinity;
}

// Light falls off towards what stands on the floor, or hangs low above it.
FloorLight make_light(const std::vector<VisibleSolid>& solids) {
  constexpr double kReach = 0.45;   // [m]
  constexpr double kHighest = 0.9;  // [m], what hangs higher leaves no mark
  constexpr double kDarkest = 0.38;
  FloorLight light;
  if (solids.empty()) return light;
  Vec2 low{kInfinity, kInfinity};
  Vec2 high{-kInfinity, -kInfinity};
  for (const VisibleSolid& visible : solids) {
    const auto [a, b] = scene::bounds(visible.solid);
    low = {std::min(low.x, a.x), std::min(low.y, a.y)};
    high = {std::max(high.x, b.x), std::max(high.y, b.y)};
  }
  light.origin = low - Vec2{kReach, kReach};
  light.width = static_cast<int>((high.x - low.x + 2.0 * kReach) / FloorLight::kCell) + 2;
  light.height = static_cast<int>((high.y - low.y + 2.0 * kReach) / FloorLight::kCell) + 2;

  const auto columns = static_cast<std::size_t>(light.width);
  std::vector<double> bright(columns * static_cast<std::size_t>(light.height), 1.0);
  for (const VisibleSolid& visible : solids) {
    const double weight = kDarkest * (1.0 - visible.solid.z_min / kHighest);
    if (weight <= 0.0) continue;
    const auto [a, b] = scene::bounds(visible.solid);
    const auto index = [](double x) { return static_cast<int>(x / FloorLight::kCell); };
    for (int y = index(a.y - kReach - light.origin.y); y <= index(b.y + kReach - light.origin.y); ++y) {
      for (int x = index(a.x - kReach - light.origin.x); x <= index(b.x + kReach - light.origin.x); ++x) {
        const Vec2 point = light.origin + FloorLight::kCell * Vec2{static_cast<double>(x), static_cast<double>(y)};
        const double near = std::max(0.0, 1.0 - scene::distance_to(visible.solid, point) / kReach);
        double& cell = bright[static_cast<std::size_t>(y) * columns + static_cast<std::size_t>(x)];
        cell = std::min(cell, 1.0 - weight * near * near);
      }
    }
  }

  const auto byte = [&](int x, int y) {
    const auto row = static_cast<std::size_t>(std::min(y, light.height - 1));
    const auto column = static_cast<std::size_t>(std::min(x, light.width - 1));
    return static_cast<std::uint32_t>(std::lround(255.0 * bright[row * columns + column]));
  };
  light.cells.clear();
  for (int y = 0; y < light.height; ++y) {
    for (int x = 0; x < light.width; ++x) {
      light.cells.push_back(byte(x, y) | byte(x + 1, y) << 8U | byte(x, y + 1) << 16U | byte(x + 1, y + 1) << 24U);
    }
  }
  return light;
}

// Walls from floor to ceiling each on their own, all else by what it belongs to.
std::vector<Group> make_groups(const std::vector<VisibleSolid>& solids, double ceiling) {
  std::vector<Group> groups;
  for (std::size_t i = 0; i < solids.size(); ++i) {
    const bool is_full = solids[i].solid.z_min <= 0.0 && solids[i].solid.z_max >= ceiling;
    const bool joins = !is_full && !groups.empty() && !groups.back().is_full && solids[i].id != kWallId &&
                       solids[groups.back().first].id == solids[i].id;
    if (joins) {
      groups.back().last = i + 1;
    } else {
      groups.push_back({i, i + 1, {}, 0.0, is_full});
    }
  }
  for (Group& group : groups) {
    for (std::size_t i = group.first; i < group.last; ++i) {
      group.center = group.center + (1.0 / static_cast<double>(group.last - group.first)) * solids[i].solid.center;
    }
    for (std::size_t i = group.first; i < group.last; ++i) {
      const Solid& solid = solids[i].solid;
      group.radius = std::max(group.radius, distance(solid.center, group.center) + solid.radius);
    }
  }
  return groups;
}

}  // namespace

double FloorLight::at(Vec2 point) const {
  const double x = std::clamp((point.x - origin.x) / kCell, 0.0, width - 1.0);
  const double y = std::clamp((point.y - origin.y) / kCell, 0.0, height - 1.0);
  const auto x0 = static_cast<std::size_t>(x);
  const auto y0 = static_cast<std::size_t>(y);
  const std::uint32_t cell = cells[y0 * static_cast<std::size_t>(width) + x0];
  const auto byte = [&](unsigned i) { return static_cast<double>(cell >> (8U * i) & 255U); };
  const double low = byte(0) + (x - static_cast<double>(x0)) * (byte(1) - byte(0));
  const double high = byte(2) + (x - static_cast<double>(x0)) * (byte(3) - byte(2));
  return (low + (y - static_cast<double>(y0)) * (high - low)) / 255.0;
}

Place::Place(const scene::Scene& scene)
    : outside_floor(floor_look("concrete")),
      ceiling_look(make_look(Material::ceiling, kCeiling, 1.0F)),
      ceiling(find_ceiling(scene)) {
  constexpr std::size_t kMostObjects = std::numeric_limits<std::int16_t>::max() - kFirstObjectId + 1;
  if (scene.objects.size() > kMostObjects) {
    throw ConfigError(fmt::format("the scene has {} objects; at most {} can be told apart in a picture",
                                  scene.objects.size(), kMostObjects));
  }
  for (const scene::Wall& wall : scene.walls) {
    solids.push_back({scene::solid_of(wall), Material::paint, kWallId});
    palettes.push_back(-1);
  }
  for (const Solid& lintel : lintels(scene)) {
    solids.push_back({lintel, Material::paint, kWallId});
    palettes.push_back(-1);
  }
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    for (const scene::Prism& prism : scene.objects[i].prisms) {
      const int palette = palette_of(prism.material);
      const Solid solid = scene::solid_of(prism, scene.objects[i].pose, static_cast<int>(i));
      solids.push_back({solid, kPalettes[static_cast<std::size_t>(palette)].material,
                        static_cast<std::int16_t>(kFirstObjectId + static_cast<int>(i))});
      palettes.push_back(palette);
    }
  }
  for (std::size_t i = 0; i < scene.rooms.size(); ++i) {
    const scene::Room& room = scene.rooms[i];
    rooms.push_back({room.min, room.max, floor_look(room.floor), kWallPaints[i % kWallPaints.size()]});
  }
  tiles();  // made now, not in the first picture
  groups = make_groups(solids, ceiling);
  light = make_light(solids);
}

const FloorRoom* Place::room_at(Vec2 point) const {
  const auto room = std::ranges::find_if(rooms, [&](const FloorRoom& r) {
    return r.min.x <= point.x && point.x < r.max.x && r.min.y <= point.y && point.y < r.max.y;
  });
  return room == rooms.end() ? nullptr : &*room;
}

Look make_look(Material material, Colour colour, float shade) {
  const MaterialSpec& s = spec(material);
  return {material, colour, shade * s.dark, shade * (s.light - s.dark) / 255.0F};
}

float side_shade(Vec2 normal) { return static_cast<float>(0.86 + 0.11 * (0.6 * normal.x + 0.8 * normal.y)); }

Look side_look(const Place& place, const VisibleSolid& solid, Colour colour, int face, Vec2 normal, Vec2 front) {
  constexpr double kEnd = 0.45;  // [m], a side of a wall that is no longer is its end
  Material material = solid.material;
  if (solid.id == kWallId) {
    const Vec2 side = solid.solid.corners[static_cast<std::size_t>((face + 1) % 4)] -
                      solid.solid.corners[static_cast<std::size_t>(face)];
    const FloorRoom* room = place.room_at(front);
    const bool is_end = dot(side, side) < kEnd * kEnd;
    if (is_end) material = Material::trim;
    colour = is_end ? kTrim : room ? room->wall : kOutsidePaint;
  }
  Look look = make_look(material, colour, side_shade(normal));
  look.shade = 0.80F;
  look.shade_rise = static_cast<float>(0.20 / 0.45 * spec(material).tile_size);
  return look;
}

Look skirting_look(Vec2 normal) { return make_look(Material::trim, kTrim, 0.92F * side_shade(normal)); }

Look top_look(const VisibleSolid& solid, Colour colour) {
  return solid.id == kWallId ? make_look(Material::trim, kTrim, 1.0F) : make_look(solid.material, colour, 1.04F);
}

Look bottom_look(const VisibleSolid& solid, Colour colour) {
  return solid.id == kWallId ? make_look(Material::trim, kTrim, 0.78F) : make_look(solid.material, colour, 0.55F);
}

Colour sky_colour(float slope) {
  constexpr Colour kHorizon = rgb(226, 232, 236);
  constexpr Colour kZenith = rgb(122, 164, 208);
  constexpr float kSteepest = 0.6F;
  const float t = std::clamp(slope / kSteepest, 0.0F, 1.0F);
  return {kHorizon.b + t * (kZenith.b - kHorizon.b), kHorizon.g + t * (kZenith.g - kHorizon.g),
          kHorizon.r + t * (kZenith.r - kHorizon.r)};
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

namespace threewe::sim {

Paint Renderer::paint(std::uint64_t seed, std::uint32_t episode) const {
  const RngKey key{.seed = seed, .episode = episode, .stream = Stream::scene};
  Paint paint;
  for (std::size_t i = 0; i < place_->solids.size(); ++i) {
    const int palette = place_->palettes[i];
    if (palette < 0) {
      paint.colours.push_back({});
      continue;
    }
    const auto object = static_cast<std::uint64_t>(place_->solids[i].id - kFirstObjectId);
    const auto& tints = view::kPalettes[static_cast<std::size_t>(palette)].tints;
    const std::uint32_t draw = random_bits(key, object, static_cast<std::uint32_t>(palette))[0];
    paint.colours.push_back(tints[draw % tints.size()]);
  }
  return paint;
}

}  // namespace threewe::sim
