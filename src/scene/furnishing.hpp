// Furniture of generated scenes: groups of pieces that belong together, along the walls and in the middle of rooms.
#pragma once

#include <string>
#include <vector>

#include "floor_plan.hpp"
#include "threewe/scene/scene.hpp"

namespace threewe::scene {

/// Pieces that were put down together, and may have to go together.
struct Group {
  std::vector<Object> objects;  ///< nameless; in the building's frame
  Box box;                      ///< [cm] that they stay inside
};

/// A room to be furnished.
struct EmptyRoom {
  /// A way in. Nothing is put in front of it.
  struct Doorway {
    int x = 0;          ///< [cm] of its middle, in the middle of the wall
    int y = 0;          ///< [cm]
    int turns = 0;      ///< quarter turns from x to the direction into the room
    int width = 0;      ///< [cm]
    bool leaf = false;  ///< whether its leaf stands open in this room
  };

  Box inside;  ///< [cm] between the faces of its walls
  bool corridor = false;
  std::vector<Doorway> doorways;
  Box keep_free;  ///< [cm] where robots start
};

/// What a room is used for: its name and its floor.
struct RoomUse {
  std::string name;
  std::string floor;
  std::vector<Group> groups;
};

/// Chooses a use and furnishes the room for it. Every piece is met from the front with space to stand there; the higher
/// the difficulty (0..1), the more pieces and the less space.
RoomUse furnish(const EmptyRoom& room, double difficulty, RandomStream& random);

}  // namespace threewe::scene
