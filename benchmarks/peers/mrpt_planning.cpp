// MRPT: its planner for grids, waves from start and goal through cells (needs Debian's libmrpt-nav-dev).
#include <mrpt/nav/planners/PlannerSimple2D.h>
#include <mrpt/version.h>

#include <deque>

#include "course.hpp"

namespace {

constexpr std::size_t kQueries = 25;  // they take long

mrpt::maps::COccupancyGridMap2D grid_of(const peers::Course& course) {
  mrpt::maps::COccupancyGridMap2D grid;
  const double width = course.width * course.resolution;
  const double height = course.height * course.resolution;
  grid.setSize(0.0F, static_cast<float>(width), 0.0F, static_cast<float>(height),
               static_cast<float>(course.resolution));
  for (int y = 0; y < course.height; ++y) {
    for (int x = 0; x < course.width; ++x) grid.setCell(x, y, course.is_free(x, y) ? 1.0F : 0.0F);
  }
  return grid;
}

}  // namespace

int main(int, char** argv) {
  const peers::Course course = peers::read_course(argv[1]);
  const mrpt::maps::COccupancyGridMap2D grid = grid_of(course);
  mrpt::nav::PlannerSimple2D planner;
  planner.robotRadius = 0.0F;            // obstacles have it already: it would grow them in each plan
  planner.minStepInReturnedPath = 0.0F;  // every cell: leaving some out cuts corners
  const std::string version = std::to_string(MRPT_VERSION >> 8 & 0xF) + "." + std::to_string(MRPT_VERSION >> 4 & 0xF) +
                              "." + std::to_string(MRPT_VERSION & 0xF);
  peers::report_plans("MRPT " + version + ", PlannerSimple2D",
                      "waves over 8-connected cells from both ends; nothing kept, nothing dear near obstacles; C++",
                      course, kQueries, [&](const peers::Query& q) {
                        std::deque<mrpt::math::TPoint2D> found;
                        bool none = false;
                        planner.computePath(grid, {q.from.x, q.from.y, 0.0}, {q.to.x, q.to.y, 0.0}, found, none);
                        std::vector<peers::Point> way;
                        if (none) return way;
                        way.push_back(q.from);
                        for (const auto& p : found) way.push_back({p.x, p.y});
                        return way;
                      });
}
