// A scene: walls, doors, named rooms, furniture. Data, read from assets/scenes/NAME.yaml.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "threewe/core/pose.hpp"
#include "threewe/scene/geometry.hpp"
#include "threewe/scene/solid.hpp"

namespace threewe::scene {

/// A vertical prism over a rectangle or a disc. Positions are in the frame of what it belongs to.
struct Prism {
  enum class Shape : std::uint8_t { box, cylinder };
  Shape shape{};
  Pose2D pose;          ///< of its middle
  double length = 0.0;  ///< [m] along x (box)
  double width = 0.0;   ///< [m] along y (box)
  double radius = 0.0;  ///< [m] (cylinder)
  double z_min = 0.0;   ///< [m]
  double z_max = 0.0;   ///< [m]
  std::string material;
};

/// A straight wall of some thickness, without its doorways: the pieces between them.
struct Wall {
  Vec2 a;
  Vec2 b;
  double thickness = 0.0;  ///< [m]
  double height = 0.0;     ///< [m]
};

/// A doorway in a wall, for drawing and for instructions.
struct Door {
  std::string name;
  Vec2 center;
  double width = 0.0;  ///< [m]
};

/// A named room: an axis-aligned rectangle.
struct Room {
  std::string name;
  Vec2 min;
  Vec2 max;
  std::string floor;  ///< material
  /// A place in the room where a robot can stand.
  Vec2 anchor;
};

/// A piece of furniture: an object from assets/objects at a pose.
struct Object {
  std::string name;      ///< unique in the scene, such as "chair_3"
  std::string category;  ///< such as "chair"
  Pose2D pose;
  std::vector<Prism> prisms;  ///< in the object's frame
};

/// A wall's rectangle.
Solid solid_of(const Wall& wall);
/// A prism's outline where its object stands.
Solid solid_of(const Prism& prism, const Pose2D& scene_from_object, int object);

/// A scene. Its frame has its origin at the `start` pose, x along the start heading.
class Scene {
 public:
  /// Reads a scene by name, or from a file that ends in .yaml. Throws ConfigError with file:line.
  static Scene load(std::string_view name);
  /// Reads a scene from text; `file` stands for its place in messages.
  static Scene parse(const std::string& text, const std::string& file);

  std::string name;
  std::string description;
  Vec2 min;  ///< bounding box of all walls
  Vec2 max;
  std::vector<Wall> walls;
  std::vector<Door> doors;
  std::vector<Room> rooms;
  std::vector<Object> objects;
  std::vector<Pose2D> starts;  ///< where robots start; the first is (0, 0, 0)

  /// Every wall and every prism of every object, in that order, in the scene's frame.
  std::vector<Solid> solids() const;
  /// Those that reach into the slab between the heights.
  std::vector<Solid> solids_between(double z_min, double z_max) const;
  /// What the plane at height `z` cuts: shapes with z_min <= z < z_max.
  Slice at_height(double z) const;
  /// What stands between the heights: the obstacles of a robot that is `z_max` tall.
  Slice between(double z_min, double z_max) const;
  /// The room that holds a point; null outside all rooms.
  const Room* room_at(Vec2 point) const;
  /// A room by name. Throws ConfigError naming the nearest right one.
  const Room& room(std::string_view name) const;
};

/// The names of all scenes.
std::vector<std::string> scene_names();

}  // namespace threewe::scene
