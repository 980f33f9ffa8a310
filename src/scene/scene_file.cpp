// Reads a scene from its file. assets/scenes/office_v2.yaml shows every field.
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include <fmt/format.h>

#include "object_library.hpp"
#include "scene_checks.hpp"
#include "threewe/core/assets.hpp"

namespace threewe::scene {
namespace {

constexpr double kQuarterTurn = 0.5 * exact::kPi;

constexpr double kSmallestRoom = 0.5;    // [m]
constexpr double kSmallestPiece = 1e-3;  // [m] of a wall, left over beside a door

const std::vector<std::string> kFloors = {"wood", "tile", "carpet", "concrete", "vinyl"};

// Files write quarter turns as 1.5708: the nearest exact one is meant.
double snap_to_quarter_turn(double theta) {
  const double nearest = kQuarterTurn * std::round(theta / kQuarterTurn);
  return std::fabs(theta - nearest) < 1e-3 ? wrap_angle(nearest) : theta;
}

// Moves from the file's frame to the scene's, whose axes are the file's after whole quarter turns: without a rounding.
class SceneFromFile {
 public:
  SceneFromFile() = default;
  explicit SceneFromFile(const Pose2D& start)
      : origin_(start.position()), turns_(static_cast<int>(std::lround(-start.theta / kQuarterTurn)) & 3) {}

  Vec2 operator()(Vec2 point) const {
    Vec2 p = point - origin_;
    for (int i = 0; i < turns_; ++i) p = {-p.y, p.x};
    return p;
  }
  Pose2D operator()(const Pose2D& pose) const {
    const Vec2 p = (*this)(pose.position());
    return {p.x, p.y, snap_to_quarter_turn(wrap_angle(snap_to_quarter_turn(pose.theta) + turns_ * kQuarterTurn))};
  }

 private:
  Vec2 origin_;
  int turns_ = 0;
};

class SceneReader {
 public:
  Scene read(ConfigNode root) {
    scene_.name = root.text("name");
    scene_.description = root.text("description");
    read_starts(root.at("starts"));
    if (root.has("rooms")) read_rooms(root.at("rooms"));
    read_walls(root.at("walls"));
    if (root.has("objects")) read_objects(root.at("objects"));
    root.finish();
    check_rooms(draft_);
    check_walls(draft_);

    close_corners();
    cut_doorways();
    find_bounds();
    check_objects(draft_);
    check_places(draft_);
    return std::move(scene_);
  }

 private:
  void read_starts(const ConfigNode& list) {
    draft_.starts = list.items();
    if (draft_.starts.empty()) list.fail("a scene needs at least one start");
    const ConfigNode& first = draft_.starts.front();
    Pose2D start = first.pose();
    start.theta = snap_to_quarter_turn(start.theta);
    if (std::fabs(std::remainder(start.theta, kQuarterTurn)) > 1e-9) {
      first.fail("the first start must head along an axis: rooms are rectangles along the scene's axes");
    }
    from_file_ = SceneFromFile(start);
    for (const ConfigNode& node : draft_.starts) scene_.starts.push_back(from_file_(node.pose()));
  }

  void read_rooms(const ConfigNode& list) {
    for (ConfigNode node : list.items()) {
      Room room;
      room.name = node.text("name");
      const Vec2 low = node.at("min").vec2();
      const Vec2 high = node.at("max").vec2();
      if (high.x - low.x < kSmallestRoom || high.y - low.y < kSmallestRoom) {
        node.fail(fmt::format("room '{}' is inside out or less than {} m wide", room.name, kSmallestRoom));
      }
      room.floor = node.choice("floor", kFloors);
      const Vec2 anchor = node.has("anchor") ? node.at("anchor").vec2() : 0.5 * (low + high);
      if (anchor.x < low.x || anchor.y < low.y || anchor.x > high.x || anchor.y > high.y) {
        node.at("anchor").fail(fmt::format("the anchor of '{}' is outside the room", room.name));
      }
      node.finish();

      const Vec2 a = from_file_(low);
      const Vec2 b = from_file_(high);
      room.min = {std::min(a.x, b.x), std::min(a.y, b.y)};
      room.max = {std::max(a.x, b.x), std::max(a.y, b.y)};
      room.anchor = from_file_(anchor);
      scene_.rooms.push_back(room);
      draft_.rooms.push_back(node);
    }
  }

  void read_walls(const ConfigNode& list) {
    for (ConfigNode node : list.items()) {
      WallDraft draft{.wall = {}, .doorways = {}, .node = node};
      draft.wall.a = from_file_(node.at("a").vec2());
      draft.wall.b = from_file_(node.at("b").vec2());
      draft.wall.thickness = node.has("thickness") ? node.number_in("thickness", 0.02, 1.0) : 0.12;
      draft.wall.height = node.has("height") ? node.number_in("height", 0.3, 20.0) : 2.6;
      if (!(distance(draft.wall.a, draft.wall.b) > draft.wall.thickness)) {
        node.fail("a wall must be longer than it is thick");
      }
      if (node.has("doors")) read_doors(node.at("doors"), draft);
      node.finish();
      draft_.walls.push_back(std::move(draft));
    }
    if (draft_.walls.empty()) list.fail("a scene needs at least one wall");
  }

  void read_doors(const ConfigNode& list, WallDraft& draft) {
    const double length = distance(draft.wall.a, draft.wall.b);
    for (ConfigNode node : list.items()) {
      Door door;
      door.name = node.text("name");
      door.width = node.number_in("width", 0.3, 10.0);
      const double at = node.number("at");
      node.finish();

      const Doorway doorway{at - 0.5 * door.width, at + 0.5 * door.width};
      if (door.width > length) node.fail(fmt::format("door '{}' is wider than its wall ({:.2f} m)", door.name, length));
      if (doorway.from < 0.0 || doorway.to > length) {
        node.fail(fmt::format("door '{}' reaches beyond its wall, which is {:.2f} m long", door.name, length));
      }
      for (const Doorway& other : draft.doorways) {
        if (doorway.from < other.to && other.from < doorway.to) {
          node.fail(fmt::format("door '{}' overlaps another door of its wall", door.name));
        }
      }
      if (std::ranges::find(scene_.doors, door.name, &Door::name) != scene_.doors.end()) {
        node.fail(fmt::format("there are two doors named '{}'", door.name));
      }
      door.center = draft.wall.a + (at / length) * (draft.wall.b - draft.wall.a);
      draft.doorways.push_back(doorway);
      scene_.doors.push_back(door);
    }
    std::ranges::sort(draft.doorways, {}, &Doorway::from);
  }

  void read_objects(const ConfigNode& list) {
    std::map<std::string, int> count;
    std::set<std::string> names;
    for (ConfigNode node : list.items()) {
      Object object;
      object.category = node.text("category");
      object.prisms = library_.prisms(node.at("category"), node.at("shape"));
      object.pose = from_file_(node.at("pose").pose());
      object.name = node.text("name", fmt::format("{}_{}", object.category, ++count[object.category]));
      node.finish();
      if (!names.insert(object.name).second) node.fail(fmt::format("there are two objects named '{}'", object.name));
      scene_.objects.push_back(std::move(object));
      draft_.objects.push_back(node);
    }
  }

  // Where walls meet end to end at an angle, the first of them is made longer to fill the corner.
  void close_corners() {
    for (std::size_t i = 0; i < draft_.walls.size(); ++i) {
      WallDraft& draft = draft_.walls[i];
      for (std::size_t j = i + 1; j < draft_.walls.size(); ++j) {
        const Wall& next = draft_.walls[j].wall;
        if (parallel(draft.wall, next)) continue;
        if (draft.wall.a == next.a || draft.wall.a == next.b) draft.before_a = 0.5 * next.thickness;
        if (draft.wall.b == next.a || draft.wall.b == next.b) draft.after_b = 0.5 * next.thickness;
      }
    }
  }

  void cut_doorways() {
    for (const WallDraft& draft : draft_.walls) {
      const double length = distance(draft.wall.a, draft.wall.b);
      const Vec2 along = (1.0 / length) * (draft.wall.b - draft.wall.a);
      double from = -draft.before_a;
      const auto add_piece = [&](double to) {
        if (to - from < kSmallestPiece) return;
        Wall piece = draft.wall;
        piece.a = draft.wall.a + from * along;
        piece.b = draft.wall.a + to * along;
        scene_.walls.push_back(piece);
      };
      for (const Doorway& doorway : draft.doorways) {
        add_piece(doorway.from);
        from = doorway.to;
      }
      add_piece(length + draft.after_b);
    }
  }

  void find_bounds() {
    scene_.min = scene_.max = scene_.walls.front().a;
    for (const Wall& wall : scene_.walls) {
      const auto [low, high] = bounds(solid_of(wall));
      scene_.min = {std::min(scene_.min.x, low.x), std::min(scene_.min.y, low.y)};
      scene_.max = {std::max(scene_.max.x, high.x), std::max(scene_.max.y, high.y)};
    }
  }

  Draft draft_;
  Scene& scene_ = draft_.scene;
  SceneFromFile from_file_;
  ObjectLibrary library_;
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
