#include "scene_checks.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/exact.hpp"
#include "wall_plan.hpp"

namespace threewe::scene {
namespace {

constexpr double kSlack = 1e-3;           // [m] that things may reach into each other: coordinates are rounded
constexpr double kStandingRadius = 0.25;  // [m] kept free around starts and anchors
constexpr double kStandingHeight = 0.5;   // [m]
constexpr double kWalkingHeight = 1.8;    // [m] of people

std::string describe(const Scene& scene, int object) {
  return object < 0 ? "a wall" : fmt::format("'{}'", scene.objects[static_cast<std::size_t>(object)].name);
}

// Whether a rectangle lies inside the walls' bounding box.
bool within_walls(const Scene& scene, Vec2 low, Vec2 high) {
  return low.x >= scene.min.x && low.y >= scene.min.y && high.x <= scene.max.x && high.y <= scene.max.y;
}

bool lies_in(const Wall& wall, const Solid& other) {
  return distance_to(other, wall.a) <= 0.0 && distance_to(other, wall.b) <= 0.0;
}

// What stands within a robot's reach of a point; null when nothing does.
const Solid* obstacle_at(const std::vector<Solid>& solids, Vec2 point) {
  const auto solid =
      std::ranges::find_if(solids, [&](const Solid& s) { return distance_to(s, point) < kStandingRadius; });
  return solid == solids.end() ? nullptr : &*solid;
}

// What a person of some radius covers between two places, but for the round ends.
Solid swept_box(Vec2 a, Vec2 b, double radius) {
  const Vec2 along = b - a;
  const Vec2 middle = 0.5 * (a + b);
  return make_box({middle.x, middle.y, exact::atan2(along.y, along.x)}, norm(along), 2.0 * radius);
}

}  // namespace

void check_rooms(const Draft& draft) {
  const auto& rooms = draft.scene.rooms;
  for (std::size_t i = 0; i < rooms.size(); ++i) {
    if (!within_walls(draft.scene, rooms[i].min, rooms[i].max)) {
      draft.rooms[i].fail(fmt::format("room '{}' reaches beyond the walls", rooms[i].name));
    }
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
  const auto& plan = draft.scene.plan;
  std::vector<Solid> solids;
  for (std::size_t i = 0; i < plan.size(); ++i) {
    const Wall& a = plan[i].wall;
    solids.push_back(solid_of(a));
    for (std::size_t j = 0; j < i; ++j) {
      const Wall& b = plan[j].wall;
      const bool side_by_side = parallel(a, b) && overlaps(solids[i], solids[j], kSlack);
      if (side_by_side || lies_in(a, solids[j]) || lies_in(b, solids[i])) {
        draft.walls[i].fail(fmt::format("wall {} overlaps wall {}", i, j));
      }
    }
  }
}

void check_doors(const Draft& draft) {
  std::vector<Solid> walls;
  for (const Wall& wall : draft.scene.walls) walls.push_back(solid_of(wall));
  for (std::size_t i = 0; i < draft.scene.plan.size(); ++i) {
    const WallPlan& plan = draft.scene.plan[i];
    const Vec2 along = (1.0 / distance(plan.wall.a, plan.wall.b)) * (plan.wall.b - plan.wall.a);
    for (std::size_t k = 0; k < plan.doorways.size(); ++k) {
      const Doorway& door = plan.doorways[k];
      const Vec2 middle = plan.wall.a + door.at * along;
      const Vec2 half = 0.25 * door.width * along;  // of the middle half: a corner may reach into the rest
      const Solid opening = solid_of(Wall{middle - half, middle + half, plan.wall.thickness});
      const bool blocked =
          std::ranges::any_of(walls, [&](const Solid& wall) { return overlaps(wall, opening, kSlack); });
      if (!blocked) continue;
      ConfigNode node = draft.walls[i];
      node.at("doors").items()[k].fail(fmt::format("door '{}' is blocked by another wall", door.name));
    }
  }
}

void check_patches(const Draft& draft) {
  const Scene& scene = draft.scene;
  for (std::size_t i = 0; i < scene.patches.size(); ++i) {
    const Patch& a = scene.patches[i];
    if (!within_walls(scene, a.min, a.max)) {
      draft.patches[i].fail(fmt::format("patch '{}' reaches beyond the walls", a.name));
    }
    for (std::size_t j = 0; j < i; ++j) {
      const Patch& b = scene.patches[j];
      if (a.name == b.name) draft.patches[i].fail(fmt::format("there are two patches named '{}'", a.name));
      const double x = std::min(a.max.x, b.max.x) - std::max(a.min.x, b.min.x);
      const double y = std::min(a.max.y, b.max.y) - std::max(a.min.y, b.min.y);
      if (std::min(x, y) > kSlack) {
        draft.patches[i].fail(fmt::format("patch '{}' overlaps patch '{}'", a.name, b.name));
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
    if (!within_walls(scene, a.center, a.center)) {
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
    if (!within_walls(scene, place, place)) node.fail(fmt::format("{} is outside the walls", what));
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

namespace {

// What a person walks over: for each waypoint a disc around it, then the strip to the next one.
std::vector<Solid> way_of(const Person& person) {
  std::vector<Solid> way;
  for (std::size_t k = 0; k < person.route.size(); ++k) {
    way.push_back(make_disc(person.route[k], person.radius));
    way.push_back(swept_box(person.route[k], person.route[(k + 1) % person.route.size()], person.radius));
  }
  return way;
}

bool cross(const std::vector<Solid>& way, const std::vector<Solid>& other) {
  return std::ranges::any_of(way, [&](const Solid& a) {
    return std::ranges::any_of(other, [&](const Solid& b) { return overlaps(a, b, kSlack); });
  });
}

}  // namespace

// A way leads through nothing, and crosses no other: people do not see one another.
void check_people(const Draft& draft) {
  const Scene& scene = draft.scene;
  const std::vector<Solid> solids = scene.solids_between(0.0, kWalkingHeight);
  std::vector<std::vector<Solid>> ways;
  for (std::size_t i = 0; i < scene.people.size(); ++i) {
    const Person& person = scene.people[i];
    const std::vector<Solid>& way = ways.emplace_back(way_of(person));
    ConfigNode node = draft.people[i];
    for (std::size_t k = 0; k < person.route.size(); ++k) {
      if (!within_walls(scene, person.route[k], person.route[k])) {
        node.at("route").items()[k].fail(fmt::format("here '{}' walks outside the walls", person.name));
      }
      const auto hit = std::ranges::find_if(solids, [&](const Solid& solid) {
        return overlaps(way[2 * k], solid, kSlack) || overlaps(way[2 * k + 1], solid, kSlack);
      });
      if (hit == solids.end()) continue;
      node.at("route").items()[k].fail(fmt::format("from here '{}' walks through {} on the way to the next waypoint",
                                                   person.name, describe(scene, hit->object)));
    }
  }
  for (std::size_t i = 0; i < ways.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (!cross(ways[i], ways[j])) continue;
      draft.people[i].fail(fmt::format("the way of '{}' crosses that of '{}'; people do not see one another",
                                       scene.people[i].name, scene.people[j].name));
    }
  }
}

}  // namespace threewe::scene
