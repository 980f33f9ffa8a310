// Reads a scene from its file. assets/scenes/office_v2.yaml shows most fields, outdoor_v1.yaml patches of uneven grip,
// dynamic_v1.yaml people.
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include <fmt/format.h>

#include "core/exact.hpp"
#include "object_library.hpp"
#include "scene/surfaces.hpp"
#include "scene_checks.hpp"
#include "threewe/core/assets.hpp"

namespace threewe::scene {
namespace {

constexpr double kLargestArea = 1e5;    // [m^2] around all walls: its tables take 300 MB
constexpr double kSmallestRoom = 0.5;   // [m]
constexpr double kSmallestPatch = 0.1;  // [m]
constexpr double kLeastFriction = 0.2;  // wet ice
constexpr double kMostFriction = 1.5;   // rubber matting
constexpr double kShortestLeg = 0.1;    // [m] of a route
constexpr std::size_t kMostPeople = 100;
constexpr std::size_t kMostWaypoints = 100;

const std::vector<std::string> kFloors = {"wood",  "tile",   "carpet",  "concrete", "vinyl",
                                          "grass", "gravel", "asphalt", "paving"};

// Files write quarter turns as 1.5708: the nearest exact one is meant.
double snap_to_quarter_turn(double theta) {
  const double nearest = exact::kHalfPi * std::round(theta / exact::kHalfPi);
  return std::fabs(theta - nearest) < 1e-3 ? wrap_angle(nearest) : theta;
}

// Moves from the file's frame to the scene's, whose axes are the file's after whole quarter turns: without a rounding.
class SceneFromFile {
 public:
  SceneFromFile() = default;
  explicit SceneFromFile(const Pose2D& start)
      : origin_(start.position()), turns_(static_cast<int>(std::lround(-start.theta / exact::kHalfPi)) & 3) {}

  Vec2 operator()(Vec2 point) const {
    Vec2 p = point - origin_;
    for (int i = 0; i < turns_; ++i) p = {-p.y, p.x};
    return p;
  }
  Pose2D operator()(const Pose2D& pose) const {
    const Vec2 p = (*this)(pose.position());
    return {p.x, p.y, snap_to_quarter_turn(wrap_angle(snap_to_quarter_turn(pose.theta) + turns_ * exact::kHalfPi))};
  }

 private:
  Vec2 origin_;
  int turns_ = 0;
};

class SceneReader {
 public:
  Scene read(ConfigNode root) {
    scene_.name = root.name("name");
    scene_.description = root.text("description");
    read_starts(root.at("starts"));
    if (root.has("ceiling")) scene_.ceiling = root.at("ceiling").boolean();
    if (root.has("rooms")) read_rooms(root.at("rooms"));
    read_walls(root.at("walls"));
    if (root.has("patches")) read_patches(root.at("patches"));
    if (root.has("objects")) read_objects(root.at("objects"));
    if (root.has("people")) read_people(root.at("people"));
    root.finish();

    check_walls(draft_);
    scene_.build_walls();
    const Vec2 size = scene_.max - scene_.min;
    if (size.x * size.y > kLargestArea) {
      root.at("walls").fail(
          fmt::format("the walls span {:.0f} x {:.0f} m; at most {} m2 are read", size.x, size.y, kLargestArea));
    }
    check_doors(draft_);
    check_rooms(draft_);
    check_patches(draft_);
    check_objects(draft_);
    check_places(draft_);
    check_people(draft_);
    return std::move(scene_);
  }

 private:
  void read_starts(const ConfigNode& list) {
    draft_.starts = list.items();
    if (draft_.starts.empty()) list.fail("a scene needs at least one start");
    const ConfigNode& first = draft_.starts.front();
    Pose2D start = first.pose();
    start.theta = snap_to_quarter_turn(start.theta);
    if (std::fabs(std::remainder(start.theta, exact::kHalfPi)) > 1e-9) {
      first.fail("the first start must head along an axis: rooms are rectangles along the scene's axes");
    }
    from_file_ = SceneFromFile(start);
    for (const ConfigNode& node : draft_.starts) scene_.starts.push_back(from_file_(node.pose()));
  }

  void read_rooms(const ConfigNode& list) {
    for (ConfigNode node : list.items()) {
      Room room;
      room.name = node.name("name");
      std::tie(room.min, room.max) = read_rectangle(node, fmt::format("room '{}'", room.name), kSmallestRoom);
      room.floor = node.choice("floor", kFloors);
      room.anchor = node.has("anchor") ? from_file_(node.at("anchor").vec2()) : 0.5 * (room.min + room.max);
      const Vec2 anchor = room.anchor;
      if (anchor.x < room.min.x || anchor.y < room.min.y || anchor.x > room.max.x || anchor.y > room.max.y) {
        node.at("anchor").fail(fmt::format("the anchor of '{}' is outside the room", room.name));
      }
      node.finish();
      scene_.rooms.push_back(room);
      draft_.rooms.push_back(node);
    }
  }

  void read_walls(const ConfigNode& list) {
    for (ConfigNode node : list.items()) {
      WallPlan plan;
      Wall& wall = plan.wall;
      wall.a = from_file_(node.at("a").vec2());
      wall.b = from_file_(node.at("b").vec2());
      if (node.has("thickness")) wall.thickness = node.number_in("thickness", 0.02, 1.0);
      if (node.has("height")) wall.height = node.number_in("height", 0.3, 20.0);
      if (!(distance(wall.a, wall.b) > wall.thickness)) node.fail("a wall must be longer than it is thick");
      if (node.has("doors")) read_doors(node.at("doors"), plan);
      node.finish();
      scene_.plan.push_back(std::move(plan));
      draft_.walls.push_back(node);
    }
    if (scene_.plan.empty()) list.fail("a scene needs at least one wall");
  }

  void read_doors(const ConfigNode& list, WallPlan& plan) {
    const double length = distance(plan.wall.a, plan.wall.b);
    for (ConfigNode node : list.items()) {
      Doorway door{.name = node.name("name"), .at = node.number("at"), .width = node.number_in("width", 0.3, 10.0)};
      node.finish();

      if (door.width > length) node.fail(fmt::format("door '{}' is wider than its wall ({:.2f} m)", door.name, length));
      if (door.at - 0.5 * door.width < 0.0 || door.at + 0.5 * door.width > length) {
        node.fail(fmt::format("door '{}' reaches beyond its wall, which is {:.2f} m long", door.name, length));
      }
      for (const Doorway& other : plan.doorways) {
        if (std::fabs(door.at - other.at) < 0.5 * (door.width + other.width)) {
          node.fail(fmt::format("door '{}' overlaps another door of its wall", door.name));
        }
      }
      if (!doors_.insert(door.name).second) node.fail(fmt::format("there are two doors named '{}'", door.name));
      plan.doorways.push_back(std::move(door));
    }
  }

  void read_objects(const ConfigNode& list) {
    std::map<std::string, int> count;
    for (ConfigNode node : list.items()) {
      Object object;
      object.category = node.text("category");
      object.shape = node.text("shape");
      object.prisms = library_.prisms(node.at("category"), node.at("shape"));
      object.pose = from_file_(node.at("pose").pose());
      const std::string numbered = fmt::format("{}_{}", object.category, ++count[object.category]);
      object.name = node.has("name") ? node.name("name") : numbered;
      node.finish();
      take_name(object.name, node);
      scene_.objects.push_back(std::move(object));
      draft_.objects.push_back(node);
    }
  }

  void read_patches(const ConfigNode& list) {
    for (ConfigNode node : list.items()) {
      Patch patch;
      patch.name = node.name("name");
      std::tie(patch.min, patch.max) = read_rectangle(node, fmt::format("patch '{}'", patch.name), kSmallestPatch);
      patch.floor = node.choice("floor", kFloors);
      patch.friction = node.number_in("friction", kLeastFriction, kMostFriction);
      node.finish();
      scene_.patches.push_back(patch);
      draft_.patches.push_back(node);
    }
  }

  void read_people(const ConfigNode& list) {
    for (ConfigNode node : list.items(kMostPeople)) {
      Person person;
      person.name = node.name("name");
      for (const ConfigNode& waypoint : node.at("route").items(kMostWaypoints)) {
        const Vec2 point = from_file_(waypoint.vec2());
        if (!person.route.empty() && distance(person.route.back(), point) < kShortestLeg) {
          waypoint.fail(fmt::format("waypoints must be at least {} m apart", kShortestLeg));
        }
        person.route.push_back(point);
      }
      if (person.route.size() < 2 || distance(person.route.front(), person.route.back()) < kShortestLeg) {
        node.at("route").fail("expected two or more waypoints; the way from the last back to the first is implied");
      }
      person.speed = node.number_in("speed", 0.1, 2.5);
      person.radius = node.has("radius") ? node.number_in("radius", 0.1, 0.6) : person.radius;
      node.finish();
      take_name(person.name, node);
      scene_.people.push_back(std::move(person));
      draft_.people.push_back(node);
    }
  }

  // Pictures tell by these names what they show: each stands for one thing.
  void take_name(const std::string& name, const ConfigNode& node) {
    const bool is_surface = std::ranges::find(kSurfaceNames, name) != kSurfaceNames.end();
    if (name.empty() || is_surface || name.starts_with("robot_")) {
      node.fail(fmt::format("'{}' cannot be the name of an object or a person", name));
    }
    if (!names_.insert(name).second) {
      node.fail(fmt::format("there are two things named '{}' (those without a name are numbered)", name));
    }
  }

  // `min` and `max` of something, in the scene's frame.
  std::pair<Vec2, Vec2> read_rectangle(ConfigNode& node, const std::string& what, double smallest) const {
    const Vec2 low = node.at("min").vec2();
    const Vec2 high = node.at("max").vec2();
    if (high.x - low.x < smallest || high.y - low.y < smallest) {
      node.fail(fmt::format("{} is inside out or less than {} m wide", what, smallest));
    }
    const Vec2 a = from_file_(low);
    const Vec2 b = from_file_(high);
    return {{std::min(a.x, b.x), std::min(a.y, b.y)}, {std::max(a.x, b.x), std::max(a.y, b.y)}};
  }

  Draft draft_;
  Scene& scene_ = draft_.scene;
  SceneFromFile from_file_;
  ObjectLibrary library_;
  std::set<std::string> doors_;
  std::set<std::string> names_;  // of objects and people
};

}  // namespace

Scene Scene::load(std::string_view name) {
  const std::filesystem::path file = find_asset("scenes", name);
  ConfigNode root = ConfigNode::load(file);
  Scene scene = SceneReader().read(root);
  if (scene.name != file.stem()) {
    root.at("name").fail(fmt::format("expected '{}', the name of the file", file.stem().string()));
  }
  return scene;
}

Scene Scene::parse(const std::string& text, const std::string& file) {
  return SceneReader().read(ConfigNode::parse(text, file));
}

}  // namespace threewe::scene
