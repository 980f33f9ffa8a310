// Files for other simulators and for ROS.
#include "threewe/export/export.hpp"

#include <filesystem>

#include <nanobind/stl/filesystem.h>

#include "bindings.hpp"

using namespace threewe;

void init_export(nb::module_& m) {
  m.def(
      "export_files",
      [](const scene::Scene& scene, const RobotProfile& robot, std::string_view format, const std::string& folder) {
        const exports::Format wanted = exports::format_named(format);
        const nb::gil_scoped_release without_gil;
        return exports::write(exports::files(scene, robot, wanted), folder);
      },
      "scene"_a, "robot"_a, "format"_a, "folder"_a,
      "Writes a scene, and a robot at its first start, into a folder; returns the files. Formats: mjcf, urdf, sdf, "
      "usd, "
      "map. Raises ConfigError for another format, and for a folder that cannot be written.");
}
