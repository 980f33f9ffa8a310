#include "perception/sonar_grid.hpp"
#include "core/exact.hpp"
#include "map/change_log.hpp"

#include <algorithm>
#include <utility>

namespace threewe::perception {
namespace {

constexpr double kSpacing = 0.04;  // [m] between two points of an arc, less than a cell

map::LogOddsMap::Settings evidence(const Params::Sonar& params) {
  map::LogOddsMap::Settings settings;
  settings.hit = static_cast<std::int8_t>(params.hit);
  settings.pass = static_cast<std::int8_t>(params.pass);
  settings.max = static_cast<std::int8_t>(params.most);
  settings.min = static_cast<std::int8_t>(params.least);
  return settings;
}

map::Beam beam(const Pose2D& map_from_sensor, double bearing, double range, bool hit) {
  return {.origin = map_from_sensor.position(),
          .direction = rotate({1.0, 0.0}, map_from_sensor.theta + bearing),
          .range = range,
          .hit = hit};
}

}  // namespace

SonarGrid::SonarGrid(const Params::Sonar& sonar, const Params::Bump& bump)
    : sonar_(sonar), bump_(bump), map_(evidence(sonar)) {}

void SonarGrid::update(const RangeData& echo, const Pose2D& map_from_sensor, bool explained) {
  if (echo.range >= echo.range_max) return;
  const double range = std::max(echo.range, echo.range_min);
  std::vector<map::Beam> beams;
  const double free = std::min(range, sonar_.trusted) - sonar_.before_arc;
  if (free > 0.0) {
    for (const double share : {-0.5, 0.0, 0.5}) {
      beams.push_back(beam(map_from_sensor, share * sonar_.middle * echo.field_of_view, free, false));
    }
  }
  if (range <= sonar_.trusted && !explained) {
    const int gaps = 1 + static_cast<int>(range * echo.field_of_view / kSpacing);
    for (int i = 0; i <= gaps; ++i) {
      const double share = static_cast<double>(i) / gaps - 0.5;
      beams.push_back(beam(map_from_sensor, share * echo.field_of_view, range, true));
    }
  }
  insert(beams);
}

bool SonarGrid::detect_bump(Vec2 push, const Footprint& footprint, const Pose2D& map_from_base) {
  const double strength = norm(push);
  if (strength < bump_.push) return false;
  const Vec2 towards = (-1.0 / strength) * push;
  double reach = 0.0;
  for (const Vec2 corner : footprint.corners()) reach = std::max(reach, dot(corner, towards));

  // a short bar across, just outside of the outline
  std::vector<map::Beam> beams;
  for (const double offset : {-bump_.half_width, 0.0, bump_.half_width}) {
    const Vec2 point = (reach + bump_.outside) * towards + offset * Vec2{-towards.y, towards.x};
    beams.push_back(beam(map_from_base, exact::atan2(point.y, point.x), norm(point), true));
  }
  for (int i = 0; i < 3; ++i) insert(beams);  // a bump is surer than a return
  return true;
}

// SonarReturns change little at a time: what is occupied is looked up there only.
void SonarGrid::insert(std::span<const map::Beam> beams) {
  const std::uint64_t before = map_.version();
  map_.insert(beams);
  const map::Region changed = map_.changes().since(before).value();
  if (changed.empty()) return;
  std::erase_if(occupied_, [&](map::Cell c) {
    return c.x >= changed.low.x && c.y >= changed.low.y && c.x < changed.high.x && c.y < changed.high.y;
  });
  const map::Cell low = map::raster_cell(grid());
  for (int y = changed.low.y; y < changed.high.y; ++y) {
    for (int x = changed.low.x; x < changed.high.x; ++x) {
      if (grid().at({x - low.x, y - low.y}) >= map::OccupancyGrid::kOccupiedThreshold) occupied_.push_back({x, y});
    }
  }
  std::ranges::sort(occupied_, [](map::Cell a, map::Cell b) { return std::pair(a.y, a.x) < std::pair(b.y, b.x); });
}

std::vector<Vec2> SonarGrid::occupied_near(Vec2 point, double radius) const {
  const map::Cell low = map::raster_cell(grid());
  std::vector<Vec2> near;
  for (const map::Cell c : occupied_) {
    const Vec2 center = grid().center({c.x - low.x, c.y - low.y});
    if (distance(center, point) <= radius) near.push_back(center);
  }
  return near;
}

}  // namespace threewe::perception
