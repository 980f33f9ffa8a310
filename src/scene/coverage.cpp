#include "scene/coverage.hpp"

#include <algorithm>
#include <utility>

#include "core/exact.hpp"
#include "scene/cell_lines.hpp"
#include "threewe/scene/solid.hpp"

namespace threewe::scene {
namespace {

constexpr int kRays = 360;
constexpr double kMapError = 0.10;  // [m] that a map may be off

// The shapes that a ray from a point can meet.
Slice within_range(const Slice& slice, Vec2 point) {
  Slice near;
  for (const Segment& s : slice.segments) {
    const bool faces = cross(s.b - s.a, point - s.a) < 0.0;
    if (faces && distance_to_segment(point, s.a, s.b) < kCoverageRange) near.segments.push_back(s);
  }
  for (const Circle& c : slice.circles) {
    if (distance(point, c.center) - c.radius < kCoverageRange) near.circles.push_back(c);
  }
  return near;
}

// The middle and a 5 cm lattice around it, within the error that a map may have; the nearest first.
std::vector<Vec2> tolerated_offsets() {
  std::vector<Vec2> offsets;
  for (int y = -2; y <= 2; ++y) {
    for (int x = -2; x <= 2; ++x) {
      const Vec2 offset{x * kCellSize, y * kCellSize};
      if (norm(offset) <= kMapError + 1e-9) offsets.push_back(offset);
    }
  }
  std::ranges::stable_sort(offsets, {}, [](Vec2 offset) { return norm(offset); });
  return offsets;
}

}  // namespace

CellSet coverable_cells(const SceneTables& tables) {
  const CellGrid<float> distance = distance_field(tables.reachable());
  CellSet coverable(distance.frame, 0);
  for (std::size_t i = 0; i < coverable.cells.size(); ++i) {
    const bool covered = static_cast<double>(distance.cells[i]) <= tables.passing_radius();
    coverable.cells[i] = covered && !tables.occupied().cells[i] ? 1 : 0;
  }
  return coverable;
}

CoverageMeter::CoverageMeter(std::shared_ptr<const SceneTables> tables, double lidar_height)
    : tables_(std::move(tables)),
      slice_(tables_->scene().at_height(lidar_height)),
      reachable_(coverable_cells(*tables_)),
      crossed_(reachable_.frame, 0) {}

void CoverageMeter::observe(const Pose2D& scene_from_lidar) {
  const Vec2 origin = scene_from_lidar.position();
  const Slice near = within_range(slice_, origin);
  for (int i = 0; i < kRays; ++i) {
    const double angle = scene_from_lidar.theta + i * (2.0 * exact::kPi / kRays);
    const double range = cast_ray(near, origin, angle, kCoverageRange);
    walk_line(crossed_.frame, origin, origin + rotate({range, 0.0}, angle), [&](CellIndex cell) {
      if (crossed_.frame.contains(cell)) crossed_[cell] = 1;
      return true;
    });
  }
}

double CoverageMeter::coverage(const std::function<bool(Vec2)>& is_free) const {
  static const std::vector<Vec2> kOffsets = tolerated_offsets();
  std::size_t reachable = 0;
  std::size_t covered = 0;
  for (std::size_t i = 0; i < reachable_.cells.size(); ++i) {
    if (!reachable_.cells[i]) continue;
    ++reachable;
    if (!crossed_.cells[i]) continue;
    const Vec2 middle = reachable_.frame.center(reachable_.frame.cell(i));
    covered += std::ranges::any_of(kOffsets, [&](Vec2 offset) { return is_free(middle + offset); }) ? 1U : 0U;
  }
  return reachable == 0 ? 0.0 : static_cast<double>(covered) / static_cast<double>(reachable);
}

double CoverageMeter::crossed() const {
  return coverage([](Vec2) { return true; });
}

}  // namespace threewe::scene
