#include "backend/mujoco/world/patterns.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "sim/renderer/materials.hpp"
#include "sim/renderer/textures.hpp"

namespace threewe::backend::mujoco {
namespace {

using exports::Vec3;
using sim::Material;

/// What the surfaces of a scene are made of.
class Surfaces {
 public:
  explicit Surfaces(const sim::Model& world) : scene_(*world.scene), ceiling_(world.renderer().ceiling()) {
    for (const sim::VisibleSolid& solid : world.renderer().solids()) objects_.emplace(solid.id, solid.material);
  }

  std::optional<Material> material(std::int16_t id, const Vec3& point) const {
    if (id == sim::kFloorId) return sim::view::floor_material(floor_at({point.x, point.y}), 1.0F).material;
    if (id == sim::kWallId) return scene_.ceiling ? Material::shading : Material::brick;
    if (id == sim::kCeilingId) return sim::view::ceiling_material(ceiling_).material;
    const auto found = objects_.find(id);
    return found == objects_.end() ? std::nullopt : std::optional(found->second);
  }

 private:
  std::string floor_at(Vec2 point) const {
    const scene::Room* room = scene_.room_at(point);
    if (room != nullptr) return room->floor;
    return scene_.ceiling ? "concrete" : "grass";
  }

  const scene::Scene& scene_;
  double ceiling_;
  std::map<std::int16_t, Material> objects_;  // by their first solid
};

/// How bright a pattern is at a point: on level surfaces laid along x and y, on others along the wall and z.
double brightness(Material worn, std::int16_t id, const Vec3& point, double pixels_per_metre) {
  const double tile = sim::view::spec(worn).tile_size;
  const double texels = sim::view::kTileSide / (tile * pixels_per_metre);  // of a tile's finest level in one pixel
  const int level = std::clamp(std::ilogb(std::max(texels, 1.0)), 0, sim::view::kTileLevels - 1);
  const bool is_level = id == sim::kFloorId || id == sim::kCeilingId;
  const double u = is_level ? point.x : point.x + point.y;
  const double v = is_level ? point.y : point.z;
  return sim::view::sample(worn, level, u / tile, v / tile);
}

}  // namespace

void wear_patterns(const sim::Model& world, const models::Variation& variation, const CameraIntrinsics& camera,
                   const exports::Transform& scene_from_camera, const Shown& shown, std::span<std::uint8_t> color) {
  const Surfaces surfaces(world);
  const auto worn = sim::view::patterns_of(static_cast<std::uint32_t>(variation.texture));
  const auto width = static_cast<std::size_t>(camera.width);
  for (std::size_t i = 0; i < shown.ids.size(); ++i) {
    const std::size_t row = i / width;
    const auto depth = static_cast<double>(shown.depth[i]);
    if (depth <= 0.0) continue;
    const double left = (camera.cx - (static_cast<double>(i % width) + 0.5)) / camera.fx;
    const double up = (camera.cy - (static_cast<double>(row) + 0.5)) / camera.fy;
    const Vec3 ray = rotated(scene_from_camera.rotation, {depth, depth * left, depth * up});
    const Vec3 eye = scene_from_camera.position;
    const Vec3 point{eye.x + ray.x, eye.y + ray.y, eye.z + ray.z};
    const std::optional<Material> material = surfaces.material(shown.ids[i], point);
    if (!material) continue;
    const double full = brightness(worn[static_cast<std::size_t>(*material)], shown.ids[i], point, camera.fx / depth);
    const double bright = 1.0 + variation.detail * (full - 1.0);
    for (std::size_t c = 0; c < 3; ++c) {
      auto& channel = color[3 * i + c];
      channel = static_cast<std::uint8_t>(std::min(std::lround(bright * channel), 255L));
    }
  }
}

}  // namespace threewe::backend::mujoco
