#include "sim/renderer/place.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "core/numbers.hpp"
#include "core/rng.hpp"
#include "sim/renderer/textures.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::sim::view {
namespace {

using scene::Solid;

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

Circles circles_of(const std::vector<Group>& groups) {
  const std::size_t count = (groups.size() + kWidestBlock - 1) / kWidestBlock * kWidestBlock;
  Circles circles{std::vector<float>(count), std::vector<float>(count), std::vector<float>(count, -1e9F)};
  for (std::size_t i = 0; i < groups.size(); ++i) {
    circles.x[i] = static_cast<float>(groups[i].center.x);
    circles.y[i] = static_cast<float>(groups[i].center.y);
    circles.radius[i] = static_cast<float>(groups[i].radius);
  }
  return circles;
}

double find_ceiling(const scene::Scene& scene) {
  if (!scene.ceiling || scene.walls.empty()) return kInfinity;
  return std::ranges::max(scene.walls, {}, &scene::Wall::height).height;
}

bool overlap(const FloorRegion& a, const FloorRegion& b) {
  return a.min.x < b.max.x && b.min.x < a.max.x && a.min.y < b.max.y && b.min.y < a.max.y;
}

// What lies on top comes first: patches, then rooms, each as light as its lamps.
std::vector<FloorRegion> make_floors(const scene::Scene& scene) {
  constexpr std::array kLamps = {1.0F, 0.94F, 1.03F, 0.90F, 0.98F, 1.05F, 0.92F};
  std::vector<FloorRegion> floors;
  for (const scene::Patch& patch : scene.patches) {
    const auto dry = static_cast<float>(0.75 + 0.25 * std::min(patch.friction, 1.0));  // what is slippery is darker
    floors.push_back({patch.min, patch.max, floor_material(patch.floor, dry), {}, {}});
  }
  for (std::size_t i = 0; i < scene.rooms.size(); ++i) {
    const scene::Room& room = scene.rooms[i];
    const float light = scene.ceiling ? kLamps[i % kLamps.size()] : 1.0F;
    const Colour shading = wall_colour(i);
    floors.push_back({room.min,
                      room.max,
                      floor_material(room.floor, light),
                      {light * shading.b, light * shading.g, light * shading.r},
                      {}});
  }
  for (std::size_t i = 0; i < floors.size(); ++i) {
    for (std::size_t above = 0; above < i; ++above) {
      if (overlap(floors[i], floors[above])) floors[i].above.push_back(above);
    }
  }
  return floors;
}

// Boxes are of cardboard, whatever else is of paper are books and files.
int prism_palette(const scene::Object& object, const scene::Prism& prism) {
  constexpr double kBook = 0.38;  // [m], nothing on a bookshelf is deeper
  const bool is_large = std::min(prism.length, prism.width) > kBook;
  const bool is_box = prism.material == "paper" && (object.category == "box" || is_large);
  return palette_of(is_box ? "cardboard" : prism.material);
}

}  // namespace

Place::Place(const scene::Scene& scene)
    : outside_floor(floor_material(scene.ceiling ? "concrete" : "grass", 1.0F)),
      is_open(!scene.ceiling),
      ceiling(find_ceiling(scene)),
      ceiling_material(view::ceiling_material(ceiling)),
      decor(decorate(scene)) {
  constexpr std::size_t kMostObjects = std::numeric_limits<std::int16_t>::max() - kFirstObjectId + 1;
  if (scene.objects.size() > kMostObjects) {
    throw ConfigError(fmt::format("the scene has {} objects; at most {} can be distinguished in a picture",
                                  scene.objects.size(), kMostObjects));
  }
  tiles();  // made now, not in the first picture
  add_solids(scene);
  floors = make_floors(scene);
  patch_count = scene.patches.size();
  groups = make_groups(solids, ceiling);
  circles = circles_of(groups);
  light = make_light(solids, is_open, decor.sun);
  corner_light = make_light(std::span(solids).first(scene.walls.size()), false, {});
  shade_walls();
}

void Place::shade_walls() {
  first_tint_.push_back(0);
  for (std::size_t i = 0; i < solids.size() && solids[i].id == kWallId; ++i) {
    for (const Side& side : sides[i]) {
      const int count = static_cast<int>(side.length / kTintStep) + 1;
      for (int k = 0; k < count; ++k) {
        const Vec2 point = side.corner + std::min((k + 0.5) * kTintStep, side.length) * side.axis;
        const Colour colour = wall_colour(solids[i], side, point);
        const float lit = side.look.light;
        wall_tints_.push_back(pack({lit * colour.b, lit * colour.g, lit * colour.r}));
      }
      first_tint_.push_back(wall_tints_.size());
    }
  }
}

std::span<const std::uint32_t> Place::tints_of(std::size_t wall, std::size_t face) const {
  const std::size_t first = first_tint_[4 * wall + face];
  return std::span(wall_tints_).subspan(first, first_tint_[4 * wall + face + 1] - first);
}

void Place::add_solids(const scene::Scene& scene) {
  const auto add = [&](const Solid& solid, Material material, std::int16_t id, int palette) {
    solids.push_back({solid, material, id});
    sides.push_back(make_sides(solids.back(), is_open));
    palettes.push_back(palette);
  };
  const Material of_walls = is_open ? Material::brick : Material::shading;
  for (const scene::Wall& wall : scene.walls) add(scene::solid_of(wall), of_walls, kWallId, -1);
  for (const Solid& lintel : lintels(scene)) add(lintel, of_walls, kWallId, -1);
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const scene::Object& object = scene.objects[i];
    const auto id = static_cast<std::int16_t>(kFirstObjectId + static_cast<int>(i));
    for (const scene::Prism& prism : object.prisms) {
      const int index = prism_palette(object, prism);
      add(scene::solid_of(prism, object.pose, static_cast<int>(i)), palette(index).material, id, index);
    }
  }
}

const FloorRegion* Place::floor_at(Vec2 point) const { return find_floor(0, point); }
const FloorRegion* Place::room_at(Vec2 point) const { return find_floor(patch_count, point); }

const FloorRegion* Place::find_floor(std::size_t first, Vec2 point) const {
  for (std::size_t i = first; i < floors.size(); ++i) {
    const FloorRegion& f = floors[i];
    if (f.min.x <= point.x && point.x < f.max.x && f.min.y <= point.y && point.y < f.max.y) return &f;
  }
  return nullptr;
}

std::span<const Decor> Place::decor_of(int solid) const {
  const auto index = static_cast<std::size_t>(solid);
  if (solid < 0 || index + 1 >= decor.first.size()) return {};
  return std::span(decor.all).subspan(decor.first[index], decor.first[index + 1] - decor.first[index]);
}

Colour Place::wall_colour(const VisibleSolid& wall, const Side& side, Vec2 point) const {
  constexpr double kFront = 0.1;  // [m]
  Colour colour = kOutsideColour;
  if (is_open) {
    colour = kBrick;
  } else if (side.length < kWallEnd) {
    colour = kTrim;
  } else if (const FloorRegion* room = room_at(point + kFront * side.normal)) {
    colour = room->wall;
  }
  const float shade = wall.solid.z_min > 0.0 ? 1.0F : wall_colour(side.normal, point);
  return {shade * colour.b, shade * colour.g, shade * colour.r};
}

// Less light comes into corners.
float Place::wall_colour(Vec2 normal, Vec2 point) const {
  constexpr double kFront = 0.3;  // [m]
  return static_cast<float>(std::min(1.0, 0.4 + 0.6 * corner_light.at(point + kFront * normal)));
}

std::uint32_t pack(const Colour& colour) {
  const auto byte = [](float x) { return static_cast<std::uint32_t>(2.0F * std::clamp(x, 0.0F, 255.0F) + 1.0F) / 2U; };
  return byte(colour.b) | byte(colour.g) << 8U | byte(colour.r) << 16U;
}

Colour Place::colour(const Shading& shading, std::size_t solid) const {
  const int index = palettes[solid];
  if (index < 0) return {};
  const RngKey key{.seed = shading.seed, .episode = shading.episode, .stream = Stream::scene};
  const auto object = static_cast<std::uint64_t>(solids[solid].id - kFirstObjectId);
  const auto& tints = palette(index).tints;
  return tints[random_bits(key, object, static_cast<std::uint32_t>(index))[0] % tints.size()];
}

}  // namespace threewe::sim::view
