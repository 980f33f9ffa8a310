// What a scene must be to make sense as a place. Each mistake is reported where it was written.
#pragma once

#include <vector>

#include "threewe/core/config.hpp"
#include "threewe/scene/scene.hpp"

namespace threewe::scene {

/// An opening in a wall, between two distances [m] from the wall's `a`.
struct Doorway {
  double from = 0.0;
  double to = 0.0;
};

/// A wall before its doorways are cut out of it.
struct WallDraft {
  Wall wall;
  std::vector<Doorway> doorways;  ///< in order along the wall
  double before_a = 0.0;          ///< [m] that it is made longer, to fill the corner with the next wall
  double after_b = 0.0;           ///< [m]
  ConfigNode node;
};

/// A scene as it is read, with the nodes in which its parts were written.
struct Draft {
  Scene scene;
  std::vector<WallDraft> walls;
  std::vector<ConfigNode> starts;
  std::vector<ConfigNode> rooms;
  std::vector<ConfigNode> objects;
};

/// Whether two walls run in the same or in opposite directions.
bool parallel(const Wall& a, const Wall& b);

/// Rooms may touch but not overlap; walls may meet and cross but not lie in each other.
void check_rooms(const Draft& draft);
void check_walls(const Draft& draft);
/// Objects lie inside the walls' bounding box and in nothing else.
void check_objects(const Draft& draft);
/// Starts and anchors have room for a robot to stand.
void check_places(const Draft& draft);

}  // namespace threewe::scene
