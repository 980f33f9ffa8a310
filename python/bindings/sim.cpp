// Tours that the embedded simulator records.
#include "sim/recorded_log.hpp"
#include "threewe/core/errors.hpp"

#include "bindings.hpp"
#include "value.hpp"

void init_sim(nb::module_& m) {
  using namespace threewe;
  using sim::LogSpec, sim::RecordedScan;
  nb::class_<RecordedScan>(m, "RecordedScan", "One recorded scan with the odometry and the truth at that time.")
      .def(Value())
      .def_ro("time", &RecordedScan::stamp, "[s]")
      .def_ro("truth", &RecordedScan::scene_from_base, "where it was, in the scene's frame")
      .def_ro("odometry", &RecordedScan::odom_from_base, "where its wheels had it")
      .def_ro("scan", &RecordedScan::scan);
  nb::class_<LogSpec>(m, "LogSpec",
                      "Specification of a synthetic log, a tour through a scene, for `threewe slam synth`.")
      .def_static("load", &sim::load_log_spec, "name"_a,
                  "Reads a log specification by name, or from a file that ends in .yaml. Raises ConfigError with file "
                  "and line.")
      .def_ro("name", &LogSpec::name)
      .def_ro("description", &LogSpec::description)
      .def_ro("scene", &LogSpec::scene)
      .def_ro("stops", &LogSpec::stops, "(x, y) [m] one after the other, in the scene's frame")
      .def("drive", &sim::drive, "seed"_a = 0, WithoutGil(),
           "Drives the tour with the sensors of a robot of the year 2000: 180 beams, slipping wheels, no gyro. A pure\n"
           "function of the seed. Raises ConfigError where a stop cannot be reached.");
  m.def("log_names", &sim::log_names, "The names of all log specifications.");
  m.def("log_lidar", &sim::log_lidar, "Where the lidar of a recorded log's robot is.");
}
