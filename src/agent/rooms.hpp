// Rooms: places that are polygons, and the openings between them that the robot's map shows.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "core/opening.hpp"
#include "semantics/semantic_map.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/map/occupancy_grid.hpp"

namespace threewe::agent {

/// A free stretch of the border between two rooms.
struct Opening {
  bool is_door = false;  ///< a wall ends it on both sides, and it is not as wide as a room
  std::size_t to = 0;    ///< the room behind it, index into the places
  Vec2 a;                ///< [m] from here ...
  Vec2 b;                ///< [m] ... to here it is free
  Vec2 normal;           ///< out of the room, of length 1

  Vec2 middle() const { return 0.5 * (a + b); }
  /// Where a robot crosses it that comes straight from a point, 0.4 m from its ends where it is wide enough.
  Vec2 crossing(Vec2 from) const { return crossing_of(a, b, from); }
};

/// A point of a border of which is not known whether it is open.
struct UnseenBorder {
  std::size_t to = 0;  ///< the room behind it, index into the places
  Vec2 point;          ///< [m]
  Vec2 normal;         ///< out of the room, of length 1
};

/// The border of a room with others, as far as a map shows it.
struct Border {
  std::vector<Opening> openings;
  std::vector<UnseenBorder> unseen;  ///< 0.25 m apart or more
};

/// The border of places[room], a polygon, with all other polygons that adjoin it.
Border border_of(const map::OccupancyGrid& grid, const std::vector<semantics::Place>& places, std::size_t room);
/// The smallest polygon that holds a point, index into the places.
std::optional<std::size_t> room_at(const std::vector<semantics::Place>& places, Vec2 point);
/// The direction of length 1 along or across a room's longest wall that is nearest to a heading.
Vec2 along_walls(const semantics::Place& room, Vec2 heading);

}  // namespace threewe::agent
