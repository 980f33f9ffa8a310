// Tours that the embedded simulator records.
#include "sim/survey.hpp"
#include "threewe/core/errors.hpp"

#include "bindings.hpp"
#include "value.hpp"

void init_sim(nb::module_& m) {
  using namespace threewe;
  using sim::Survey, sim::SurveyScan;
  nb::class_<SurveyScan>(m, "SurveyScan", "What a survey's robot recorded at one moment, and the truth.")
      .def(Value())
      .def_ro("time", &SurveyScan::stamp, "[s]")
      .def_ro("truth", &SurveyScan::scene_from_base, "where it was, in the scene's frame")
      .def_ro("odometry", &SurveyScan::odom_from_base, "where its wheels had it")
      .def_ro("scan", &SurveyScan::scan);
  nb::class_<Survey>(m, "Survey", "A tour through a scene, for `threewe slam synth`.")
      .def_static("load", &sim::load_survey, "name"_a,
                  "Reads a survey by name, or from a file that ends in .yaml. Raises ConfigError with file and line.")
      .def_ro("name", &Survey::name)
      .def_ro("description", &Survey::description)
      .def_ro("scene", &Survey::scene)
      .def_ro("stops", &Survey::stops, "(x, y) [m] one after the other, in the scene's frame")
      .def("drive", &sim::drive, "seed"_a = 0, WithoutGil(),
           "Drives the tour with the sensors of a robot of the year 2000: 180 beams, slipping wheels, no gyro. A pure\n"
           "function of the seed. Raises ConfigError where a stop cannot be reached.");
  m.def("survey_names", &sim::survey_names, "The names of all surveys.");
  m.def("survey_lidar", &sim::survey_lidar, "Where the lidar of a survey's robot is.");
}
