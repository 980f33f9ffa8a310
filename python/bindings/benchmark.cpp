// What robots are measured by.
#include <memory>

#include <nanobind/stl/shared_ptr.h>

#include "benchmark/nearest_frontier.hpp"
#include "benchmark/optimistic_replanning.hpp"
#include "bindings.hpp"
#include "scene/scene_tables.hpp"
#include "task/stop_task.hpp"
#include "value.hpp"

using namespace threewe;
using benchmark::ReferenceDrive, benchmark::ReferenceExploration;

void init_benchmark(nb::module_& m) {
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
