// Validation of scenes as places. Each mistake is reported where it was written.
#pragma once

#include <vector>

#include "core/config.hpp"
#include "threewe/scene/scene.hpp"

namespace threewe::scene {

/// A scene as it is read, with the nodes in which its parts were written.
struct Draft {
  Scene scene;
  std::vector<ConfigNode> walls;  ///< one for every wall of the plan
  std::vector<ConfigNode> starts;
  std::vector<ConfigNode> rooms;
  std::vector<ConfigNode> patches;
  std::vector<ConfigNode> objects;
  std::vector<ConfigNode> people;
};

/// Walls may meet and cross but not lie in each other.
void check_walls(const Draft& draft);

// All else lies inside the walls' bounding box.

/// No wall fills another's doorway.
void check_doors(const Draft& draft);
/// Rooms may touch but not overlap.
void check_rooms(const Draft& draft);
/// Only one patch lies at a place.
void check_patches(const Draft& draft);
/// Objects stand in nothing else.
void check_objects(const Draft& draft);
/// Starts and anchors have room for a robot to stand.
void check_places(const Draft& draft);
/// Routes lead through nothing that stands on the floor.
void check_people(const Draft& draft);

}  // namespace threewe::scene
