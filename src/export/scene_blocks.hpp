// Scene description for physics engines: named boxes and cylinders, floors by their friction, and people.
#pragma once

#include <string>
#include <vector>

#include "export/shape.hpp"
#include "threewe/scene/scene.hpp"

namespace threewe::exports {

/// A rectangle of floor.
struct FloorTile {
  std::string name{};
  Vec2 min{};
  Vec2 max{};
  std::string material{};
  double friction = 1.0;  ///< times the friction that wheels have on a hard floor
  friend bool operator==(const FloorTile&, const FloorTile&) = default;
};

/// Everything of a scene, in its frame.
struct SceneBlocks {
  std::vector<Shape> walls;
  std::vector<Shape> furniture;           ///< one for every prism, named `<object>/<number>`
  std::vector<Shape> people;              ///< each where its route begins
  std::vector<Shape> ceiling;             ///< none under the open sky
  std::vector<FloorTile> floor_looks;     ///< what is seen of the floor; tiles do not overlap
  std::vector<FloorTile> floor_friction;  ///< what wheels feel of it: a single tile where it holds alike
};

SceneBlocks blocks_of(const scene::Scene& scene);

/// [m] that floors reach beyond the walls, and how thick they are.
inline constexpr double kFloorMargin = 5.0;
inline constexpr double kFloorThickness = 0.1;
/// A floor tile as a box, its top at z = 0.
Shape floor_box(const FloorTile& tile);

}  // namespace threewe::exports
