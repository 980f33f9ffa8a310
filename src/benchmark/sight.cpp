#include "benchmark/sight.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/exact.hpp"
#include "scene/cell_lines.hpp"
#include "scene/coverage.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::benchmark {
namespace {

using scene::CellIndex, scene::GridFrame;

constexpr double kTouch = 0.10;  // [m] obstacles that no beam can meet are known this far from where the robot passes

LidarSpec lidar_of(const RobotProfile& profile) {
  if (profile.lidar) return *profile.lidar;
  throw HardwareError(fmt::format("robot '{}' has no sensor 'lidar', which the reference needs", profile.name));
}

GridFrame widened(GridFrame frame, double around) {
  const int cells = static_cast<int>(around / frame.resolution);
  frame.origin = frame.origin - Vec2{cells * frame.resolution, cells * frame.resolution};
  frame.width += 2 * cells;
  frame.height += 2 * cells;
  return frame;
}

// The shapes that a ray from a point can meet.
scene::Slice within(const scene::Slice& slice, Vec2 point, double range) {
  scene::Slice near;
  for (const scene::Segment& s : slice.segments) {
    const Vec2 along = s.b - s.a;
    const double t = std::clamp(dot(point - s.a, along) / std::max(dot(along, along), 1e-12), 0.0, 1.0);
    const bool faces = cross(along, point - s.a) < 0.0;
    if (faces && distance(point, s.a + t * along) < range) near.segments.push_back(s);
  }
  for (const scene::Circle& c : slice.circles) {
    if (distance(point, c.center) - c.radius < range) near.circles.push_back(c);
  }
  return near;
}

}  // namespace

Sight::Sight(const scene::SceneTables& tables, const RobotProfile& profile, double around)
    : tables_(&tables),
      lidar_(lidar_of(profile)),
      slice_(tables.scene().at_height(lidar_.height)),
      open_(widened(tables.passable().frame, around), 1),
      known_(open_.frame, 0) {}

void Sight::look(const Pose2D& scene_from_base) {
  const Pose2D lidar = scene_from_base * lidar_.base_from_lidar;
  const scene::Slice near = within(slice_, lidar.position(), lidar_.range_max);
  for (int i = 0; i < lidar_.beams; ++i) {
    const double angle = lidar.theta + i * (2.0 * exact::kPi / lidar_.beams);
    const double range = scene::cast_ray(near, lidar.position(), angle, lidar_.range_max);
    add_beam(lidar.position(), rotate({1.0, 0.0}, angle), range);
  }
  const Vec2 robot = scene_from_base.position();
  const scene::CellSet& passable = tables_->passable();
  for_cells(robot, kTouch, [&](CellIndex cell) {
    if (!passable.value_or(passable.frame.cell(open_.frame.center(cell)), 0)) open_[cell] = 0;
  });
}

void require_inside(const scene::SceneTables& tables, const char* name, Vec2 place) {
  const auto& [low, high] = std::pair(tables.scene().min, tables.scene().max);
  if (place.x >= low.x && place.x <= high.x && place.y >= low.y && place.y <= high.y) return;
  throw ContractError(fmt::format("{}: ({:g}, {:g}) is outside of scene '{}', which spans ({:g}, {:g}) to ({:g}, {:g})",
                                  name, place.x, place.y, tables.scene().name, low.x, low.y, high.x, high.y));
}

bool Sight::is_open(const std::vector<Vec2>& path) const {
  const auto open = [&](CellIndex cell) { return open_.value_or(cell, 0) != 0; };
  for (std::size_t i = 1; i < path.size(); ++i) {
    if (!scene::walk_line(open_.frame, path[i - 1], path[i], open)) return false;
  }
  return true;
}

void Sight::add_beam(Vec2 origin, Vec2 direction, double range) {
  const double free = std::min(range, scene::kCoverageRange);
  scene::mark_line(known_.frame, origin, origin + free * direction, [&](std::size_t cell) { known_.cells[cell] = 1; });
  if (range >= lidar_.range_max) return;
  for_cells(origin + range * direction, tables_->passing_radius(), [&](CellIndex cell) { open_[cell] = 0; });
}

// Those whose middles are nearer than that.
template <class Visit>
void Sight::for_cells(Vec2 point, double radius, Visit visit) {
  const CellIndex middle = open_.frame.cell(point);
  const int reach = static_cast<int>(radius / open_.frame.resolution) + 1;
  for (int y = middle.y - reach; y <= middle.y + reach; ++y) {
    for (int x = middle.x - reach; x <= middle.x + reach; ++x) {
      const CellIndex cell{x, y};
      if (open_.frame.contains(cell) && distance(open_.frame.center(cell), point) < radius) visit(cell);
    }
  }
}

void Walk::along(std::vector<Vec2>& path, double far) {
  std::size_t passed = 0;
  while (passed + 1 < path.size() && far > 0.0) {
    const Vec2 next = path[passed + 1];
    const double piece = distance(here_, next);
    const double step = std::min(piece, far);
    here_ = piece > far ? here_ + (far / piece) * (next - here_) : next;
    length_ += step;
    far -= step;
    if (here_ == next) ++passed;
  }
  path.erase(path.begin(), path.begin() + static_cast<std::ptrdiff_t>(passed));
  path.front() = here_;
}

}  // namespace threewe::benchmark
