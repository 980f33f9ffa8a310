#include "scene_checks.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace threewe::scene {
namespace {

constexpr double kSlack = 1e-3;           // [m] that things may reach into each other: coordinates are rounded
constexpr double kStandingRadius = 0.25;  // [m] kept free around starts and anchors
constexpr double kStandingHeight = 0.5;   // [m]

std::string describe(const Scene& scene, int object) {
  return object < 0 ? "a wall" : fmt::format("'{}'", scene.objects[static_cast<std::size_t>(object)].name);
}

// What stands within a robot's reach of a point; null when nothing does.
const Solid* obstacle_at(const std::vector<Solid>& solids, Vec2 point) {
  const auto solid =
      std::ranges::find_if(solids, [&](const Solid& s) { return distance_to(s, point) < kStandingRadius; });
  return solid == solids.end() ? nullptr : &*solid;
}

}  // namespace

bool parallel(const Wall& a, const Wall& b) {
  const Vec2 u = a.b - a.a;
  const Vec2 v = b.b - b.a;
  return std::fabs(cross(u, v)) < 1e-6 * norm(u) * norm(v);
}

void check_rooms(const Draft& draft) {
  const auto& rooms = draft.scene.rooms;
  for (std::size_t i = 0; i < rooms.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const double x = std::min(rooms[i].max.x, rooms[j].max.x) - std::max(rooms[i].min.x, rooms[j].min.x);
      const double y = std::min(rooms[i].max.y, rooms[j].max.y) - std::max(rooms[i].min.y, rooms[j].min.y);
      if (rooms[i].name == rooms[j].name) {
        draft.rooms[i].fail(fmt::format("there are two rooms named '{}'", rooms[i].name));
      }
      if (std::min(x, y) > kSlack) {
        draft.rooms[i].fail(fmt::format("room '{}' overlaps room '{}'", rooms[i].name, rooms[j].name));
      }
    }
  }
}

void check_walls(const Draft& draft) {
  const auto& walls = draft.walls;
  for (std::size_t i = 0; i < walls.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const Wall& a = walls[i].wall;
      const Wall& b = walls[j].wall;
      if (parallel(a, b) && overlaps(solid_of(a), solid_of(b), kSlack)) {
        walls[i].node.fail(fmt::format("wall {} overlaps wall {}", i, j));
      }
    }
  }
}

void check_objects(const Draft& draft) {
  const Scene& scene = draft.scene;
  const std::vector<Solid> solids = scene.solids();
  for (std::size_t i = 0; i < solids.size(); ++i) {
    const Solid& a = solids[i];
    if (a.object < 0) continue;
    const auto object = static_cast<std::size_t>(a.object);
    const Vec2 c = a.center;
    if (c.x < scene.min.x || c.y < scene.min.y || c.x > scene.max.x || c.y > scene.max.y) {
      draft.objects[object].fail(fmt::format("'{}' is outside the walls", scene.objects[object].name));
    }
    for (std::size_t j = 0; j < i && solids[j].object != a.object; ++j) {
      const Solid& b = solids[j];
      if (std::min(a.z_max, b.z_max) - std::max(a.z_min, b.z_min) <= kSlack || !overlaps(a, b, kSlack)) continue;
      draft.objects[object].fail(
          fmt::format("'{}' overlaps {}", scene.objects[object].name, describe(scene, b.object)));
    }
  }
}

void check_places(const Draft& draft) {
  const Scene& scene = draft.scene;
  const std::vector<Solid> solids = scene.solids_between(0.0, kStandingHeight);
  const auto check = [&](const ConfigNode& node, Vec2 place, const std::string& what) {
    const Solid* obstacle = obstacle_at(solids, place);
    if (obstacle == nullptr) return;
    node.fail(fmt::format("{} is within {} m of {}", what, kStandingRadius, describe(scene, obstacle->object)));
  };
  for (std::size_t i = 0; i < scene.starts.size(); ++i) {
    check(draft.starts[i], scene.starts[i].position(), "the start");
  }
  for (std::size_t i = 0; i < scene.rooms.size(); ++i) {
    check(draft.rooms[i], scene.rooms[i].anchor, fmt::format("the anchor of '{}'", scene.rooms[i].name));
  }
}

}  // namespace threewe::scene
