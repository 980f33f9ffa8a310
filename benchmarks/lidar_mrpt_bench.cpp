// One turn of the lidar, ours beside MRPT's (needs Debian's libmrpt-maps-dev): the same room, the same poses, the same
// run. Ours meets the exact shapes; MRPT marches through an occupancy grid of them with cells of 5 cm.
#include <benchmark/benchmark.h>
#include <mrpt/maps/COccupancyGridMap2D.h>
#include <mrpt/obs/CObservation2DRangeScan.h>

#include <vector>

#include "lidar_room.hpp"
#include "threewe/sim/ray_caster.hpp"

namespace {

using namespace threewe;
using namespace threewe::benchmarks;

constexpr double kCell = 0.05;  // [m]

// Times `cast(pose)`; the mean of all `range(beam)` shows that both see the same.
template <class Cast, class Range>
void time_turns(benchmark::State& state, const Cast& cast, const Range& range) {
  const auto poses = free_poses();
  const auto beams = static_cast<std::size_t>(state.range(0));
  double sum = 0.0;
  for (const Pose2D& pose : poses) {
    cast(pose);
    for (std::size_t i = 0; i < beams; ++i) sum += static_cast<double>(range(i));
  }
  std::size_t i = 0;
  for (auto _ : state) cast(poses[i++ % poses.size()]);
  const auto rays = static_cast<double>(beams);
  state.counters["mean_range"] = sum / (rays * static_cast<double>(poses.size()));
  state.counters["per_ray"] = benchmark::Counter(rays * static_cast<double>(state.iterations()),
                                                 benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

void ours(benchmark::State& state) {
  static const sim::RayCaster caster(room(), kRangeMax);
  std::vector<float> ranges(static_cast<std::size_t>(state.range(0)));
  const double increment = 2 * exact::kPi / static_cast<double>(ranges.size());
  const auto cast = [&](const Pose2D& pose) {
    caster.cast(pose, -exact::kPi, increment, ranges);
    benchmark::DoNotOptimize(ranges.data());
  };
  time_turns(state, cast, [&](std::size_t i) { return ranges[i]; });
}
BENCHMARK(ours)->Arg(64)->Arg(360);

// The cells that a box covers are occupied. Boxes are four segments each, the first along x from the lower left corner.
mrpt::maps::COccupancyGridMap2D grid_of(const scene::Slice& slice) {
  constexpr float kMargin = 0.2F;
  mrpt::maps::COccupancyGridMap2D grid(-kMargin, 20 + kMargin, -kMargin, 15 + kMargin, static_cast<float>(kCell));
  grid.fill(0.95F);
  for (std::size_t i = 0; i < slice.segments.size(); i += 4) {
    const Vec2 low = slice.segments[i].a;
    const Vec2 high = slice.segments[i + 1].b;
    const int columns = static_cast<int>(std::ceil((high.x - low.x) / (0.5 * kCell)));
    const int rows = static_cast<int>(std::ceil((high.y - low.y) / (0.5 * kCell)));
    for (int row = 0; row < rows; ++row) {
      for (int column = 0; column < columns; ++column) {
        const Vec2 point = low + 0.5 * kCell * Vec2{static_cast<double>(column), static_cast<double>(row)};
        grid.setCell(grid.x2idx(static_cast<float>(point.x)), grid.y2idx(static_cast<float>(point.y)), 0.02F);
      }
    }
  }
  return grid;
}

void mrpt(benchmark::State& state) {
  static const ::mrpt::maps::COccupancyGridMap2D grid = grid_of(room());
  ::mrpt::obs::CObservation2DRangeScan scan;
  scan.aperture = static_cast<float>(2 * exact::kPi);
  scan.maxRange = static_cast<float>(kRangeMax);
  scan.rightToLeft = true;
  const auto beams = static_cast<std::size_t>(state.range(0));
  const auto cast = [&](const Pose2D& pose) {
    grid.laserScanSimulator(scan, {pose.x, pose.y, pose.theta}, 0.5F, beams, 0.0F, 1, 0.0F);
  };
  const auto range = [&](std::size_t i) {
    return scan.getScanRangeValidity(i) ? scan.getScanRange(i) : static_cast<float>(kRangeMax);
  };
  time_turns(state, cast, range);
}
BENCHMARK(mrpt)->Arg(64)->Arg(360);

}  // namespace
