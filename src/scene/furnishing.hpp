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
  Box inside;  ///< [cm] between the faces of its walls
  bool corridor = false;
  std::vector<Box> keep_free;  ///< [cm] in front of doorways, and where robots start
};

/// What a room is used for: its name and its floor.
struct RoomUse {
  std::string name;
  std::string floor;
  std::vector<Group> groups;
};

/// Chooses a use and furnishes the room for it. Every piece is met from the front with space to stand there; the higher
/// the difficulty (0..1), the more pieces and the less space.
RoomUse furnish(const EmptyRoom& room, double difficulty, Dice& dice);

}  // namespace threewe::scene
