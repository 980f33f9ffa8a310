// Scene: walls, doors, named rooms, furniture and people. Data, read from assets/scenes/NAME.yaml.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "threewe/core/pose.hpp"
#include "threewe/scene/solid.hpp"

namespace threewe::scene {

/// A vertical prism over a rectangle or a disc. Positions are in the frame of what it belongs to.
struct Prism {
  /// Over a rectangle or a disc.
  enum class Shape : std::uint8_t { box, cylinder };
  Shape shape{};         ///< over a rectangle or a disc
  Pose2D pose;           ///< of its middle
  double length = 0.0;   ///< [m] along x (box)
  double width = 0.0;    ///< [m] along y (box)
  double radius = 0.0;   ///< [m] (cylinder)
  double z_min = 0.0;    ///< [m]
  double z_max = 0.0;    ///< [m]
  std::string material;  ///< such as "wood"
  friend bool operator==(const Prism&, const Prism&) = default;
};

/// A straight wall of some thickness. In `Scene::walls`, a piece between two doorways.
struct Wall {
  Vec2 a;                   ///< [m] one end of its middle line
  Vec2 b;                   ///< [m] the other end
  double thickness = 0.12;  ///< [m]
  double height = 2.6;      ///< [m]
  friend bool operator==(const Wall&, const Wall&) = default;
};

/// An opening in a wall, from floor to ceiling.
struct Doorway {
  std::string name;    ///< unique in the scene
  double at = 0.0;     ///< [m] of its middle, from the wall's `a`
  double width = 0.0;  ///< [m]
  friend bool operator==(const Doorway&, const Doorway&) = default;
};

/// A whole wall and the openings in it, as a plan of the place shows it.
struct WallPlan {
  Wall wall;                      ///< without openings
  std::vector<Doorway> doorways;  ///< in any order
  friend bool operator==(const WallPlan&, const WallPlan&) = default;
};

/// A doorway in a wall, for drawing and for instructions.
struct Door {
  std::string name;    ///< that of its doorway
  Vec2 center;         ///< [m]
  double width = 0.0;  ///< [m]
  friend bool operator==(const Door&, const Door&) = default;
};

/// A named room: an axis-aligned rectangle.
struct Room {
  std::string name;   ///< by which people call it
  Vec2 min;           ///< [m] lower left corner
  Vec2 max;           ///< [m] upper right corner
  std::string floor;  ///< material
  /// A place in the room where a robot can stand.
  Vec2 anchor;
  friend bool operator==(const Room&, const Room&) = default;
};

/// A patch of floor, an axis-aligned rectangle, on which wheels hold better or worse than on the rest.
struct Patch {
  std::string name;       ///< unique in the scene
  Vec2 min;               ///< [m] lower left corner
  Vec2 max;               ///< [m] upper right corner
  std::string floor;      ///< material
  double friction = 1.0;  ///< times the friction that the robot's wheels have on a hard floor
  friend bool operator==(const Patch&, const Patch&) = default;
};

/// A person who walks: round and round a closed route, straight from waypoint to waypoint and back to the first.
struct Person {
  std::string name;         ///< unique in the scene
  std::vector<Vec2> route;  ///< [m] waypoints
  double speed = 1.0;       ///< [m/s]
  double radius = 0.25;     ///< [m]
  friend bool operator==(const Person&, const Person&) = default;
};

/// A piece of furniture: an object from assets/objects at a pose.
struct Object {
  std::string name;           ///< unique in the scene, such as "chair_3"
  std::string category;       ///< such as "chair"
  std::string shape;          ///< such as "wooden": which of the category's shapes
  Pose2D pose;                ///< in the scene's frame
  std::vector<Prism> prisms;  ///< in the object's frame
  friend bool operator==(const Object&, const Object&) = default;
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

  std::string name;             ///< that of its file
  std::string description;      ///< one line
  bool ceiling = true;          ///< false under the open sky
  std::vector<WallPlan> plan;   ///< walls as they were drawn, of which the next four are made
  Vec2 min;                     ///< bounding box of all walls
  Vec2 max;                     ///< [m] its upper right corner
  std::vector<Wall> walls;      ///< the pieces between doorways
  std::vector<Door> doors;      ///< openings in walls
  std::vector<Room> rooms;      ///< named rectangles
  std::vector<Patch> patches;   ///< floors with another friction
  std::vector<Object> objects;  ///< furniture
  std::vector<Person> people;   ///< who walk around
  std::vector<Pose2D> starts;   ///< where robots start; the first is (0, 0, 0)

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
  /// How well wheels hold at a point, times their friction on a hard floor: 1 outside all patches.
  double friction_at(Vec2 point) const;

  /// Makes walls, doors, min and max of the plan.
  void build_walls();
  friend bool operator==(const Scene&, const Scene&) = default;
};

/// The scene as YAML text; reading it gives an equal scene, as long as its objects' shapes are in assets/objects.
std::string to_yaml(const Scene& scene);

/// The names of all scenes.
std::vector<std::string> scene_names();

}  // namespace threewe::scene
