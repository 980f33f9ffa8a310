// Benchmarks: baselines, metrics, drives that are logged and replayed, and where ObjectNav succeeds.
#include <memory>
#include <span>
#include <utility>

#include <nanobind/stl/shared_ptr.h>

#include "benchmark/drive.hpp"
#include "benchmark/nearest_frontier.hpp"
#include "benchmark/optimistic_replanning.hpp"
#include "bindings.hpp"
#include "one_thread.hpp"
#include "scene/scene_tables.hpp"
#include "task/object_nav.hpp"
#include "task/stop_task.hpp"
#include "task/vln.hpp"
#include "threewe/env/robot/robot_env.hpp"
#include "value.hpp"

using namespace threewe;
using benchmark::DriveLog, benchmark::ReferenceDrive, benchmark::ReferenceExploration, benchmark::Replay,
    benchmark::TrueDrive;
using task::ObjectNav, task::ObjectNavEpisode, task::Vln, task::VlnEpisode;

namespace {

using Rows = nb::ndarray<nb::numpy, double, nb::shape<-1, 3>>;
using GivenRows = nb::ndarray<const double, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;

/// A copy of numbers as an array of Python's own.
Rows rows_of(std::vector<double> numbers) {
  auto* data = new std::vector<double>(std::move(numbers));
  const nb::capsule owner(data, [](void* p) noexcept { delete static_cast<std::vector<double>*>(p); });
  return Rows(data->data(), {data->size() / 3, 3}, owner);
}

Rows commands_of(const TrueDrive& drive) {
  std::vector<double> numbers;
  for (const Velocity& v : drive.drive().commands) numbers.insert(numbers.end(), {v.vx, v.vy, v.omega});
  return rows_of(std::move(numbers));
}

Rows poses_of(const TrueDrive& drive) {
  std::vector<double> numbers;
  for (const Pose2D& p : drive.drive().poses) numbers.insert(numbers.end(), {p.x, p.y, p.theta});
  return rows_of(std::move(numbers));
}

/// What the robot's camera truly shows at the end of a drive that makes it right to stop there.
std::vector<std::string> found(const ObjectNav& task, const RobotProfile& profile, const std::string& category,
                               const TrueDrive& drive) {
  const scene::TruthView& truth = drive.truth();
  SemanticImage seen;
  const auto look = [&]() -> std::span<const std::int16_t> {
    const CameraSpec& camera = *profile.camera;
    seen = truth.look(camera.intrinsics(), truth.true_pose() * camera.base_from_camera, camera.mount_height, false);
    return seen.ids;
  };
  std::vector<std::string> names;
  for (const std::size_t object : task.found(task::object_goal(category), truth.true_pose(), look))
    names.push_back(truth.scene().objects.at(object).name);
  return names;
}

void bind_drives(nb::module_& m) {
  nb::class_<TrueDrive>(m, "TrueDrive", "A drive tick by tick (20 ms), from robot time 0. Privileged.")
      .def(
          "__len__", [](const TrueDrive& d) { return d.drive().commands.size(); }, "ticks")
      .def_prop_ro("commands", &commands_of, nb::rv_policy::automatic,
                   "(N, 3) that left the gate [m/s, m/s, rad/s], body frame")
      .def_prop_ro("poses", &poses_of, nb::rv_policy::automatic,
                   "(N, 3) true poses x, y [m], theta [rad] in the scene's frame")
      .def_prop_ro(
          "length", [](const TrueDrive& d) { return d.drive().length; }, "[m] driven")
      .def_prop_ro(
          "collision_speed", [](const TrueDrive& d) { return d.drive().collision_speed; },
          "[m/s] of the fastest contact")
      .def(
          "contacts",
          [](const TrueDrive& d, const std::shared_ptr<scene::SceneTables>& tables) {
            return benchmark::contacts(d.drive(), *tables);
          },
          "tables"_a, WithoutGil(), "How often the body came to touch walls or furniture.");
  nb::class_<DriveLog, TrueDrive>(m, "DriveLog", "Logs the robot of a simulated world at every tick. Privileged.")
      .def(
          "__init__",
          [](DriveLog* self, Guarded<World>& world) {
            const OneThread::Use use(world.one_thread);
            new (self) DriveLog(world);
          },
          "world"_a, nb::keep_alive<1, 2>())
      .def(
          "__init__", [](DriveLog* self, env::RobotEnv& env) { new (self) DriveLog(env.world()); }, "env"_a,
          nb::keep_alive<1, 2>())
      .def("end", &DriveLog::end, "What follows is not logged.");
  nb::class_<Replay, TrueDrive>(m, "Replay",
                                "A drive again: its commands, below autonomy and gate, in a world made anew.")
      .def(
          "__init__",
          [](Replay* self, const RobotOptions& robot, const GivenRows& commands) {
            backend::WorldOptions options;
            options.scene = robot.scene;
            options.robots = {robot.hardware};
            options.noise = robot.noise;
            options.seed = robot.seed;
            options.randomization = robot.randomization;
            if (robot.start_pose) options.poses = {*robot.start_pose};
            std::vector<Velocity> velocities(commands.shape(0));
            for (std::size_t i = 0; i < velocities.size(); ++i) {
              velocities[i] = {commands(i, 0), commands(i, 1), commands(i, 2)};
            }
            const nb::gil_scoped_release other_threads_run;
            new (self) Replay(robot.backend, options, velocities);
          },
          "robot"_a, "commands"_a,
          "`commands`: (N, 3) [m/s, m/s, rad/s], one a tick. Raises ContractError for what the base cannot drive.");
}

void bind_vln(nb::module_& m) {
  nb::class_<VlnEpisode>(m, "VlnEpisode", "One instruction to be followed.")
      .def(Value())
      .def_ro("start", &VlnEpisode::start, "in the scene's frame")
      .def_ro("end", &VlnEpisode::end, "where the instruction ends, in the scene's frame")
      .def_ro("instruction", &VlnEpisode::instruction)
      .def_ro("geodesic", &VlnEpisode::geodesic, "[m], from start to end")
      .def_ro("seed", &VlnEpisode::seed, "for all else that is drawn in this episode");
  nb::class_<Vln>(m, "Vln", "Instructions of a scene, and where STOP is right. Privileged.")
      .def(
          "__init__", [](Vln* self, const std::shared_ptr<scene::SceneTables>& tables) { new (self) Vln(tables); },
          "tables"_a, WithoutGil(), "Raises ConfigError for a scene in which there is nowhere to go.")
      .def_prop_ro(
          "rooms", [](const Vln& task) { return task.map().rooms(); }, "what its rooms are called")
      .def("sample", &Vln::sample, "seed"_a, "index"_a = 0, WithoutGil())
      .def(
          "is_success",
          [](const Vln& task, const VlnEpisode& episode, Vec2 position) {
            return task.distance(episode.ending, position) <= task::kPathEndReach;
          },
          "episode"_a, "position"_a, "Whether STOP is right where the robot is.");
}

void bind_object_nav(nb::module_& m) {
  nb::class_<ObjectNavEpisode>(m, "ObjectNavEpisode", "One search for something of a kind.")
      .def(Value())
      .def_ro("start", &ObjectNavEpisode::start, "in the scene's frame")
      .def_prop_ro("category", [](const ObjectNavEpisode& e) { return std::string(task::kObjectGoals.at(e.goal)); })
      .def_ro("geodesic", &ObjectNavEpisode::geodesic, "[m], from start to the nearest place of success")
      .def_ro("seed", &ObjectNavEpisode::seed, "for all else that is drawn in this episode");
  nb::class_<ObjectNav>(m, "ObjectNav", "What can be looked for in a scene, and from where STOP is right. Privileged.")
      .def(
          "__init__",
          [](ObjectNav* self, const std::shared_ptr<scene::SceneTables>& tables, const RobotProfile& profile) {
            new (self) ObjectNav(tables, profile);
          },
          "tables"_a, "profile"_a, WithoutGil(), "Raises HardwareError for a robot without a camera.")
      .def_prop_ro(
          "goals",
          [](const ObjectNav& task) {
            std::vector<std::string> names;
            for (const std::size_t goal : task.goals()) names.emplace_back(task::kObjectGoals.at(goal));
            return names;
          },
          "the kinds that can be looked for here")
      .def("sample", &ObjectNav::sample, "seed"_a, "index"_a = 0, "category"_a = "",
           "Episode `index` of a seed. Raises ConfigError for a kind that is not among the goals.")
      .def(
          "sample_in_sight", &ObjectNav::sample_in_sight, "seed"_a, "index"_a = 0, "category"_a = "", WithoutGil(),
          "The same with something of the kind in sight, and nothing of it nearer than 1.5 m. Raises ConfigError where "
          "there is no such start.")
      .def(
          "in_sight",
          [](const ObjectNav& task, const Pose2D& base) {
            std::vector<std::string> names;
            for (const std::size_t goal : task.in_sight(base)) names.emplace_back(task::kObjectGoals.at(goal));
            return names;
          },
          "base"_a,
          "The kinds of which the camera shows something at most 5 m away, as large and as little hidden as success "
          "asks for.")
      .def(
          "distance",
          [](const ObjectNav& task, const std::string& category, Vec2 base) {
            return task.distance(task::object_goal(category), base);
          },
          "category"_a, "base"_a, "[m] to the nearest place of success; infinity without one.")
      .def("found", &found, "profile"_a, "category"_a, "drive"_a,
           "The names of the things that make STOP right where a drive has come to; none where it is wrong.");
}

}  // namespace

void init_benchmark(nb::module_& m) {
  bind_drives(m);
  bind_object_nav(m);
  bind_vln(m);
  nb::class_<ReferenceDrive>(m, "ReferenceDrive", "A drive as it could have been.")
      .def(Value())
      .def_ro("reached", &ReferenceDrive::reached)
      .def_ro("length", &ReferenceDrive::length, "[m]")
      .def_ro("duration", &ReferenceDrive::duration, "[s] at the speed limit")
      .def("__repr__", [](const ReferenceDrive& d) {
        return fmt::format("ReferenceDrive({}, {:.2f} m in {:.2f} s)", d.reached ? "reached" : "not reached", d.length,
                           d.duration);
      });
  nb::class_<ReferenceExploration>(m, "ReferenceExploration", "An exploration as it could have been.")
      .def(Value())
      .def_ro("coverage", &ReferenceExploration::coverage, "the share, 0 to 1, of what can be reached")
      .def_ro("length", &ReferenceExploration::length, "[m]")
      .def_ro("duration", &ReferenceExploration::duration, "[s] at the speed limit, until no frontier is left")
      .def("__repr__", [](const ReferenceExploration& e) {
        return fmt::format("ReferenceExploration({:.1f} % covered, {:.2f} m in {:.2f} s)", 100.0 * e.coverage, e.length,
                           e.duration);
      });
  m.def("spl", &task::success_weighted_by_path_length, "success"_a, "shortest"_a, "driven"_a,
        "Success weighted by path length (Anderson et al. 2018): 0 for a failure, else the shortest length over the\n"
        "one driven, at most 1; 1 for a success where the shortest length is 0. Lengths in [m].");
  m.def("optimistic_replanning", &benchmark::optimistic_replanning, "tables"_a, "profile"_a, "start"_a, "goal"_a,
        WithoutGil(),
        "A drive to `goal` [m] in a place of which nothing is known at first, as no robot can expect to beat it: with "
        "a perfect\n"
        "pose and a lidar without noise, along shortest paths for the inscribed radius through all that is not known\n"
        "to be an obstacle. `start` and `goal` (x, y) in the scene's frame. Raises HardwareError without a lidar,\n"
        "ContractError for a place outside of the scene.");
  m.def(
      "nearest_frontier",
      [](const std::shared_ptr<scene::SceneTables>& tables, const RobotProfile& profile, const Pose2D& start) {
        return benchmark::nearest_frontier(tables, profile, start);
      },
      "tables"_a, "profile"_a, "start"_a, WithoutGil(),
      "An exploration to the nearest frontier (Yamauchi 1997), again and again until none can be reached: with a\n"
      "perfect pose and a lidar without noise, along shortest paths. Raises HardwareError without a lidar, "
      "ContractError for a\n"
      "start outside of the scene.");
}
