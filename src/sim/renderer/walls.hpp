// Wall decoration that is in no scene's list: lintels, windows, pictures.
#pragma once

#include <vector>

#include "sim/renderer/light.hpp"
#include "sim/renderer/materials.hpp"
#include "threewe/scene/scene.hpp"

namespace threewe::sim::view {

/// Clear height of a doorway below its lintel [m].
inline constexpr double kDoorHeight = 2.05;
/// A lintel over each doorway whose wall reaches higher.
std::vector<scene::Solid> lintels(const scene::Scene& scene);

/// Something flat on a face of a wall: a rectangle as wide as whole tiles of its material.
struct Decor {
  int face = 0;
  double begin = 0.0;  // [m] along the face, from its first corner
  double end = 0.0;
  double low = 0.0;  // [m] above the floor
  double high = 0.0;
  SurfaceMaterial look;
  float detail = 1.0F;  // of a picture that shows it, at least
};

/// What hangs on a scene's walls.
struct WallDecor {
  std::vector<Decor> all;
  std::vector<std::size_t> first;  ///< by wall, and one more: where its own begin
  std::vector<SunPatch> sun;       ///< through the windows
};

/// Windows where a room is on one side of a wall and nothing on the other; pictures on some of the others. Only under
/// a ceiling.
WallDecor decorate(const scene::Scene& scene);

}  // namespace threewe::sim::view
