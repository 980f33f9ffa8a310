// Semantic map of a scene, as instructions speak of it: named rooms, the ways between them, and landmarks.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/opening.hpp"
#include "language/vocabulary.hpp"
#include "scene/scene_tables.hpp"
#include "threewe/core/pose.hpp"

namespace threewe::task {

/// Where one walks from one room into another: a doorway, or a border without a wall.
struct Opening {
  bool is_door = false;
  std::array<std::size_t, 2> rooms{};
  Vec2 a;       ///< from here ...
  Vec2 b;       ///< ... to here a robot's base can pass; along an axis
  Vec2 normal;  ///< from `rooms[0]` to `rooms[1]`, of length 1

  Vec2 middle() const { return 0.5 * (a + b); }
  bool joins(std::size_t room) const { return rooms[0] == room || rooms[1] == room; }
  std::size_t beyond(std::size_t room) const { return rooms[0] == room ? rooms[1] : rooms[0]; }
  /// The way out of a room.
  Vec2 out_of(std::size_t room) const { return rooms[0] == room ? normal : -1.0 * normal; }
  /// Where a walker crosses it who comes straight from a point, 0.4 m away from its ends where it is wide enough.
  Vec2 crossing(Vec2 from) const { return crossing_of(a, b, from); }
};

/// A thing that stands on the floor.
struct Landmark {
  std::size_t object = 0;  ///< index into `Scene::objects`
  std::size_t room = 0;
  std::string noun;     ///< what it is called: "armchair"
  std::string general;  ///< and in general: "chair"
  Vec2 center;
  std::vector<scene::Solid> solids;

  bool is_called(const std::string& name) const { return noun == name || general == name; }
};

/// Rooms have the indices of `Scene::rooms`. Const once made.
class SemanticMap {
 public:
  SemanticMap(const scene::SceneTables& tables, const language::Language& language);

  const scene::SceneTables& tables() const { return *tables_; }
  /// What rooms are called.
  const std::vector<std::string>& rooms() const { return rooms_; }
  const std::vector<Opening>& openings() const { return openings_; }
  const std::vector<Landmark>& landmarks() const { return landmarks_; }
  /// Indices of the landmarks that stand beside another, at most 0.5 m between them.
  const std::vector<std::size_t>& beside(std::size_t landmark) const { return beside_[landmark]; }
  /// The index of the room that holds a point.
  std::optional<std::size_t> room_at(Vec2 point) const;

  /// Where a robot that comes from a point stops at a landmark: of the roomy cells of its room within 0.5 m of it, the
  /// one that is nearest to that point. Nothing where there is none.
  std::optional<Vec2> place_at(std::size_t landmark, Vec2 from) const;
  /// The roomy cell of a room that is nearest to its middle.
  std::optional<Vec2> middle_of(std::size_t room) const;
  /// The roomy cell of a room that is nearest to 0.7 m behind an opening.
  std::optional<Vec2> just_inside(std::size_t room, std::size_t opening) const;

 private:
  void find_openings(const scene::Room& a, const scene::Room& b, std::size_t index_a, std::size_t index_b);
  void find_landmarks(const language::Language& language);
  std::optional<Vec2> roomy_cell_near(std::size_t room, Vec2 point, double farthest) const;

  const scene::SceneTables* tables_;
  std::vector<std::string> rooms_;
  std::vector<Opening> openings_;
  std::vector<Landmark> landmarks_;
  std::vector<std::vector<std::size_t>> beside_;
  std::vector<unsigned char> roomy_;  // by cell
};

}  // namespace threewe::task
