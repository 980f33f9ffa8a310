// What is exported of a scene is what the scene is: the same cells are occupied, floors hold alike.
#include "export/scene_blocks.hpp"

#include <doctest/doctest.h>

#include <set>

#include "core/rng.hpp"
#include "scene/occupancy.hpp"
#include "threewe/export/export.hpp"
#include "threewe/hardware/profile.hpp"
#include "threewe/scene/generator.hpp"

namespace threewe::exports {
namespace {

std::vector<scene::Scene> scenes() {
  std::vector<scene::Scene> all;
  for (const std::string& name : scene::scene_names()) all.push_back(scene::Scene::load(name));
  for (std::uint64_t seed = 0; seed < 5; ++seed) all.push_back(scene::generate(seed));
  return all;
}

// The blocks that a plane cuts, as solids again.
std::vector<scene::Solid> cut(const SceneBlocks& blocks, double z) {
  std::vector<scene::Solid> solids;
  for (const auto* shapes : {&blocks.walls, &blocks.furniture}) {
    for (const Shape& shape : *shapes) {
      const auto& [x, y, middle] = shape.pose.position;
      if (std::abs(z - middle) >= 0.5 * shape.size.z) continue;
      solids.push_back(
          shape.kind == Shape::Kind::cylinder
              ? scene::make_disc({x, y}, shape.size.x)
              : scene::make_box({x, y, roll_pitch_yaw(shape.pose.rotation).z}, shape.size.x, shape.size.y));
    }
  }
  return solids;
}

TEST_CASE("slices of blocks occupy the cells that slices of the scene occupy") {
  for (const scene::Scene& scene : scenes()) {
    CAPTURE(scene.name);
    const SceneBlocks blocks = blocks_of(scene);
    const scene::GridFrame frame = grid_over(scene);
    for (const double z : {0.0501, 0.1351, 0.3333, 0.7777, 1.5151, 2.2222}) {
      CAPTURE(z);
      std::vector<scene::Solid> expected = scene.solids();
      std::erase_if(expected, [&](const scene::Solid& solid) { return z < solid.z_min || z >= solid.z_max; });
      CHECK(occupied_cells(frame, cut(blocks, z)) == occupied_cells(frame, expected));
    }
  }
}

TEST_CASE("names are unique") {
  for (const scene::Scene& scene : scenes()) {
    const SceneBlocks blocks = blocks_of(scene);
    std::set<std::string> names;
    for (const auto* shapes : {&blocks.walls, &blocks.furniture, &blocks.people, &blocks.ceiling}) {
      for (const Shape& shape : *shapes) CHECK(names.insert(shape.name).second);
    }
    CHECK(blocks.people.size() == scene.people.size());
  }
}

const FloorTile* tile_at(const std::vector<FloorTile>& tiles, Vec2 p, int& count) {
  const FloorTile* found = nullptr;
  for (const FloorTile& tile : tiles) {
    if (tile.min.x <= p.x && p.x < tile.max.x && tile.min.y <= p.y && p.y < tile.max.y) {
      found = &tile;
      ++count;
    }
  }
  return found;
}

TEST_CASE("floors hold as the scene says at every point, and are of the room's material") {
  for (const scene::Scene& scene : scenes()) {
    CAPTURE(scene.name);
    const SceneBlocks blocks = blocks_of(scene);
    if (scene.patches.empty()) CHECK(blocks.floor_friction.size() == 1);
    for (std::uint32_t i = 0; i < 2000; ++i) {
      CAPTURE(i);
      const auto bits = random_bits({.seed = 3, .stream = Stream::scene}, i);
      const auto share = [&](std::size_t k) { return static_cast<double>(bits[k]) / 4294967296.0; };
      const Vec2 p{scene.min.x - 4 + share(0) * (scene.max.x - scene.min.x + 8),
                   scene.min.y - 4 + share(1) * (scene.max.y - scene.min.y + 8)};
      int frictions = 0;
      int looks = 0;
      const FloorTile* friction = tile_at(blocks.floor_friction, p, frictions);
      const FloorTile* look = tile_at(blocks.floor_looks, p, looks);
      REQUIRE(frictions == 1);
      REQUIRE(looks == 1);
      CHECK(friction->friction == scene.friction_at(p));
      const scene::Room* room = scene.room_at(p);
      if (room != nullptr && scene.patches.empty()) CHECK(look->material == room->floor);
    }
  }
}

TEST_CASE("maps: what the lidar's plane cuts is occupied, the floor around the start free, the rest unknown") {
  const RobotProfile robot = load_profile("3we_standard_v2");
  for (const scene::Scene& scene : scenes()) {
    CAPTURE(scene.name);
    const map::OccupancyGrid grid = map_of(scene, robot);
    CHECK(grid.at(grid.cell({0.0, 0.0})) == map::OccupancyGrid::kFree);
    CHECK(grid.at({0, 0}) == map::OccupancyGrid::kUnknown);
    const scene::Wall& wall = scene.walls.front();
    CHECK(grid.at(grid.cell(0.5 * (wall.a + wall.b))) == map::OccupancyGrid::kOccupied);
  }
}

}  // namespace
}  // namespace threewe::exports
