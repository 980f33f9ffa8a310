// Writers of the export formats, each a short file of its own.
#pragma once

#include <string>
#include <vector>

#include "export/robot_description.hpp"
#include "export/scene_blocks.hpp"
#include "threewe/export/export.hpp"

namespace threewe::exports {

std::vector<File> urdf_files(const scene::Scene& scene, const RobotDescription& robot);
std::vector<File> sdf_files(const scene::Scene& scene, const RobotDescription& robot);
std::vector<File> usd_files(const scene::Scene& scene, const RobotDescription& robot);
std::vector<File> map_files(const scene::Scene& scene, const RobotProfile& robot);

}  // namespace threewe::exports
