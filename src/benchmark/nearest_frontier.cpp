#include "benchmark/nearest_frontier.hpp"

#include <cstddef>
#include <vector>

#include "benchmark/sight.hpp"
#include "scene/coverage.hpp"

namespace threewe::benchmark {
namespace {

using scene::CellIndex, scene::CellSet;

constexpr std::size_t kLeast = 8;  // [cells] smaller frontiers are not worth a walk
constexpr int kGap = 12;           // unknown cells of 5 x 5 that make a gap of more than a slit between beams
constexpr double kReplan = 0.5;    // [m] walked before the nearest frontier is looked for again
constexpr double kLongestExploration = 2000.0;  // [m] no exploration of our scenes is longer

// Known cells to stand on, each beside an unknown one in a gap.
bool is_frontier(const CellSet& standable, const CellSet& known, CellIndex cell) {
  if (!standable.value_or(cell, 0)) return false;
  for (const CellIndex next : {CellIndex{cell.x + 1, cell.y}, CellIndex{cell.x - 1, cell.y},
                               CellIndex{cell.x, cell.y + 1}, CellIndex{cell.x, cell.y - 1}}) {
    if (known.value_or(next, 0)) continue;
    int unknown = 0;
    for (int i = 0; i < 25; ++i) unknown += known.value_or({next.x + i % 5 - 2, next.y + i / 5 - 2}, 0) ? 0 : 1;
    if (unknown >= kGap) return true;
  }
  return false;
}

// The cells of all 8-connected groups that are large enough.
std::vector<std::size_t> large_groups(CellSet candidates) {
  std::vector<std::size_t> found;
  for (std::size_t first = 0; first < candidates.cells.size(); ++first) {
    if (!candidates.cells[first]) continue;
    std::vector<std::size_t> group = {first};
    candidates.cells[first] = 0;
    for (std::size_t next = 0; next < group.size(); ++next) {
      const CellIndex at = candidates.frame.cell(group[next]);
      for (int i = 0; i < 9; ++i) {
        const CellIndex cell{at.x + i % 3 - 1, at.y + i / 3 - 1};
        if (!candidates.value_or(cell, 0)) continue;
        candidates[cell] = 0;
        group.push_back(candidates.frame.index(cell));
      }
    }
    if (group.size() >= kLeast) found.insert(found.end(), group.begin(), group.end());
  }
  return found;
}

class Explorer {
 public:
  Explorer(const scene::SceneTables& tables, const RobotProfile& profile)
      : sight_(tables, profile, 0.0), visited_(sight_.known().frame, 0) {}

  // A frontier that stays one when it is looked at from within a cell shows nothing more.
  void look(const Pose2D& scene_from_base) {
    sight_.look(scene_from_base);
    const CellIndex here = visited_.frame.cell(scene_from_base.position());
    for (int i = 0; i < 9; ++i) {
      const CellIndex cell{here.x + i % 3 - 1, here.y + i / 3 - 1};
      if (visited_.frame.contains(cell)) visited_[cell] = 1;
    }
  }

  // To the nearest frontier; empty where none can be reached.
  std::vector<Vec2> way_from(Vec2 here) const {
    CellSet standable = sight_.known();
    for (std::size_t i = 0; i < standable.cells.size(); ++i) standable.cells[i] &= sight_.open().cells[i];
    CellSet frontier(standable.frame, 0);
    for (std::size_t i = 0; i < frontier.cells.size(); ++i) {
      if (standable.cells[i] && !visited_.cells[i]) {
        frontier.cells[i] = is_frontier(standable, sight_.known(), frontier.frame.cell(i)) ? 1 : 0;
      }
    }
    return scene::GeodesicField(standable, large_groups(std::move(frontier))).path_from(here);
  }

  bool is_open(const std::vector<Vec2>& path) const { return sight_.is_open(path); }

 private:
  Sight sight_;
  CellSet visited_;
};

}  // namespace

ReferenceExploration nearest_frontier(const std::shared_ptr<const scene::SceneTables>& tables,
                                      const RobotProfile& profile, const Pose2D& start) {
  require_inside(*tables, "start", start.position());
  Explorer explorer(*tables, profile);
  scene::CoverageMeter meter(tables, profile.lidar->height);
  Walk walk(start.position());
  std::vector<Vec2> path;
  double planned_at = 0.0;
  while (walk.length() < kLongestExploration) {
    const Pose2D here{walk.here().x, walk.here().y, start.theta};
    explorer.look(here);
    meter.observe(here * profile.lidar->base_from_lidar);
    if (path.size() < 2 || walk.length() - planned_at >= kReplan || !explorer.is_open(path)) {
      path = explorer.way_from(walk.here());
      planned_at = walk.length();
      if (path.size() < 2) break;
    }
    walk.along(path, kStride);
  }
  return {meter.crossed(), walk.length(), walk.length() / profile.operating_limits.linear};
}

}  // namespace threewe::benchmark
