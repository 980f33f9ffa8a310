// Scenes, as data for drawing and for choosing goals.
#include "threewe/scene/scene.hpp"

#include <array>
#include <memory>
#include <optional>
#include <string>

#include <nanobind/stl/shared_ptr.h>

#include "bindings.hpp"
#include "core/exact.hpp"
#include "core/names.hpp"
#include "named_enum.hpp"
#include "scene/coverage.hpp"
#include "scene/episodes.hpp"
#include "scene/scene_tables.hpp"
#include "threewe/hardware/profile.hpp"
#include "threewe/map/occupancy_grid.hpp"
#include "threewe/scene/generator.hpp"
#include "value.hpp"

namespace {

using namespace threewe;
using scene::Door, scene::Episode, scene::Object, scene::Patch, scene::Person, scene::Prism, scene::Room, scene::Scene,
    scene::SceneTables, scene::Wall;

/// The corners of a prism, seen from above, in the frame of its object.
std::vector<Vec2> outline(const Prism& prism) {
  constexpr int kCorners = 24;
  std::vector<Vec2> corners;
  if (prism.shape == Prism::Shape::box) {
    const double x = prism.length / 2;
    const double y = prism.width / 2;
    for (const Vec2 corner : {Vec2{x, -y}, Vec2{x, y}, Vec2{-x, y}, Vec2{-x, -y}})
      corners.push_back(prism.pose * corner);
  } else {
    for (int i = 0; i < kCorners; ++i) {
      corners.push_back(prism.pose * rotate({prism.radius, 0.0}, 2 * exact::kPi * i / kCorners));
    }
  }
  return corners;
}

void bind_parts(nb::module_& m) {
  nb::class_<Prism> prism(m, "Prism", "A vertical prism over a rectangle or a disc, in the frame of its object.");
  NamedEnum<Prism::Shape>(prism, "Shape").value("box", Prism::Shape::box).value("cylinder", Prism::Shape::cylinder);
  prism.def(Value())
      .def_ro("shape", &Prism::shape)
      .def_ro("pose", &Prism::pose, "of its middle")
      .def_ro("length", &Prism::length, "[m] along x, of a box")
      .def_ro("width", &Prism::width, "[m] along y, of a box")
      .def_ro("radius", &Prism::radius, "[m], of a cylinder")
      .def_ro("z_min", &Prism::z_min, "[m]")
      .def_ro("z_max", &Prism::z_max, "[m]")
      .def_ro("material", &Prism::material)
      .def("outline", &outline, "Its corners seen from above, counter-clockwise [m]; a disc has 24.");
  nb::class_<Wall>(m, "Wall", "A straight wall of some thickness: the piece between two doorways.")
      .def(Value())
      .def_ro("a", &Wall::a, "(x, y) [m]")
      .def_ro("b", &Wall::b, "(x, y) [m]")
      .def_ro("thickness", &Wall::thickness, "[m]")
      .def_ro("height", &Wall::height, "[m]");
  nb::class_<Door>(m, "Door", "A doorway in a wall.")
      .def(Value())
      .def_ro("name", &Door::name)
      .def_ro("center", &Door::center, "(x, y) [m]")
      .def_ro("width", &Door::width, "[m]");
  nb::class_<Room>(m, "Room", "A named room: an axis-aligned rectangle.")
      .def(Value())
      .def_ro("name", &Room::name)
      .def_ro("min", &Room::min, "(x, y) [m]")
      .def_ro("max", &Room::max, "(x, y) [m]")
      .def_ro("floor", &Room::floor, "its material")
      .def_ro("anchor", &Room::anchor, "(x, y) [m] where a robot can stand")
      .def("__repr__", [](const Room& room) {
        return fmt::format("Room('{}', anchor=({:.2f}, {:.2f}))", room.name, room.anchor.x, room.anchor.y);
      });
  nb::class_<Patch>(m, "Patch", "A patch of floor with a friction of its own: an axis-aligned rectangle.")
      .def(Value())
      .def_ro("name", &Patch::name)
      .def_ro("min", &Patch::min, "(x, y) [m]")
      .def_ro("max", &Patch::max, "(x, y) [m]")
      .def_ro("floor", &Patch::floor, "its material")
      .def_ro("friction", &Patch::friction, "times the friction that wheels have on a hard floor");
  nb::class_<Person>(m, "Person", "A person who walks round and round a closed route.")
      .def(Value())
      .def_ro("name", &Person::name)
      .def_ro("route", &Person::route, "waypoints (x, y) [m]; after the last comes the first")
      .def_ro("speed", &Person::speed, "[m/s]")
      .def_ro("radius", &Person::radius, "[m]");
  nb::class_<Object>(m, "Object", "A piece of furniture.")
      .def(Value())
      .def_ro("name", &Object::name, "unique in its scene, such as `chair_3`")
      .def_ro("category", &Object::category, "such as `chair`")
      .def_ro("shape", &Object::shape, "which of the category's shapes, such as `wooden`")
      .def_ro("pose", &Object::pose)
      .def_ro("prisms", &Object::prisms)
      .def("__repr__", [](const Object& object) {
        return fmt::format("Object('{}', {} at ({:.2f}, {:.2f}))", object.name, object.category, object.pose.x,
                           object.pose.y);
      });
}

std::shared_ptr<SceneTables> make_tables(const Scene& scene, const RobotProfile& profile) {
  return std::make_shared<SceneTables>(std::make_shared<const Scene>(scene), profile.body.footprint,
                                       profile.body.height);
}

/// A coverage meter whose caller gives the base's poses.
class BaseCoverageMeter {
 public:
  BaseCoverageMeter(const Scene& scene, const RobotProfile& profile)
      : base_from_lidar_(spec(profile).base_from_lidar), meter_(make_tables(scene, profile), spec(profile).height) {}

  void observe(const Pose2D& scene_from_base) { meter_.observe(scene_from_base * base_from_lidar_); }

  double coverage(const map::OccupancyGrid& grid, const Pose2D& scene_from_map) const {
    const Pose2D map_from_scene = inverse(scene_from_map);
    return meter_.coverage([&](Vec2 point) {
      const std::int8_t value = grid.at(grid.cell(map_from_scene * point));
      return value >= 0 && value <= map::OccupancyGrid::kFreeThreshold;
    });
  }

  double crossed() const { return meter_.crossed(); }

 private:
  static const LidarSpec& spec(const RobotProfile& profile) {
    if (!profile.lidar)
      throw HardwareError(fmt::format("coverage is measured with a lidar, which {} lacks", profile.name));
    return *profile.lidar;
  }

  Pose2D base_from_lidar_;
  scene::CoverageMeter meter_;
};

void bind_measures(nb::module_& m) {
  nb::class_<Episode>(m, "Episode", "One task: from a pose to a place, in the scene's frame.")
      .def(Value())
      .def_ro("start", &Episode::start)
      .def_ro("goal", &Episode::goal, "(x, y) [m]")
      .def_ro("geodesic", &Episode::geodesic, "[m], from start to goal")
      .def_ro("seed", &Episode::seed, "for all else that is drawn in this episode");
  nb::class_<SceneTables>(m, "SceneTables",
                          "A scene as one robot meets it: where it can be, and how far it is from place to place.")
      .def(nb::new_(&make_tables), "scene"_a, "profile"_a)
      .def("collides", &SceneTables::collides, "pose"_a, "Whether the footprint touches an obstacle.")
      .def("clearance", &SceneTables::clearance, "pose"_a,
           "Distance [m] between the footprint and the nearest obstacle.")
      .def("geodesic", &SceneTables::geodesic, "a"_a, "b"_a,
           "Length [m] of the shortest path for the footprint; infinity where there is none.")
      .def(
          "geodesics",
          [](const SceneTables& tables, const std::vector<Vec2>& points, Vec2 target) {
            const scene::GeodesicField field = tables.geodesic_field(target);
            std::vector<double> lengths;
            for (const Vec2 point : points) lengths.push_back(field.length_from(point));
            return lengths;
          },
          "points"_a, "target"_a, WithoutGil(), "The same from each of many points [m], for the cost of one.")
      .def("sample_free_pose", &SceneTables::sample_free_pose, "seed"_a,
           "A pose with 5 cm to spare around the footprint: a pure function of the seed.")
      .def("sample_episode", &scene::sample_episode, "seed"_a, "index"_a = 0,
           "Start and goal uniform over free cells, 2 to 15 m apart by the shortest path, every fifth with a detour.");
  nb::class_<BaseCoverageMeter>(
      m, "CoverageMeter",
      "How much of a scene a robot has really seen and mapped: the share of reachable 5 cm cells that a\n"
      "noise-free ray from the true pose crossed within 8 m and that its own map marks free within 10 cm.")
      .def(nb::init<const Scene&, const RobotProfile&>(), "scene"_a, "profile"_a, WithoutGil(),
           "Raises HardwareError for a robot without a lidar.")
      .def("observe", &BaseCoverageMeter::observe, "scene_from_base"_a, WithoutGil(),
           "Casts 360 rays, given the base's true pose.")
      .def(
          "coverage", &BaseCoverageMeter::coverage, "grid"_a, "scene_from_map"_a = Pose2D{}, WithoutGil(),
          "The share, 0 to 1, that was crossed and is marked free, given the robot's own map and where its frame lies.")
      .def("crossed", &BaseCoverageMeter::crossed, WithoutGil(), "The share, 0 to 1, that was crossed.");
}

}  // namespace

void init_scene(nb::module_& m) {
  bind_parts(m);
  nb::class_<Scene>(m, "Scene",
                    "Walls, doors, named rooms and furniture. Its origin is its start pose; x along the start heading.")
      .def_static("load", &Scene::load, "name"_a,
                  "Reads a scene by name, or from a file that ends in .yaml. Raises ConfigError with file and line.")
      .def_static("parse", &Scene::parse, "text"_a, "name"_a,
                  "Reads a scene from YAML; `name` stands for it in messages. Raises ConfigError with the line.")
      .def_static(
          "generate",
          [](std::uint64_t seed, double difficulty, Vec2 size) {
            return scene::generate(seed, {.difficulty = difficulty, .size = size});
          },
          "seed"_a, nb::kw_only(), "difficulty"_a = 0.5, "size"_a = Vec2{14.0, 10.0},
          "A building with furnished rooms, drawn from a seed: all rooms can be reached by every robot. `difficulty` "
          "0\n"
          "to 1 is from sparse to crowded, `size` is (x, y) [m], 6 to 40 each. The same on every machine.")
      .def(
          "__deepcopy__", [](nb::object self, const nb::handle&) { return self; }, "memo"_a,
          "Itself: a scene never changes.")
      .def("__getstate__", &scene::to_yaml)
      .def("__setstate__",
           [](Scene& self, const std::string& yaml) { new (&self) Scene(Scene::parse(yaml, "a pickled scene")); })
      .def(
          "to_yaml",
          [](Scene scene, std::optional<std::string> name) {
            if (name && !is_name(*name)) throw ContractError(fmt::format("name: {}", not_a_name(*name)));
            if (name) scene.name = *name;
            return scene::to_yaml(scene);
          },
          "name"_a = nb::none(),
          "The scene as text, under another name if one is given: that of the file it is saved in.")
      .def_ro("name", &Scene::name)
      .def_ro("description", &Scene::description)
      .def_ro("ceiling", &Scene::ceiling, "False under the open sky.")
      .def_ro("min", &Scene::min, "(x, y) [m] of the box around all walls")
      .def_ro("max", &Scene::max, "(x, y) [m]")
      .def_ro("walls", &Scene::walls)
      .def_ro("doors", &Scene::doors)
      .def_ro("rooms", &Scene::rooms)
      .def_ro("patches", &Scene::patches)
      .def_ro("objects", &Scene::objects)
      .def_ro("people", &Scene::people)
      .def_ro("starts", &Scene::starts, "Where robots start; the first is the origin.")
      .def("room", &Scene::room, "name"_a, nb::rv_policy::reference_internal,
           "A room by name. Raises ConfigError naming the nearest right one.")
      .def("room_at", &Scene::room_at, "point"_a, nb::rv_policy::reference_internal,
           "The room that holds a point (x, y) [m], or None.")
      .def("friction_at", &Scene::friction_at, "point"_a,
           "How well wheels hold at a point (x, y) [m], times their friction on a hard floor.")
      .def("__repr__", [](const Scene& scene) {
        return fmt::format("Scene('{}', {:.0f} x {:.0f} m, {} rooms, {} objects)", scene.name,
                           scene.max.x - scene.min.x, scene.max.y - scene.min.y, scene.rooms.size(),
                           scene.objects.size());
      });
  m.def("scene_names", &scene::scene_names, "The names of all scenes.");
  bind_measures(m);
}
