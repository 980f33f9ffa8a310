// The embedded simulator fitted to another robot.
#include "threewe/calibration/calibrate.hpp"

#include "bindings.hpp"
#include "calibration/fit.hpp"
#include "named_enum.hpp"
#include "value.hpp"

using namespace threewe;
using calibration::Calibration, calibration::Deviation, calibration::Figure, calibration::VelocityProfile;

void init_calibration(nb::module_& m) {
  NamedEnum<VelocityProfile>(m, "VelocityProfile", "How fast commands change.")
      .value("operating", VelocityProfile::operating,
             "within the operating limits, as whatever drives a robot makes them")
      .value("hardware", VelocityProfile::hardware, "within what the profile says that the drive can do")
      .value("abrupt", VelocityProfile::abrupt, "at once: wheels slip");
  nb::class_<Figure>(m, "Figure", "One figure of a profile, as it was fitted.")
      .def(Value())
      .def_ro("name", &Figure::name, "of its field below `body`")
      .def_ro("before", &Figure::before, "in the profile's unit: in the profile, or what follows from it")
      .def_ro("value", &Figure::value, "fitted, in the profile's unit")
      .def_ro("spread", &Figure::spread, "half of its 95 % interval, in the profile's unit")
      .def_ro("identifiable", &Figure::identifiable,
              "Whether the excitation sequences say more about it than was assumed beforehand.")
      .def("__repr__",
           [](const Figure& f) { return fmt::format("Figure({}={:.5g} +- {:.2g})", f.name, f.value, f.spread); });
  nb::class_<Deviation>(m, "Deviation", "How far the embedded simulator's motion is from another robot's: shares.")
      .def(Value())
      .def_ro("linear", &Deviation::linear,
              "share, of (vx, vy): root mean square of the difference over that of the other's velocity")
      .def_ro("angular", &Deviation::angular, "share, the same of omega")
      .def_ro("combined", &Deviation::combined, "share, the same of both, weighed as kinetic energy weighs them")
      .def_ro("pose", &Deviation::pose, "share of the distance driven, how far apart they end: mean over all sequences")
      .def_ro("farthest_pose", &Deviation::farthest_pose, "share, the worst of them")
      .def("__repr__", [](const Deviation& d) {
        return fmt::format("Deviation(linear={:.4f}, angular={:.4f}, combined={:.4f}, pose={:.4f})", d.linear,
                           d.angular, d.combined, d.pose);
      });
  nb::class_<Calibration>(m, "Calibration", "What came of `threewe.calibrate`.")
      .def(Value())
      .def_ro("profile", &Calibration::profile, "the fitted one")
      .def_ro("figures", &Calibration::figures, "what was fitted")
      .def_prop_ro(
          "source", [](const Calibration& c) { return std::string(to_string(c.source)); },
          R"("truth" where a simulator tells how its body moves, "sensors" where wheels and gyro do)")
      .def_ro("seconds", &Calibration::seconds, "[s] of robot time driven")
      .def_ro("before", &Calibration::before, "of the sequences, by the profile as it was; their poses mean little")
      .def_ro("after", &Calibration::after, "the same by the fitted one");
  m.def("calibrate", &calibration::calibrate, "backend"_a, "hardware"_a, WithoutGil(),
        "Drives the standard excitation sequences and fits the profile to them.");
  m.def("calibrated_yaml", &calibration::to_yaml, "hardware"_a, "calibration"_a,
        "The profile as a file, with the fitted figures in place of its own.");
  m.def(
      "deviations",
      [](std::string_view backend, const std::string& hardware, const std::vector<RobotProfile>& profiles,
         std::uint64_t seed, std::size_t count, VelocityProfile velocity_profile) {
        const nb::gil_scoped_release without_gil;
        return calibration::deviations(backend, hardware, profiles, seed, count, velocity_profile);
      },
      "backend"_a, "hardware"_a, "profiles"_a, "seed"_a, "count"_a, "velocity_profile"_a,
      "How far the embedded simulator with each profile is from a backend with `hardware`, on random sequences of 10 "
      "s.");
  m.def("repeatability", &calibration::repeatability, "backend"_a, "hardware"_a, "seed"_a, "count"_a,
        "velocity_profile"_a, WithoutGil(),
        "How far a backend is from itself, when wheels have turned a little before the same random sequences.");
}
