// Backends by name, and what a robot can do.
#include "backend/mujoco/mujoco.hpp"
#include "bindings.hpp"
#include "threewe/backend/registry.hpp"
#include "threewe/backend/world.hpp"
#include "value.hpp"

using namespace threewe;
using backend::Features;

void init_backend(nb::module_& m) {
  nb::class_<SensorInfo>(m, "SensorInfo", "One sensor of a robot, as it is known before connecting.")
      .def(Value())
      .def(nb::init<std::string, SensorType, double>(), "name"_a, "type"_a, "rate"_a)
      .def_ro("name", &SensorInfo::name, "unique on a robot; also the name of its frame")
      .def_ro("type", &SensorInfo::type)
      .def_ro("rate", &SensorInfo::rate, "[Hz]")
      .def("__repr__", [](const SensorInfo& s) { return fmt::format("SensorInfo('{}', {} Hz)", s.name, s.rate); });

  nb::class_<Features>(m, "Features", "What a robot can do, readable before connecting.")
      .def(Value())
      .def(
          "__init__",
          [](Features* self, std::vector<SensorInfo> sensors, Kinematics kinematics, bool lockstep, bool deterministic,
             bool can_reset, bool can_save) {
            new (self) Features{std::move(sensors), kinematics, lockstep, deterministic, can_reset, can_save};
          },
          "sensors"_a, "kinematics"_a, nb::kw_only(), "lockstep"_a = false, "deterministic"_a = false,
          "can_reset"_a = false, "can_save"_a = false)
      .def_ro("sensors", &Features::sensors)
      .def_ro("kinematics", &Features::kinematics)
      .def_ro("lockstep", &Features::lockstep, "Time advances only when a caller advances it.")
      .def_ro("deterministic", &Features::deterministic,
              "The same seed and commands give the same samples, to the bit.")
      .def_ro("can_reset", &Features::can_reset)
      .def_ro("can_save", &Features::can_save);
  m.def("backend_names", &backend::backend_names, "The names of all backends.");
  m.def("use_mujoco", &backend::mujoco::use_library, "path"_a,
        "Says where MuJoCo's library is; it is loaded when a world is first made.");
  m.attr("MUJOCO_VERSION") = backend::mujoco::kVersion;
}
