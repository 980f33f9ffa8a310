#include "export/scene_blocks.hpp"
#include "core/exact.hpp"

#include <algorithm>
#include <functional>

#include <fmt/format.h>

namespace threewe::exports {
namespace {

constexpr Color kWall{0.91, 0.89, 0.85};
constexpr Color kCeiling{0.89, 0.89, 0.87};
constexpr Color kShirt{0.24, 0.38, 0.57};
constexpr double kPersonHeight = 1.75;  // [m]
constexpr const char* kOutside = "concrete";

Shape block(std::string name, const scene::Solid& solid, const Color& color) {
  Shape shape{.name = std::move(name), .color = color};
  const double height = solid.z_max - solid.z_min;
  shape.pose.position = {solid.center.x, solid.center.y, 0.5 * (solid.z_min + solid.z_max)};
  if (solid.shape == scene::Solid::Shape::disc) {
    shape.kind = Shape::Kind::cylinder;
    shape.size = {solid.radius, solid.radius, height};
    return shape;
  }
  const Vec2 along = solid.corners[1] - solid.corners[0];
  shape.kind = Shape::Kind::box;
  shape.pose.rotation = about_z(exact::atan2(along.y, along.x));
  shape.size = {norm(along), distance(solid.corners[1], solid.corners[2]), height};
  return shape;
}

std::vector<Shape> walls_of(const scene::Scene& scene) {
  std::vector<Shape> walls;
  for (const scene::Wall& wall : scene.walls) {
    walls.push_back(block(fmt::format("wall_{}", walls.size()), solid_of(wall), kWall));
  }
  return walls;
}

std::vector<Shape> furniture_of(const scene::Scene& scene) {
  std::vector<Shape> furniture;
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const scene::Object& object = scene.objects[i];
    for (std::size_t k = 0; k < object.prisms.size(); ++k) {
      const scene::Prism& prism = object.prisms[k];
      const scene::Solid solid = solid_of(prism, object.pose, static_cast<int>(i));
      furniture.push_back(block(fmt::format("{}/{}", object.name, k), solid, color_of(prism.material)));
    }
  }
  return furniture;
}

std::vector<Shape> people_of(const scene::Scene& scene) {
  std::vector<Shape> people;
  for (const scene::Person& person : scene.people) {
    scene::Solid solid = scene::make_disc(person.route.front(), person.radius);
    solid.z_max = kPersonHeight;
    people.push_back(block(person.name, solid, kShirt));
  }
  return people;
}

std::vector<Shape> ceiling_of(const scene::Scene& scene) {
  constexpr double kThickness = 0.05;  // [m]
  if (!scene.ceiling || scene.walls.empty()) return {};
  const double height = std::ranges::max(scene.walls, {}, &scene::Wall::height).height;
  const Vec2 size = scene.max - scene.min;
  scene::Solid solid = scene::make_box({scene.min.x + size.x / 2, scene.min.y + size.y / 2, 0.0}, size.x, size.y);
  solid.z_min = height;
  solid.z_max = height + kThickness;
  Shape ceiling = block("ceiling", solid, kCeiling);
  ceiling.collides = false;
  return {ceiling};
}

struct Rectangle {
  Vec2 min;
  Vec2 max;
};

Rectangle floor_of(const scene::Scene& scene) {
  const Vec2 margin{kFloorMargin, kFloorMargin};
  return {scene.min - margin, scene.max + margin};
}

std::vector<double> sorted_cuts(std::vector<double> cuts, double low, double high) {
  cuts.push_back(low);
  cuts.push_back(high);
  std::erase_if(cuts, [&](double cut) { return cut < low || cut > high; });
  std::ranges::sort(cuts);
  const auto repeated = std::ranges::unique(cuts);
  cuts.erase(repeated.begin(), repeated.end());
  return cuts;
}

using KindOfFloor = std::function<FloorTile(Vec2 point)>;  // material and grip there

bool same_kind(const FloorTile& a, const FloorTile& b) { return a.material == b.material && a.friction == b.friction; }

// The floor as few tiles that do not overlap: it is cut at the edges of all rectangles, then cells that are alike are
// joined, along x first.
std::vector<FloorTile> tiles_of(const Rectangle& floor, const std::vector<Rectangle>& rectangles, const char* name,
                                const KindOfFloor& kind_at) {
  std::vector<double> xs;
  std::vector<double> ys;
  for (const auto& [min, max] : rectangles) {
    xs.insert(xs.end(), {min.x, max.x});
    ys.insert(ys.end(), {min.y, max.y});
  }
  xs = sorted_cuts(std::move(xs), floor.min.x, floor.max.x);
  ys = sorted_cuts(std::move(ys), floor.min.y, floor.max.y);
  std::vector<FloorTile> tiles;
  for (std::size_t row = 0; row + 1 < ys.size(); ++row) {
    std::vector<FloorTile> runs;
    for (std::size_t column = 0; column + 1 < xs.size(); ++column) {
      FloorTile tile = kind_at({0.5 * (xs[column] + xs[column + 1]), 0.5 * (ys[row] + ys[row + 1])});
      tile.min = {xs[column], ys[row]};
      tile.max = {xs[column + 1], ys[row + 1]};
      if (!runs.empty() && same_kind(runs.back(), tile)) {
        runs.back().max.x = tile.max.x;
      } else {
        runs.push_back(tile);
      }
    }
    for (const FloorTile& run : runs) {
      const auto below = std::ranges::find_if(tiles, [&](const FloorTile& tile) {
        return same_kind(tile, run) && tile.max.y == run.min.y && tile.min.x == run.min.x && tile.max.x == run.max.x;
      });
      if (below != tiles.end()) {
        below->max.y = run.max.y;
      } else {
        tiles.push_back(run);
      }
    }
  }
  for (std::size_t i = 0; i < tiles.size(); ++i) tiles[i].name = fmt::format("{}_{}", name, i);
  return tiles;
}

template <class Part>
const Part* part_at(const std::vector<Part>& parts, Vec2 p) {
  const auto found = std::ranges::find_if(parts, [&](const Part& part) {
    return part.min.x <= p.x && p.x < part.max.x && part.min.y <= p.y && p.y < part.max.y;
  });
  return found == parts.end() ? nullptr : &*found;
}

std::vector<FloorTile> looks_of(const scene::Scene& scene) {
  std::vector<Rectangle> rectangles;
  for (const scene::Room& room : scene.rooms) rectangles.push_back({room.min, room.max});
  for (const scene::Patch& patch : scene.patches) rectangles.push_back({patch.min, patch.max});
  return tiles_of(floor_of(scene), rectangles, "floor", [&](Vec2 point) {
    FloorTile tile{.material = kOutside};
    if (const scene::Room* room = part_at(scene.rooms, point)) tile.material = room->floor;
    if (const scene::Patch* patch = part_at(scene.patches, point)) tile.material = patch->floor;
    return tile;
  });
}

std::vector<FloorTile> friction_of(const scene::Scene& scene) {
  std::vector<Rectangle> rectangles;
  for (const scene::Patch& patch : scene.patches) rectangles.push_back({patch.min, patch.max});
  return tiles_of(floor_of(scene), rectangles, "ground",
                  [&](Vec2 point) { return FloorTile{.friction = scene.friction_at(point)}; });
}

}  // namespace

SceneBlocks blocks_of(const scene::Scene& scene) {
  return {.walls = walls_of(scene),
          .furniture = furniture_of(scene),
          .people = people_of(scene),
          .ceiling = ceiling_of(scene),
          .floor_looks = looks_of(scene),
          .floor_friction = friction_of(scene)};
}

Shape floor_box(const FloorTile& tile) {
  const Vec2 size = tile.max - tile.min;
  const Vec2 middle = 0.5 * (tile.min + tile.max);
  Shape shape{.name = tile.name, .kind = Shape::Kind::box, .color = color_of(tile.material)};
  shape.pose.position = {middle.x, middle.y, -0.5 * kFloorThickness};
  shape.size = {size.x, size.y, kFloorThickness};
  return shape;
}

}  // namespace threewe::exports
