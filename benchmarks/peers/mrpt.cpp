// MRPT: its lidar, which marches through an occupancy grid with cells of 5 cm (needs Debian's libmrpt-maps-dev).
#include <mrpt/maps/COccupancyGridMap2D.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/version.h>

#include "world.hpp"

namespace {

using Grid = mrpt::maps::COccupancyGridMap2D;

constexpr double kCell = 0.05;  // [m]
constexpr float kFree = 0.95F;
constexpr float kTaken = 0.02F;

// Whether a solid covers a point.
bool covers(const peers::Solid& solid, double x, double y) {
  const double dx = x - solid.x;
  const double dy = y - solid.y;
  if (solid.radius > 0.0) return std::hypot(dx, dy) <= solid.radius;
  const double along = std::cos(solid.theta) * dx + std::sin(solid.theta) * dy;
  const double across = std::cos(solid.theta) * dy - std::sin(solid.theta) * dx;
  return std::abs(along) <= 0.5 * solid.length && std::abs(across) <= 0.5 * solid.width;
}

// Cells that something covers a part of are occupied.
Grid grid_of(const peers::World& world) {
  Grid grid(-30.0F, 30.0F, -30.0F, 30.0F, static_cast<float>(kCell));
  grid.fill(kFree);
  for (const peers::Solid& solid : cut(world)) {
    const double reach = solid.radius > 0.0 ? solid.radius : 0.5 * std::hypot(solid.length, solid.width);
    for (double x = solid.x - reach; x <= solid.x + reach; x += 0.25 * kCell) {
      for (double y = solid.y - reach; y <= solid.y + reach; y += 0.25 * kCell) {
        if (!covers(solid, x, y)) continue;
        grid.setCell(grid.x2idx(static_cast<float>(x)), grid.y2idx(static_cast<float>(y)), kTaken);
      }
    }
  }
  return grid;
}

}  // namespace

int main(int, char** argv) {
  const peers::World world = peers::read_world(argv[1]);
  const Grid grid = grid_of(world);
  for (const int beams : peers::kBeams) {
    mrpt::obs::CObservation2DRangeScan scan;
    scan.aperture = static_cast<float>(2.0 * M_PI);
    scan.maxRange = static_cast<float>(world.lidar_range);
    scan.rightToLeft = true;
    const auto turn = [&](const peers::Place& pose) {
      grid.laserScanSimulator(scan, {pose.x, pose.y, pose.theta}, 0.5F, static_cast<std::size_t>(beams), 0.0F, 1, 0.0F);
    };
    const auto range = [&](int i) {
      const auto beam = static_cast<std::size_t>(i);
      return scan.getScanRangeValidity(beam) ? static_cast<double>(scan.getScanRange(beam)) : world.lidar_range;
    };
    const std::string fields = "\"who\": \"MRPT " + std::to_string(MRPT_VERSION >> 8 & 0xF) + "." +
                               std::to_string(MRPT_VERSION >> 4 & 0xF) + "." + std::to_string(MRPT_VERSION & 0xF) +
                               ", laserScanSimulator\", \"differs\": \"marches through a grid of 5 cm, C++\"";
    peers::report_scans(fields, world, beams, turn, range);
  }
}
