// Learning environments: many worlds at once, and the tasks that are set in them.
#include "threewe/env/batch.hpp"

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/tuple.h>

#include "bindings.hpp"
#include "core/names.hpp"
#include "task/object_nav.hpp"
#include "task/vln.hpp"
#include "threewe/env/robot/robot_env.hpp"
#include "threewe/robot/runtime.hpp"
#include "threewe/task/tasks.hpp"
#include "value.hpp"

namespace {

using namespace threewe;
using env::Batch, env::RobotEnv;

template <typename T>
T chosen(std::string_view kind, std::string_view name, std::initializer_list<std::pair<const char*, T>> choices) {
  std::vector<std::string> names;
  for (const auto& [choice, value] : choices) {
    if (name == choice) return value;
    names.emplace_back(choice);
  }
  throw ConfigError(unknown_name(kind, name, names));
}

task::NavigationOptions navigation_options(std::string_view episodes, bool goal_in_map, bool stop,
                                           std::string_view contact) {
  task::NavigationOptions options;
  options.goal_in_map = goal_in_map;
  options.stop = stop;
  options.contact_ends = chosen<bool>("contact", contact, {{"end", true}, {"count", false}});
  if (episodes == "reactive") {
    options.longest = 8.0;
    options.detours = 0.0;
  }
  return options;
}

/// Raises ConfigError for a kind of episodes that the task does not have.
void check_episodes(std::string_view task, std::string_view episodes) {
  const std::string kind = fmt::format("episodes of {}", task);
  if (task == "navigation") {
    chosen<bool>(kind, episodes, {{"standard", false}, {"reactive", true}});
  } else if (task == "object_nav") {
    chosen<bool>(kind, episodes, {{"standard", false}, {"in_sight", true}});
  } else {
    chosen<bool>(kind, episodes, {{"standard", false}});
  }
}

env::TaskFactory task_factory(std::string_view task, const task::NavigationOptions& navigation, bool in_sight) {
  return chosen<env::TaskFactory>(
      "task", task,
      {{"navigation",
        [navigation](const task::TaskContext& context) { return task::make_navigation(context, navigation); }},
       {"exploration", [](const task::TaskContext& context) { return task::make_exploration(context); }},
       {"object_nav",
        [in_sight](const task::TaskContext& context) {
          return task::make_object_nav(context, {.in_sight = in_sight});
        }},
       {"vln", task::make_vln}});
}

// Names that are not the robot's own are of the task, which Python has checked. Without names it is all but depth that
// there is.
env::Observed observed(const std::optional<std::vector<std::string>>& wanted) {
  if (!wanted) return {.image = true, .task_fields = {}, .if_there = true};
  const std::vector<std::string>& names = *wanted;
  env::Observed observed{.lidar = false, .pose = false, .velocity = false, .task_fields = std::vector<std::string>{}};
  for (const std::string& name : names) {
    if (name == "image") {
      observed.image = true;
    } else if (name == "depth") {
      observed.depth = true;
    } else if (name == "lidar") {
      observed.lidar = true;
    } else if (name == "pose") {
      observed.pose = true;
    } else if (name == "velocity") {
      observed.velocity = true;
    } else {
      observed.task_fields->push_back(name);
    }
  }
  return observed;
}

std::optional<env::Gate> gate_of(const std::optional<std::string>& name) {
  if (!name) return std::nullopt;
  return chosen<env::Gate>("gate", *name, {{"full", env::Gate::full}, {"limits", env::Gate::limits}});
}

/// What all environments are asked in the same way.
env::Options task_options(const std::string& task, const std::optional<std::vector<std::string>>& observations,
                          int lidar_beams, std::pair<int, int> image_size, int max_steps, double control_period,
                          const std::string& episodes, const std::string& goal_frame, bool stop,
                          const std::string& contact) {
  env::Options options;
  const bool goal_in_map = chosen<bool>("goal_frame", goal_frame, {{"robot", false}, {"map", true}});
  options.task = task_factory(task, navigation_options(episodes, goal_in_map, stop, contact), episodes == "in_sight");
  check_episodes(task, episodes);
  options.observed = observed(observations);
  options.lidar_beams = lidar_beams;
  std::tie(options.image_height, options.image_width) = image_size;
  options.max_steps = max_steps;
  options.control_period = seconds("control_period", control_period);
  return options;
}

std::vector<std::shared_ptr<scene::Scene>> scenes_of(const env::Options& options) {
  std::vector<std::shared_ptr<scene::Scene>> scenes;
  for (const auto& scene : options.scenes) scenes.push_back(std::make_shared<scene::Scene>(*scene));
  return scenes;
}

/// An array of C++ memory that Python may read while its owner lives.
nb::object view(nb::handle owner, const void* data, const std::vector<std::size_t>& shape, nb::dlpack::dtype dtype) {
  return nb::ndarray<nb::numpy>(const_cast<void*>(data), shape.size(), shape.data(), owner, nullptr, dtype)  // NOLINT
      .cast();
}

nb::dlpack::dtype dtype_of(task::Field::Type type) {
  switch (type) {
    case task::Field::Type::uint8: return nb::dtype<std::uint8_t>();
    case task::Field::Type::int32: return nb::dtype<std::int32_t>();
    case task::Field::Type::float32: return nb::dtype<float>();
  }
  return {};
}

using Arrays = nb::typed<nb::dict, nb::str, nb::any>;

Arrays views(nb::handle owner, std::span<const env::Array> arrays) {
  nb::dict dict;
  for (const env::Array& array : arrays) {
    std::vector<std::size_t> shape{array.row_bytes == 0 ? 0 : array.data.size() / array.row_bytes};
    shape.insert(shape.end(), array.field.shape.begin(), array.field.shape.end());
    dict[array.field.name.c_str()] = view(owner, array.data.data(), shape, dtype_of(array.field.type));
  }
  return dict;
}

using Values = nb::ndarray<nb::numpy, double, nb::shape<-1>>;
using Table = nb::ndarray<nb::numpy, double, nb::shape<-1, -1>>;
using Flags = nb::ndarray<nb::numpy, bool, nb::shape<-1>>;

template <typename T>
T* writable(std::span<const T> values) {
  return const_cast<T*>(values.data());  // NOLINT: PyTorch takes no array that is read-only
}
Values values(nb::handle owner, std::span<const double> numbers) {
  return Values(writable(numbers), {numbers.size()}, owner);
}
Table table(nb::handle owner, std::span<const double> numbers, std::size_t columns) {
  return Table(writable(numbers), {numbers.size() / columns, columns}, owner);
}
Flags flags(nb::handle owner, std::span<const std::uint8_t> bytes) {
  return Flags(writable(bytes), {bytes.size()}, owner);
}

using Actions = nb::ndarray<const float, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;

using Seeds = std::vector<std::optional<std::uint64_t>>;
using Episodes = std::vector<std::optional<std::uint32_t>>;
using SceneIndices = std::vector<std::optional<std::size_t>>;

/// What batches and environments around robots have in common.
template <typename Env>
void bind_results(nb::class_<Env>& c) {
  static const auto env_of = [](nb::handle self) -> Env& { return nb::cast<Env&>(self); };
  c.def_prop_ro(
       "fields",
       [](const Env& env) {
         std::vector<task::Field> fields;
         for (const env::Array& array : env.observations()) fields.push_back(array.field);
         return fields;
       },
       "What every robot observes, in order.")
      .def(
          "step",
          [](Env& env, const Actions& actions) {
            const nb::gil_scoped_release release;
            env.step({actions.data(), actions.size()});
          },
          "actions"_a.noconvert())
      .def_prop_ro("observations", [](nb::handle self) { return views(self, env_of(self).observations()); })
      .def_prop_ro("rewards", [](nb::handle self) { return values(self, env_of(self).rewards()); })
      .def_prop_ro("terminated", [](nb::handle self) { return flags(self, env_of(self).terminated()); })
      .def_prop_ro("truncated", [](nb::handle self) { return flags(self, env_of(self).truncated()); })
      .def_prop_ro("metric_names", &Env::metric_names)
      .def_prop_ro(
          "metrics",
          [](nb::handle self) { return table(self, env_of(self).metrics(), env_of(self).metric_names().size()); })
      .def_prop_ro("true_poses", [](nb::handle self) { return table(self, env_of(self).true_poses(), 3); })
      .def_prop_ro("scan_ages", [](nb::handle self) { return values(self, env_of(self).scan_ages()); })
      .def(
          "variation",
          [](const Env& env, std::size_t world, std::size_t robot) {
            std::map<std::string, double> values;
            const models::Variation variation = env.variation(world, robot);
            for (std::size_t i = 0; i < models::knob_names().size(); ++i) {
              values[models::knob_names()[i]] = models::knob(variation, i);
            }
            return values;
          },
          "env"_a, "robot"_a = 0, "How a robot differs from its profile now: the value of each knob.")
      .def_prop_ro("instruction_name", &Env::instruction_name,
                   "What `instruction` is called; empty where a task has none.")
      .def("instruction", &Env::instruction, "env"_a, "What an episode is about: an instruction, a category.")
      .def("episode", &Env::episode, "env"_a)
      .def("top_view", &Env::top_view, "env"_a, WithoutGil());
}

void bind_top_view(nb::module_& m) {
  nb::class_<env::TopView>(m, "TopView", "A world from above, in the scene's frame: for pictures.")
      .def_ro("robots", &env::TopView::robots)
      .def_ro("hits", &env::TopView::hits, "[m] what each robot's newest scan hit")
      .def_prop_ro(
          "people",
          [](const env::TopView& view) {
            std::vector<std::tuple<double, double, double>> people;
            for (const scene::Circle& one : view.people) people.emplace_back(one.center.x, one.center.y, one.radius);
            return people;
          },
          "x, y and radius [m] of each")
      .def_prop_ro(
          "goals", [](const env::TopView& view) { return view.task.goals; }, "of each robot; empty without goals")
      .def_prop_ro(
          "ground",
          [](nb::handle self) {
            const scene::CellSet& set = nb::cast<const env::TopView&>(self).task.ground;
            return ArrayView<std::uint8_t, nb::shape<-1, -1>>(
                set.cells.data(),
                {static_cast<std::size_t>(set.frame.height), static_cast<std::size_t>(set.frame.width)}, self);
          },
          "(H, W) uint8, row 0 the lowest y: 0 what needs not be seen, 1 what is still to be, 2 what has been; (0, 0) "
          "where nothing needs be")
      .def_prop_ro("ground_origin", [](const env::TopView& view) { return view.task.ground.frame.origin; })
      .def_prop_ro("ground_resolution", [](const env::TopView& view) { return view.task.ground.frame.resolution; });
}

void bind_descriptions(nb::module_& m) {
  nb::class_<env::EpisodeInfo>(m, "EpisodeInfo", "A world's episode.")
      .def(Value())
      .def_ro("seed", &env::EpisodeInfo::seed)
      .def_ro("episode", &env::EpisodeInfo::episode, "counted from 0 since the seed was given")
      .def_ro("scene", &env::EpisodeInfo::scene, "place in the list of scenes")
      .def_ro("steps", &env::EpisodeInfo::steps, "taken");

  nb::class_<task::Field>(m, "ObservationField", "An array that every robot observes.")
      .def_ro("name", &task::Field::name)
      .def_ro("shape", &task::Field::shape)
      .def_ro("low", &task::Field::low)
      .def_ro("high", &task::Field::high)
      .def_prop_ro("dtype", [](const task::Field& field) {
        switch (field.type) {
          case task::Field::Type::uint8: return "uint8";
          case task::Field::Type::int32: return "int32";
          case task::Field::Type::float32: return "float32";
        }
        return "";
      });
}

void bind_batch(nb::module_& m) {
  nb::class_<Batch> bound(m, "EnvBatch",
                          "Many environments at once. Arrays are views of C++ memory, one row for each robot, which "
                          "every call of `reset` and `step` overwrites.");
  bound
      .def(
          "__init__",
          [](Batch* self, const std::string& task, const std::vector<std::shared_ptr<scene::Scene>>& scenes,
             const RobotProfile& hardware, const std::string& noise,
             const std::optional<std::vector<std::string>>& observations, int lidar_beams,
             std::pair<int, int> image_size, const std::string& localization, const std::string& localization_model,
             const models::Randomization& randomization, const std::optional<std::string>& gate, int max_steps,
             double control_period, std::size_t num_envs, std::size_t num_robots, std::size_t num_threads,
             const std::string& autoreset, const std::string& episodes, const std::string& goal_frame, bool stop,
             const std::string& contact) {
            env::Options options = task_options(task, observations, lidar_beams, image_size, max_steps, control_period,
                                                episodes, goal_frame, stop, contact);
            options.scenes.assign(scenes.begin(), scenes.end());
            options.data_sheet = hardware;
            options.hardware = with_noise(hardware, noise_level(noise));
            options.localization = chosen<env::Localization>("localization", localization,
                                                             {{"noisy", env::Localization::noisy},
                                                              {"odometry", env::Localization::odometry},
                                                              {"truth", env::Localization::truth}});
            if (options.localization == env::Localization::noisy) {
              options.localization_model = models::load_localization(localization_model);
            }
            options.randomization = randomization;
            options.gate = gate_of(gate);
            options.worlds = num_envs;
            options.robots = num_robots;
            options.threads = num_threads;
            options.autoreset = chosen<env::Autoreset>("autoreset", autoreset,
                                                       {{"next_step", env::Autoreset::next_step},
                                                        {"same_step", env::Autoreset::same_step},
                                                        {"disabled", env::Autoreset::disabled}});
            const nb::gil_scoped_release release;
            new (self) Batch(std::move(options));
          },
          nb::kw_only(), "task"_a, "scenes"_a, "hardware"_a, "noise"_a, "observations"_a.none(), "lidar_beams"_a,
          "image_size"_a, "localization"_a, "localization_model"_a, "randomization"_a, "gate"_a.none(), "max_steps"_a,
          "control_period"_a, "num_envs"_a, "num_robots"_a, "num_threads"_a, "autoreset"_a, "episodes"_a,
          "goal_frame"_a, "stop"_a, "contact"_a)
      .def(
          "reset",
          [](Batch& batch, const Seeds& seeds, const Episodes& episodes, const SceneIndices& scenes,
             const std::optional<Pose2D>& start, const std::optional<Vec2>& goal,
             const std::optional<std::string>& category, const std::vector<bool>& mask) {
            std::vector<env::Reset> resets(batch.options().worlds);
            for (std::size_t i = 0; i < resets.size(); ++i) {
              resets[i] = {seeds.at(i), episodes.at(i), scenes.at(i), {start, goal, category}};
            }
            const auto chosen_worlds = std::make_unique<bool[]>(mask.size());  // vector<bool> has no data()
            std::copy(mask.begin(), mask.end(), chosen_worlds.get());
            const nb::gil_scoped_release release;
            batch.reset(resets, {chosen_worlds.get(), mask.size()});
          },
          "seeds"_a, "episodes"_a, "scenes"_a, "start"_a.none(), "goal"_a.none(), "category"_a.none(), "mask"_a)
      .def_prop_ro("final_observations",
                   [](nb::handle self) { return views(self, nb::cast<Batch&>(self).final_observations()); })
      .def_prop_ro("ended", [](nb::handle self) { return flags(self, nb::cast<Batch&>(self).ended()); })
      .def_prop_ro("done", [](nb::handle self) { return flags(self, nb::cast<Batch&>(self).done()); })
      .def_prop_ro("final_metrics", [](nb::handle self) {
        const Batch& batch = nb::cast<Batch&>(self);
        return table(self, batch.final_metrics(), batch.metric_names().size());
      });
  bind_results(bound);
}

void bind_robot_env(nb::module_& m) {
  nb::class_<RobotEnv> bound(m, "RobotEnv",
                             "One environment around a robot of any backend. As EnvBatch with one environment.");
  bound
      .def(
          "__init__",
          [](RobotEnv* self, const std::string& backend, const std::string& task,
             const std::vector<std::string>& scenes, const std::string& hardware, const std::string& noise,
             const std::optional<std::vector<std::string>>& observations, int lidar_beams,
             std::pair<int, int> image_size, const std::string& localization, const std::string& randomization,
             const std::optional<std::string>& gate, int max_steps, double control_period, const std::string& episodes,
             const std::string& goal_frame, bool stop, const std::string& contact) {
            env::Options options = task_options(task, observations, lidar_beams, image_size, max_steps, control_period,
                                                episodes, goal_frame, stop, contact);
            options.gate = gate_of(gate);
            World::Options robot;
            robot.backend = backend;
            robot.robots = {hardware};
            robot.noise = noise_level(noise);
            robot.autonomy = autonomy_with(localization);
            robot.randomization = randomization;
            const nb::gil_scoped_release release;
            new (self) RobotEnv(std::move(options), robot, scenes);
          },
          nb::kw_only(), "backend"_a, "task"_a, "scenes"_a, "hardware"_a, "noise"_a, "observations"_a.none(),
          "lidar_beams"_a, "image_size"_a, "localization"_a, "randomization"_a, "gate"_a.none(), "max_steps"_a,
          "control_period"_a, "episodes"_a, "goal_frame"_a, "stop"_a, "contact"_a)
      .def_prop_ro(
          "scenes", [](const RobotEnv& robot) { return scenes_of(robot.options()); }, "As the backend has them.")
      .def_prop_ro(
          "hardware", [](const RobotEnv& robot) { return robot.options().hardware; }, "As the backend has it.")
      .def_prop_ro(
          "map", [](RobotEnv& robot) { return robot.world().robot(0).map(); },
          "The robot's own map in the first scene.")
      .def(
          "reset",
          [](RobotEnv& robot, const Seeds& seeds, const Episodes& episodes, const SceneIndices& scenes,
             const std::optional<Pose2D>& start, const std::optional<Vec2>& goal,
             const std::optional<std::string>& category, const std::vector<bool>&) {
            const nb::gil_scoped_release release;
            robot.reset({seeds.at(0), episodes.at(0), scenes.at(0), {start, goal, category}});
          },
          "seeds"_a, "episodes"_a, "scenes"_a, "start"_a.none(), "goal"_a.none(), "category"_a.none(), "mask"_a);
  bind_results(bound);
}

void bind_randomization(nb::module_& m) {
  nb::class_<models::Randomization>(m, "Randomization",
                                    "Domain randomisation: how far robots differ from their profile.")
      .def_static("load", &models::load_randomization, "name"_a,
                  "Reads one by name, or from a file that ends in .yaml. Raises ConfigError with file and line.")
      .def_static("parse", &models::parse_randomization, "text"_a, "name"_a)
      .def(
          "draw",
          [](const models::Randomization& randomization, std::uint64_t seed) {
            const models::Variation drawn = models::draw_variation(randomization, seed, 0, 0);
            std::map<std::string, double> values;
            for (std::size_t i = 0; i < models::knob_names().size(); ++i) {
              values[models::knob_names()[i]] = models::knob(drawn, i);
            }
            return values;
          },
          "seed"_a,
          "How the robot differs in the episode of a seed: every knob's value, those that are not drawn as they "
          "are without randomisation.")
      .def_ro("name", &models::Randomization::name)
      .def_ro("description", &models::Randomization::description);
  m.def("randomization_names", &models::randomization_names, "The names of all randomisations.");
  m.def("knob_names", &models::knob_names, "The names of all numbers that a randomisation can draw.");
}

}  // namespace

void init_env(nb::module_& m) {
  bind_randomization(m);
  bind_top_view(m);
  bind_descriptions(m);
  bind_batch(m);
  bind_robot_env(m);
}
