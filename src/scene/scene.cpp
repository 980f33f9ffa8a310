#include "threewe/scene/scene.hpp"

#include <algorithm>

#include "core/exact.hpp"
#include "core/names.hpp"
#include "threewe/core/assets.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::scene {
Solid solid_of(const Wall& wall) {
  const Vec2 along = wall.b - wall.a;
  const Pose2D middle{0.5 * (wall.a.x + wall.b.x), 0.5 * (wall.a.y + wall.b.y), exact::atan2(along.y, along.x)};
  Solid solid = make_box(middle, norm(along), wall.thickness);
  solid.z_max = wall.height;
  return solid;
}

Solid solid_of(const Prism& prism, const Pose2D& scene_from_object, int object) {
  const Pose2D middle = scene_from_object * prism.pose;
  Solid solid = prism.shape == Prism::Shape::box ? make_box(middle, prism.length, prism.width)
                                                 : make_disc(middle.position(), prism.radius);
  solid.z_min = prism.z_min;
  solid.z_max = prism.z_max;
  solid.object = object;
  return solid;
}

std::vector<Solid> Scene::solids() const {
  std::vector<Solid> solids;
  for (const Wall& wall : walls) solids.push_back(solid_of(wall));
  for (std::size_t i = 0; i < objects.size(); ++i) {
    for (const Prism& prism : objects[i].prisms) {
      solids.push_back(solid_of(prism, objects[i].pose, static_cast<int>(i)));
    }
  }
  return solids;
}

std::vector<Solid> Scene::solids_between(double z_min, double z_max) const {
  std::vector<Solid> between = solids();
  std::erase_if(between, [&](const Solid& solid) { return solid.z_min >= z_max || solid.z_max <= z_min; });
  return between;
}

Slice Scene::at_height(double z) const {
  std::vector<Solid> cut = solids();
  std::erase_if(cut, [&](const Solid& solid) { return z < solid.z_min || z >= solid.z_max; });
  return outlines(cut);
}

Slice Scene::between(double z_min, double z_max) const { return outlines(solids_between(z_min, z_max)); }

const Room* Scene::room_at(Vec2 point) const {
  const auto room = std::ranges::find_if(rooms, [&](const Room& r) {
    return r.min.x <= point.x && point.x < r.max.x && r.min.y <= point.y && point.y < r.max.y;
  });
  return room == rooms.end() ? nullptr : &*room;
}

const Room& Scene::room(std::string_view room_name) const {
  const auto room = std::ranges::find(rooms, room_name, &Room::name);
  if (room != rooms.end()) return *room;
  std::vector<std::string> names;
  for (const Room& r : rooms) names.push_back(r.name);
  throw ConfigError(unknown_name("room", room_name, names));
}

double Scene::friction_at(Vec2 point) const {
  const auto patch = std::ranges::find_if(patches, [&](const Patch& p) {
    return p.min.x <= point.x && point.x < p.max.x && p.min.y <= point.y && point.y < p.max.y;
  });
  return patch == patches.end() ? 1.0 : patch->friction;
}

std::vector<std::string> scene_names() { return asset_names("scenes"); }

}  // namespace threewe::scene
