// Instructions: the semantic map and the agent.
#include "agent/agent.hpp"

#include <nanobind/stl/array.h>
#include <nanobind/stl/variant.h>

#include "bindings.hpp"
#include "color_shares.hpp"
#include "language/vocabulary.hpp"
#include "one_thread.hpp"
#include "semantics/places.hpp"
#include "threewe/scene/scene.hpp"
#include "value.hpp"

using namespace threewe;
using agent::Agent, agent::ExecutedStep, agent::ExecutionResult;
using semantics::MappedThing, semantics::Place;

namespace {

void bind_places(nb::module_& m) {
  m.def(
      "load_places",
      [](const std::string& path, const map::OccupancyGrid* within) { return semantics::load_places(path, within); },
      "path"_a, "within"_a.none(),
      "Reads a places file. Raises ConfigError, also for a place that is not on the map `within`.");
  m.def(
      "save_places",
      [](const std::vector<Place>& places, const std::string& path) { semantics::save_places(places, path); },
      "places"_a, "path"_a, "Writes a places file, whose name ends in .yaml.");
  m.def(
      "places_of_scene",
      [](const scene::Scene& scene) {
        const language::Language language = language::Language::load();
        std::vector<Place> places;
        for (const scene::Room& room : scene.rooms) {
          places.push_back({.name = language.room(room.name),
                            .polygon = {room.min, {room.max.x, room.min.y}, room.max, {room.min.x, room.max.y}}});
        }
        return places;
      },
      "scene"_a, "The rooms of a scene as places, in its frame, by the names that people call them.");
}

void bind_results(nb::module_& m) {
  nb::class_<ExecutedStep>(m, "ExecutedStep", "One skill that was executed.")
      .def(Value())
      .def_ro("skill", &ExecutedStep::skill, "such as `search`")
      .def_ro("text", &ExecutedStep::text, "with its arguments: `search(kind=chair, color=red)`")
      .def_prop_ro(
          "arguments",
          [](const ExecutedStep& s) {
            nb::typed<nb::dict, nb::str, std::variant<std::string, double>> arguments;
            for (const SkillArgument& one : s.arguments) arguments[nb::cast(one.name)] = nb::cast(one.value);
            return arguments;
          },
          "those that were said: [m], [rad] or [s] where they are numbers")
      .def_ro("reason", &ExecutedStep::reason, "how it ended: `done`, `not_found`, or a motion's reason")
      .def_ro("detail", &ExecutedStep::detail, "says more; may be empty")
      .def_ro("begun", &ExecutedStep::begun, "[s] of robot time")
      .def_ro("ended", &ExecutedStep::ended, "[s] of robot time")
      .def_ro("thing", &ExecutedStep::thing, "id of the mapped thing that it rests on; 0: none")
      .def_ro("verified", &ExecutedStep::verified, "the robot's own detector saw what it says")
      .def("__repr__", [](const ExecutedStep& s) { return fmt::format("ExecutedStep({}: {})", s.text, s.reason); });
  nb::class_<ExecutionResult>(m, "ExecutionResult", "What became of an instruction.")
      .def(Value())
      .def_ro("success", &ExecutionResult::success, "`reason` is `done`")
      .def_ro("reason", &ExecutionResult::reason,
              "done, not_found, not_understood, ambiguous, refused, budget, or a motion's reason")
      .def_ro("detail", &ExecutionResult::detail, "says more about a failure; may be empty")
      .def_ro("answer", &ExecutionResult::answer, "to a question, or what was found, as a sentence; may be empty")
      .def_ro("verified", &ExecutionResult::verified, "the robot's own detector saw what the answer says")
      .def_ro("steps", &ExecutionResult::steps, "the skills that were executed")
      .def_ro("distance", &ExecutionResult::distance, "[m] driven, by its own estimate")
      .def_ro("duration", &ExecutionResult::duration, "[s] of robot time")
      .def("__repr__", [](const ExecutionResult& r) {
        return fmt::format("ExecutionResult({}{}{})", r.reason, r.answer.empty() ? "" : ": " + r.answer,
                           r.detail.empty() ? "" : ", " + r.detail);
      });
}

}  // namespace

void init_agent(nb::module_& m) {
  nb::class_<MappedThing>(m, "MappedThing", "A thing that the robot has seen, perhaps many times.")
      .def(Value())
      .def_ro("id", &MappedThing::id, "grows with every new one")
      .def_ro("position", &MappedThing::position, "[m] of its centre, in `map`")
      .def_ro("covariance", &MappedThing::covariance, "[m^2] of the position: xx, xy, yy")
      .def_ro("kinds", &MappedThing::kinds, "probability of each of the detector's labels")
      .def_ro("views", &MappedThing::views, "from different poses")
      .def_prop_ro("kind_index", &MappedThing::kind, "its most probable kind, index into the detector's labels")
      .def_prop_ro(
          "color", [](const MappedThing& t) { return std::string(vision::color_names()[t.color()]); },
          "the color term that most of it has")
      .def_prop_ro(
          "colors", [](const MappedThing& t) { return color_shares(t.colors); },
          "by the names of the basic color terms that it has, the share of each in all that was seen of it");
  nb::class_<Place>(m, "Place", "A place that has a name.")
      .def(Value())
      .def_ro("name", &Place::name)
      .def_ro("polygon", &Place::polygon, "[m] in `map`; one point where the robot stood as it was named")
      .def_ro("origin", &Place::origin, "`given` by users, or `seen`: probably so by what stands there")
      .def("contains", &semantics::SemanticMap::contains, "point"_a,
           "Whether a point [m] in `map` is in it, or within 2.5 m of one that is a point.");
  bind_results(m);
  nb::class_<Agent>(m, "Agent", "Executes instructions on one robot. Use it through `Robot.execute_instruction`.")
      .def(
          "__init__",
          [](Agent* self, Runtime& robot, const vision::Detector& detector) { new (self) Agent(robot, detector); },
          "robot"_a, "detector"_a, nb::keep_alive<1, 2>())
      .def(
          "begin",
          [](Agent& self, std::string_view instruction, int steps, double duration) {
            self.begin(instruction, {steps, duration});
          },
          "instruction"_a, "steps"_a, "duration"_a)
      .def("update", &Agent::update, WithoutGil())
      .def("cancel", &Agent::cancel)
      .def_prop_ro("done", &Agent::done)
      .def_prop_ro("steps", &Agent::steps, nb::rv_policy::copy, "those begun so far; the last may have no `reason` yet")
      .def_prop_ro("result", &Agent::result, nb::rv_policy::copy)
      .def_prop_ro(
          "look_period", [](const Agent&) { return to_seconds(Agent::kLookPeriod); },
          "[s] of robot time between two looks")
      .def("sees", &Agent::sees, "thing"_a, "Whether the newest look shows a thing of the map, by its id.")
      .def_prop_ro("things", [](const Agent& self) { return self.map().things(); })
      .def_prop_ro("places", [](const Agent& self) { return self.map().places(); })
      .def_prop_ro("labels", [](const Agent& self) { return self.detector().labels(); })
      .def("add_places", &Agent::add_places, "places"_a)
      .def(
          "name_place",
          [](Agent& self, const std::string& name, const std::vector<Vec2>& polygon) {
            self.name_place({.name = name, .polygon = polygon});
          },
          "name"_a, "polygon"_a);
  bind_places(m);
}
