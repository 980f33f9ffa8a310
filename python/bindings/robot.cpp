// Worlds, robots, motions and robot time.
#include <memory>

#include <nanobind/stl/array.h>
#include <nanobind/stl/function.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/variant.h>

#include "bindings.hpp"
#include "named_enum.hpp"
#include "one_thread.hpp"
#include "threewe/robot/runtime.hpp"
#include "threewe/robot/simulation.hpp"
#include "threewe/robot/warning.hpp"
#include "threewe/robot/world.hpp"
#include "threewe/scene/scene.hpp"
#include "value.hpp"

template <>
inline constexpr const char* kSecondThread<threewe::World> =
    "a robot may be used on the thread of its event loop only; from other threads use loop.call_soon_threadsafe(...), "
    "asyncio.run_coroutine_threadsafe(...) or threewe.sync.Robot";

using OneThreadWorld = Guarded<threewe::World>;

template <>
OneThread& thread_of(const threewe::Runtime& robot) {
  return static_cast<const OneThreadWorld&>(robot.world()).one_thread;
}

template <>
OneThread& thread_of(const threewe::Simulation& truth) {
  return static_cast<const OneThreadWorld&>(truth.world()).one_thread;
}

namespace {

using namespace threewe;
using safety::Intervention;
using slam::LocalizationState;
using slam::PoseEstimate;

/// What an observer sees, copied, so that it may keep it.
struct Tick {
  double now = 0.0;
  std::vector<Sample> samples;
  PoseEstimate pose;
  Velocity requested;
  Velocity commanded;
  Intervention intervention{};
};

Tick tick_of(const TickView& view) {
  return {to_seconds(view.now),
          {view.samples.begin(), view.samples.end()},
          view.pose,
          view.requested,
          view.commanded.command,
          view.commanded.intervention};
}

/// The state of a world.
struct Snapshot {
  std::shared_ptr<const World::Snapshot> state;
};

std::optional<Duration> timeout_of(std::optional<double> timeout) {
  if (timeout && *timeout == 0.0) throw ContractError("timeout must be a finite number of seconds > 0, got 0");
  return timeout ? std::optional(seconds("timeout", *timeout)) : std::nullopt;
}

void bind_results(nb::module_& m) {
  NamedEnum<Intervention>(m, "Intervention", "Why the safety gate changed a command.")
      .value("none", Intervention::none)
      .value("limited", Intervention::limited)
      .value("slowed_for_obstacle", Intervention::slowed_for_obstacle)
      .value("stopped_for_obstacle", Intervention::stopped_for_obstacle)
      .value("stale_sensors", Intervention::stale_sensors)
      .value("estop", Intervention::estop);

  NamedEnum<SensorFault>(m, "SensorFault", "A fault of a sensor.")
      .value("none", SensorFault::none, "Nothing.")
      .value("silent", SensorFault::silent, "Nothing has arrived for too long.")
      .value("frozen", SensorFault::frozen, "The same reading again and again, while the robot moves.")
      .value("implausible", SensorFault::implausible, "A reading that no such sensor can make, such as NaN.")
      .value("wrong_stamps", SensorFault::wrong_stamps, "Times that run backwards, or come from the future.")
      .value("late", SensorFault::late, "Readings arrive much later than they used to.")
      .value("noisy", SensorFault::noisy, "Readings are noisier than they used to be.")
      .value("shifted", SensorFault::shifted, "All ranges are too long or too short by the same.")
      .value("blind", SensorFault::blind,
             "So many beams are invalid side by side that the robot would fit between two that are not.")
      .value("contradicted", SensorFault::contradicted, "Other sensors say otherwise.");

  nb::class_<SensorHealth>(m, "SensorHealth", "How one sensor is.")
      .def(Value())
      .def_ro("name", &SensorHealth::name)
      .def_prop_ro("ok", &SensorHealth::ok, "nothing is wrong")
      .def_ro("fault", &SensorHealth::fault)
      .def_ro("detail", &SensorHealth::detail, "says more; may be empty")
      .def_prop_ro(
          "since", [](const SensorHealth& h) { return to_seconds(h.since); },
          "[s] of robot time when the fault was noticed, or was over")
      .def_ro("needed", &SensorHealth::needed, "the robot stands still while this sensor is at fault")
      .def("__repr__", [](const SensorHealth& h) {
        return fmt::format("SensorHealth('{}': {}{})", h.name, h.ok() ? "ok" : to_string(h.fault),
                           h.detail.empty() ? "" : ", " + h.detail);
      });

  nb::class_<MoveResult>(m, "MoveResult", "How a motion ended. `map` frame.")
      .def(Value())
      .def_ro("success", &MoveResult::success)
      .def_ro("reason", &MoveResult::reason)
      .def_ro("detail", &MoveResult::detail, "says more about a failure; may be empty")
      .def_ro("pose", &MoveResult::pose, "where the robot estimates that it is")
      .def_ro("position_uncertainty", &MoveResult::position_uncertainty,
              "[m] radius around `pose` that holds the true position with 95 %, by the robot's own covariance")
      .def_ro("distance_to_goal", &MoveResult::distance_to_goal, "[m], by its own estimate")
      .def_ro("distance", &MoveResult::distance, "[m] driven, by its own estimate")
      .def_ro("duration", &MoveResult::duration, "[s] of robot time")
      .def("raise_for_failure", &MoveResult::raise_for_failure,
           "Raises the error that matches `reason`; nothing after success.")
      .def("__bool__", [](const MoveResult& r) { return r.success; })
      .def("__repr__", [](const MoveResult& r) {
        return fmt::format("MoveResult({}{}, {:.2f} m to the goal, {:.2f} m driven in {:.2f} s)",
                           nav::to_string(r.reason), r.detail.empty() ? "" : ": " + r.detail, r.distance_to_goal,
                           r.distance, r.duration);
      });

  nb::class_<ExploreResult>(m, "ExploreResult", "How an exploration ended.")
      .def(Value())
      .def_ro("success", &ExploreResult::success, "nothing that can be reached is left to see")
      .def_ro("reason", &ExploreResult::reason)
      .def_ro("detail", &ExploreResult::detail, "says more about a failure; may be empty")
      .def_ro("explored_area", &ExploreResult::explored_area, "[m^2] known to be free")
      .def_ro("distance", &ExploreResult::distance, "[m] driven, by its own estimate")
      .def_ro("duration", &ExploreResult::duration, "[s] of robot time")
      .def("raise_for_failure", &ExploreResult::raise_for_failure,
           "Raises the error that matches `reason`; nothing after success.")
      .def("__bool__", [](const ExploreResult& r) { return r.success; })
      .def("__repr__", [](const ExploreResult& r) {
        return fmt::format("ExploreResult({}{}, {:.1f} m^2 free, {:.2f} m driven in {:.2f} s)",
                           nav::to_string(r.reason), r.detail.empty() ? "" : ": " + r.detail, r.explored_area,
                           r.distance, r.duration);
      });
}

void bind_views(nb::module_& m) {
  NamedEnum<LocalizationState>(m, "LocalizationState", "How far a robot knows where it is in its map.")
      .value("tracking", LocalizationState::tracking, "Scans fit the map where it is estimated to be.")
      .value("doubting", LocalizationState::doubting,
             "They fit, but the map that was given has long been contradicted; it is searched meanwhile.")
      .value("lost", LocalizationState::lost, "They do not fit: the whole map is searched.")
      .value("relocating", LocalizationState::relocating,
             "The search found one pose; the next scans decide whether it is right.");

  nb::class_<PoseEstimate>(m, "PoseEstimate", "What is known about the robot's pose at one moment.")
      .def(Value())
      .def_ro("stamp", &PoseEstimate::stamp, "[s] of robot time")
      .def_ro("odom_from_base", &PoseEstimate::odom_from_base, "smooth: wheels and gyro, never jumps")
      .def_ro("map_from_odom", &PoseEstimate::map_from_odom, "moves when a scan or a loop closure corrects the drift")
      .def_prop_ro("map_from_base", &PoseEstimate::map_from_base)
      .def_ro("velocity", &PoseEstimate::velocity, "in the body frame")
      .def_prop_ro(
          "covariance",
          [](const PoseEstimate& pose) { return ArrayView<double, nb::shape<3, 3>>(pose.covariance.data(), {3, 3}); },
          nb::rv_policy::reference_internal, "(3, 3) float64, of map_from_base: x, y [m], theta [rad]")
      .def_ro("state", &PoseEstimate::state)
      .def_prop_ro("lost", &PoseEstimate::lost, "whether the pose is no more than where it was last");

  nb::class_<Tick>(m, "TickView", "What an observer sees at the end of every tick.")
      .def(Value())
      .def_ro("now", &Tick::now, "[s] of robot time")
      .def_ro("samples", &Tick::samples, "that arrived in this tick")
      .def_ro("pose", &Tick::pose)
      .def_ro("requested", &Tick::requested, "before the safety gate")
      .def_ro("commanded", &Tick::commanded, "after it")
      .def_ro("intervention", &Tick::intervention, "why it changed the command")
      .def("__repr__",
           [](const Tick& t) { return fmt::format("TickView({:.2f} s, {} samples)", t.now, t.samples.size()); });
}

using HeightAndWidth = std::optional<std::pair<int, int>>;

const char* name_of(NoiseLevel noise) { return noise == NoiseLevel::ideal ? "ideal" : "realistic"; }

std::optional<ImageSize> image_size_of(const HeightAndWidth& size) {
  return size ? std::optional(ImageSize{size->second, size->first}) : std::nullopt;
}

std::shared_ptr<const map::OccupancyGrid> shared(const map::OccupancyGrid* map) {
  return map == nullptr ? nullptr : std::make_shared<const map::OccupancyGrid>(*map);
}

// What is left out is as in the C++ aggregates: their defaults are the only ones.
void bind_options(nb::module_& m) {
  const RobotOptions robot;
  nb::class_<RobotOptions>(m, "RobotOptions", "Where one robot is in a world of its own, and which.")
      .def(
          "__init__",
          [](RobotOptions* self, std::string backend, std::string hardware, std::string scene, std::string_view noise,
             std::uint64_t seed, bool realtime, const map::OccupancyGrid* map, std::optional<Pose2D> initial_pose,
             std::optional<Pose2D> start_pose, std::string_view localization, std::string_view navigation,
             const HeightAndWidth& image_size, std::string randomization) {
            new (self) RobotOptions{.backend = std::move(backend),
                                    .hardware = std::move(hardware),
                                    .scene = std::move(scene),
                                    .noise = noise_level(noise),
                                    .seed = seed,
                                    .realtime = realtime,
                                    .map = shared(map),
                                    .initial_pose = initial_pose,
                                    .start_pose = start_pose,
                                    .autonomy = autonomy_with(localization, navigation),
                                    .image_size = image_size_of(image_size),
                                    .randomization = std::move(randomization)};
          },
          nb::kw_only(), "backend"_a = robot.backend, "hardware"_a = robot.hardware, "scene"_a = robot.scene,
          "noise"_a = name_of(robot.noise), "seed"_a = robot.seed, "realtime"_a = robot.realtime,
          "map"_a.none() = nb::none(), "initial_pose"_a = nb::none(), "start_pose"_a = nb::none(),
          "localization"_a = robot.autonomy.localization, "navigation"_a = robot.autonomy.navigation,
          "image_size"_a = nb::none(), "randomization"_a = robot.randomization)
      .def_ro("backend", &RobotOptions::backend)
      .def_ro("hardware", &RobotOptions::hardware)
      .def_ro("scene", &RobotOptions::scene)
      .def_prop_ro("noise", [](const RobotOptions& o) { return name_of(o.noise); })
      .def_ro("seed", &RobotOptions::seed)
      .def_ro("realtime", &RobotOptions::realtime)
      .def_prop_ro(
          "map", [](const RobotOptions& o) { return o.map.get(); }, nb::rv_policy::copy)
      .def_ro("initial_pose", &RobotOptions::initial_pose, "in its `map` frame")
      .def_ro("start_pose", &RobotOptions::start_pose, "in the scene's frame")
      .def_prop_ro("localization", [](const RobotOptions& o) { return o.autonomy.localization; })
      .def_prop_ro("navigation", [](const RobotOptions& o) { return o.autonomy.navigation; })
      .def_prop_ro(
          "image_size",
          [](const RobotOptions& o) {
            return o.image_size ? HeightAndWidth({o.image_size->height, o.image_size->width}) : std::nullopt;
          },
          "(height, width) [px]")
      .def_ro("randomization", &RobotOptions::randomization);

  const World::Options world;
  nb::class_<World::Options>(m, "WorldOptions", "How a world of several robots is made.")
      .def(
          "__init__",
          [](World::Options* self, std::string backend, std::string scene, std::vector<std::string> robots,
             std::string_view noise, std::uint64_t seed, bool realtime, std::vector<Pose2D> start_poses,
             std::vector<Pose2D> initial_poses, const map::OccupancyGrid* map, std::string randomization) {
            World::Options options;
            options.backend = std::move(backend);
            options.scene = std::move(scene);
            options.robots = std::move(robots);
            options.noise = noise_level(noise);
            options.seed = seed;
            options.realtime = realtime;
            options.poses = std::move(start_poses);
            options.initial_poses = std::move(initial_poses);
            options.map = shared(map);
            options.randomization = std::move(randomization);
            new (self) World::Options(std::move(options));
          },
          nb::kw_only(), "backend"_a = world.backend, "scene"_a = world.scene, "robots"_a = world.robots,
          "noise"_a = name_of(world.noise), "seed"_a = world.seed, "realtime"_a = world.realtime,
          "start_poses"_a = world.poses, "initial_poses"_a = world.initial_poses, "map"_a.none() = nb::none(),
          "randomization"_a = world.randomization);
}

void bind_time(nb::module_& m) {
  nb::class_<Wait>(m, "Wait", "Something that becomes true at a tick.")
      .def_prop_ro("done", &Wait::done)
      .def_prop_ro("deadline", &Wait::deadline, "[s] when it was due")
      .def_prop_ro("creation", &Wait::creation, "counts the waits of one world");

  nb::class_<Motion, Wait>(m, "Motion", "A motion in progress.")
      .def_prop_ro("progress", &Motion::progress, nb::rv_policy::copy)
      .def("cancel", &Motion::cancel, "Ends it with `cancelled` and commands zero in the next period.")
      .def("result", &Motion::result, nb::rv_policy::copy)
      .def("explore_result", &Motion::explore_result);

  nb::class_<Snapshot>(m, "Snapshot", "Everything the future of a world depends on.")
      .def("__repr__", [](const Snapshot&) { return "Snapshot()"; });

  OneThreadClass<OneThreadWorld> bound(
      m, "World", "A backend world with a runtime for each of its robots. One thread at a time may use it.");
  bound
      .def(
          "__init__",
          [](OneThreadWorld* self, const World::Options& options) {
            const nb::gil_scoped_release other_threads_run;
            new (self) OneThreadWorld(options);
          },
          "options"_a)
      .def(
          "__init__",
          [](OneThreadWorld* self, const RobotOptions& robot) {
            const nb::gil_scoped_release other_threads_run;
            new (self) OneThreadWorld(robot);
          },
          "robot"_a, "The world of one robot.")
      .def_prop_ro("robot_count", &World::robot_count)
      .def_prop_ro(
          "simulated", [](World& world) { return world.truth_service() != nullptr; }, "whether it has a `Simulation`")
      .def("robot", nb::overload_cast<std::size_t>(&World::robot), "index"_a, nb::rv_policy::reference_internal)
      .def_prop_ro("now", &World::now, "[s] of robot time")
      .def("disconnect", &World::disconnect, WithoutGil(), "Stops every robot and lets go of it.")
      .def("tick", &World::tick, WithoutGil(), "One control period.")
      .def(
          "run", [](World& world, double wall) { return world.run(seconds("wall", wall)); }, "wall"_a, WithoutGil(),
          "Ticks until a wait is done, none is pending, or `wall` seconds have passed. True when a wait was done.")
      .def(
          "sleep", [](World& world, double s) { return world.sleep(seconds("seconds", s)); }, "seconds"_a)
      .def(
          "alarm", [](World& world, double s) { return world.alarm(seconds("seconds", s)); }, "seconds"_a)
      .def("forget", &World::forget, "wait"_a)
      .def("take_finished", &World::take_finished)
      .def("has_pending", &World::has_pending)
      .def_prop_ro("realtime", &World::realtime)
      .def("due", &World::due, "[wall s] until the next tick is due")
      .def("open_hold", &World::open_hold)
      .def(
          "close_hold", [](World& world, double charge) { return world.close_hold(seconds("seconds", charge)); },
          "charge"_a)
      .def_prop_ro("held", &World::held)
      .def("save", [](const World& world) { return Snapshot{world.save()}; }, WithoutGil());
  nb::class_<OneThreadWorld>(bound)
      .def(
          "claim_thread", [](const OneThreadWorld& w) { w.one_thread.claim(); },
          "The calling thread alone may use it and its robots, until `release_thread`.")
      .def(
          "release_thread", [](const OneThreadWorld& w) { w.one_thread.release(); },
          "Any thread may be the next. For the owner, or for any caller once its event loop is closed.");
}

void bind_readings(OneThreadClass<Runtime>& runtime) {
  runtime.def("connect", &Runtime::connect, WithoutGil())
      .def("disconnect", &Runtime::disconnect, WithoutGil())
      .def_prop_ro("connected", &Runtime::connected)
      .def("ready", &Runtime::ready)
      .def_prop_ro("fault", &Runtime::fault)
      .def_prop_ro("profile", &Runtime::profile)
      .def_prop_ro("features", &Runtime::features)
      .def_prop_ro("localization", [](const Runtime& robot) { return robot.world().autonomy().localization; })
      .def_prop_ro("navigation", [](const Runtime& robot) { return robot.world().autonomy().navigation; })
      .def("lidar_scan", &Runtime::lidar_scan, nb::rv_policy::copy)
      .def("imu", &Runtime::imu, nb::rv_policy::copy)
      .def("odometry", &Runtime::odometry, nb::rv_policy::copy)
      .def("battery", &Runtime::battery, nb::rv_policy::copy)
      .def(
          "image",
          [](const Runtime& robot, const std::string& camera) {
            (void)robot.image(camera);
            return std::get<Picture>(robot.sample(SensorType::camera).data);
          },
          "camera"_a, WithoutGil())
      .def("image_measured", [](const Runtime& robot) { return robot.sample(SensorType::camera).measured; })
      .def(
          "rgbd_image",
          [](const Runtime& robot) {
            (void)robot.rgbd_image();
            return std::get<Picture>(robot.sample(SensorType::camera).data);
          },
          WithoutGil())
      .def("people",
           [](const Runtime& robot) {
             const auto people = robot.people();
             return std::vector<perception::TrackedPerson>(people.begin(), people.end());
           })
      .def("health", &Runtime::health, nb::rv_policy::copy)
      .def("ultrasonic_ranges", &Runtime::ultrasonic_ranges)
      .def("sample", &Runtime::sample, "type"_a, nb::rv_policy::copy)
      .def("pose", &Runtime::pose, nb::rv_policy::copy)
      .def("map", &Runtime::map, nb::rv_policy::copy)
      .def("map_version", &Runtime::map_version)
      .def("path",
           [](const Runtime& robot) {
             const std::span<const Vec2> path = robot.path();
             return std::vector<Vec2>(path.begin(), path.end());
           })
      .def("plan", &Runtime::plan, WithoutGil())
      .def("transform", &Runtime::transform, "target"_a, "source"_a)
      .def("commanded", [](const Runtime& robot) { return robot.commanded().command; });
}

void bind_commands(OneThreadClass<Runtime>& runtime) {
  runtime
      .def(
          "set_velocity",
          [](Runtime& robot, double vx, double vy, double omega, double hold, bool creep_mode) {
            robot.set_velocity({vx, vy, omega}, seconds("hold", hold), creep_mode);
          },
          "vx"_a, "vy"_a, "omega"_a, "hold"_a, "creep_mode"_a)
      .def(
          "execute_action",
          [](Runtime& robot, const std::array<double, 3>& action, double period, bool creep_mode) {
            return robot.execute_action(action, seconds("period", period), creep_mode);
          },
          "action"_a, "period"_a, "creep_mode"_a)
      .def("stop", &Runtime::stop)
      .def("set_zones", &Runtime::set_zones, "zones"_a)
      .def("estop", &Runtime::estop)
      .def("release_estop", &Runtime::release_estop)
      .def_prop_ro("estopped", &Runtime::estopped)
      .def(
          "observe",
          [](Runtime& robot, std::function<void(const Tick&)> observer) {
            return robot.observe([observer = std::move(observer)](const TickView& view) { observer(tick_of(view)); });
          },
          "observer"_a)
      .def("unobserve", &Runtime::unobserve, "id"_a);
}

void bind_motions(OneThreadClass<Runtime>& runtime) {
  runtime.def("motion", &Runtime::motion)
      .def(
          "move_to",
          [](Runtime& robot, Vec2 goal, std::optional<double> theta, const std::string& frame, double tolerance,
             double angle_tolerance, std::optional<double> timeout) {
            const nav::MoveTo there = robot.in_map({goal, theta, tolerance, angle_tolerance}, frame);
            return robot.start(there, timeout_of(timeout));
          },
          "goal"_a, "theta"_a.none(), "frame"_a, "tolerance"_a, "angle_tolerance"_a, "timeout"_a.none(),
          "`goal` [m] and `theta` [rad] in `frame`.")
      .def(
          "drive",
          [](Runtime& robot, std::function<std::tuple<Velocity, Reason, std::string>(double)> source,
             std::optional<double> timeout) {
            const auto decide = [source = std::move(source)](Time now) {
              auto [velocity, reason, detail] = source(to_seconds(now));
              return nav::Decision{.velocity = velocity, .reason = reason, .detail = std::move(detail)};
            };
            return robot.drive(decide, timeout_of(timeout));
          },
          "source"_a, "timeout"_a.none(),
          "`source(now)` [s] gives the velocity that it wants in each control period, a reason that ends the motion or "
          "`running`, and a detail.")
      .def(
          "move_forward",
          [](Runtime& robot, double distance, double tolerance, std::optional<double> timeout) {
            return robot.start(nav::MoveForward{distance, tolerance}, timeout_of(timeout));
          },
          "distance"_a, "tolerance"_a, "timeout"_a.none())
      .def(
          "rotate",
          [](Runtime& robot, double angle, double angle_tolerance, std::optional<double> timeout) {
            return robot.start(nav::Rotate{angle, angle_tolerance}, timeout_of(timeout));
          },
          "angle"_a, "angle_tolerance"_a, "timeout"_a.none())
      .def(
          "follow_path",
          [](Runtime& robot, std::vector<Vec2> path, double tolerance, std::optional<double> timeout) {
            return robot.start(nav::FollowPath{std::move(path), tolerance}, timeout_of(timeout));
          },
          "path"_a, "tolerance"_a, "timeout"_a.none())
      .def(
          "follow_waypoints",
          [](Runtime& robot, const std::vector<std::tuple<double, double, std::optional<double>>>& places,
             double tolerance, double angle_tolerance, std::optional<double> timeout) {
            nav::FollowWaypoints goal;
            for (const auto& [x, y, theta] : places)
              goal.waypoints.push_back({{x, y}, theta, tolerance, angle_tolerance});
            return robot.start(goal, timeout_of(timeout));
          },
          "places"_a, "tolerance"_a, "angle_tolerance"_a, "timeout"_a.none())
      .def(
          "explore",
          [](Runtime& robot, bool thorough, std::optional<double> timeout) {
            return robot.start(nav::Explore{thorough}, timeout_of(timeout));
          },
          "thorough"_a, "timeout"_a.none());
}

void bind_runtime(nb::module_& m) {
  OneThreadClass<Runtime> runtime(m, "Runtime", "One robot of a world: autonomy stack, gate and port.");
  bind_readings(runtime);
  bind_commands(runtime);
  bind_motions(runtime);
}

void bind_simulation(nb::module_& m) {
  nb::class_<scene::PersonPose>(m, "PersonPose", "Where a person of a simulated scene is.")
      .def(Value())
      .def_ro("name", &scene::PersonPose::name)
      .def_ro("pose", &scene::PersonPose::pose, "in the scene's frame, facing the way they walk or wait to walk")
      .def_ro("radius", &scene::PersonPose::radius, "[m] of the circle that they fill on the floor")
      .def("__repr__", [](const scene::PersonPose& person) {
        return fmt::format("PersonPose('{}' at ({:.2f}, {:.2f}))", person.name, person.pose.x, person.pose.y);
      });
  OneThreadClass<Simulation>(m, "Simulation",
                             "The truth about a robot in a simulated world, for metrics, drawings and training.\n\n"
                             "All poses are in the scene's frame. Robots never see it.")
      .def(nb::init<OneThreadWorld&, std::size_t>(), "world"_a, "robot"_a, nb::keep_alive<1, 2>())
      .def_prop_ro("scene", &Simulation::scene)
      .def("true_pose", &Simulation::true_pose, WithoutGil())
      .def("true_velocity", &Simulation::true_velocity, WithoutGil(), "In the body frame.")
      .def("start_pose", &Simulation::start_pose, WithoutGil(),
           "Where the robot stood at the last reset: the origin of its `map` frame.")
      .def_prop_ro("scene_from_map", &Simulation::scene_from_map, WithoutGil(),
                   "Where the origin of the robot's map truly is. A perfect map drifts from it in nothing.\n\n"
                   "Unknown for a given map without an `initial_pose`, which is taken for one of the scene, origin and "
                   "all.")
      .def("max_collision_speed", &Simulation::max_collision_speed, WithoutGil(),
           "The fastest approach [m/s] of the robot's own motion into an obstacle since the last reset.")
      .def("distance_driven", &Simulation::distance_driven, WithoutGil(), "[m] since the last reset.")
      .def("people", &Simulation::people, "The people of the scene, where they are and which way they walk.")
      .def("sample_free_pose", &Simulation::sample_free_pose, "seed"_a,
           "A pose where the robot fits with 5 cm to spare: a pure function of the seed.")
      .def("geodesic", &Simulation::geodesic, "a"_a, "b"_a,
           "Length [m] of the shortest path between (x, y) points for the robot's footprint; infinity where there is "
           "none.")
      .def("teleport", &Simulation::teleport, "pose"_a, WithoutGil(),
           "A person lifts the robot and puts it down at a pose; its autonomy stack gets no notice.")
      .def("look",
           nb::overload_cast<const CameraIntrinsics&, const Pose2D&, double, bool>(&Simulation::look, nb::const_),
           "intrinsics"_a, "pose"_a, "height"_a, "with_itself"_a, WithoutGil(),
           "What a level camera at a pose and a height [m] above the floor would truly show now, with or without the "
           "robot "
           "itself.")
      .def("reset", &Simulation::reset, nb::kw_only(), "seed"_a = nb::none(), "pose"_a = nb::none(), "episode"_a = 0,
           WithoutGil(),
           "Begins anew at time 0, with the world's own seed and at the scene's own start pose unless said "
           "otherwise; all noise is that of an episode of the seed.\n\n"
           "Raises ConfigError when that is inside an obstacle.")
      .def(
          "save", [](const Simulation& simulation) { return Snapshot{simulation.save()}; }, WithoutGil(),
          "Everything the future depends on. Raises ContractError while a motion is in progress.")
      .def(
          "restore", [](Simulation& simulation, const Snapshot& snapshot) { simulation.restore(snapshot.state); },
          "snapshot"_a, WithoutGil(), "Goes on from where `save` was called.");
}

/// Warnings go to Python's logging, from whichever thread.
void log_warning(std::string_view message) {
  const nb::gil_scoped_acquire python_runs;
  nb::module_::import_("logging").attr("getLogger")("threewe").attr("warning")("%s", message);
}

}  // namespace

void init_robot(nb::module_& m) {
  bind_results(m);
  bind_views(m);
  bind_options(m);
  bind_time(m);
  bind_runtime(m);
  bind_simulation(m);
  set_warning_handler(log_warning);
}
