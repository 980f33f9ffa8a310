#include <fmt/format.h>

#include "scene/occupancy.hpp"
#include "writers.hpp"

namespace threewe::exports {
namespace {

constexpr double kDrivenOver = 0.01;  // [m], what is lower stops no robot

std::vector<scene::Solid> mapped_solids(const scene::Scene& scene, const RobotProfile& robot) {
  if (!robot.lidar) return scene.solids_between(kDrivenOver, robot.body.height);
  std::vector<scene::Solid> cut = scene.solids();
  const double z = robot.lidar->height;
  std::erase_if(cut, [&](const scene::Solid& solid) { return z < solid.z_min || z >= solid.z_max; });
  return cut;
}

}  // namespace

map::OccupancyGrid map_of(const scene::Scene& scene, const RobotProfile& robot) {
  const scene::GridFrame frame = grid_over(scene);
  const scene::CellSet occupied = occupied_cells(frame, mapped_solids(scene, robot));
  scene::CellSet free = occupied;
  for (unsigned char& cell : free.cells) cell = cell == 0 ? 1 : 0;
  const scene::CellSet reached = connected_cells(free, scene.starts.front().position());

  map::OccupancyGrid grid{frame.width, frame.height, frame.resolution, frame.origin, {}};
  grid.data.assign(frame.size(), map::OccupancyGrid::kUnknown);
  for (std::size_t i = 0; i < frame.size(); ++i) {
    if (occupied.cells[i] != 0) grid.data[i] = map::OccupancyGrid::kOccupied;
    if (!reached.cells.empty() && reached.cells[i] != 0) grid.data[i] = map::OccupancyGrid::kFree;
  }
  return grid;
}

// As nav2_map_server's map_saver writes maps: a picture whose first row is the highest y, and where it lies.
std::vector<File> map_files(const scene::Scene& scene, const RobotProfile& robot) {
  constexpr char kBlack = 0;
  constexpr char kWhite = static_cast<char>(254);
  constexpr char kGrey = static_cast<char>(205);
  const map::OccupancyGrid grid = map_of(scene, robot);
  std::string picture = fmt::format("P5\n# written by threewe\n{} {}\n255\n", grid.width, grid.height);
  for (int y = grid.height - 1; y >= 0; --y) {
    for (int x = 0; x < grid.width; ++x) {
      const std::int8_t value = grid.at({x, y});
      picture += value == map::OccupancyGrid::kOccupied ? kBlack : value == map::OccupancyGrid::kFree ? kWhite : kGrey;
    }
  }
  const std::string settings = fmt::format(
      "image: map.pgm\nmode: trinary\nresolution: {}\norigin: [{:.3f}, {:.3f}, 0]\nnegate: 0\n"
      "occupied_thresh: 0.65\nfree_thresh: 0.25\n",
      grid.resolution, grid.origin.x, grid.origin.y);
  return {{"map.pgm", picture}, {"map.yaml", settings}};
}

}  // namespace threewe::exports
