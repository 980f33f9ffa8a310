#include "perception/sonar_grid.hpp"
#include "core/exact.hpp"
#include "map/change_log.hpp"

#include <algorithm>
#include <utility>

namespace threewe::perception {
namespace {

constexpr double kTrusted = 1.5;      // [m] beyond, an arc is so wide that it would close doors
constexpr double kMiddle = 0.4;       // share of the cone that is taken to be free
constexpr double kBeforeArc = 0.075;  // [m] left out between what is free and the arc
constexpr double kBump = 7.5;         // [m/s^2] beyond what tyres give on a hard floor
constexpr double kOutside = 0.02;     // [m] off the outline stands what was bumped into
constexpr double kSpacing = 0.04;     // [m] between two points of an arc, less than a cell

map::LogOddsMap::Settings evidence() {
  map::LogOddsMap::Settings settings;
  settings.hit = 12;   // one echo makes an obstacle ...
  settings.pass = -5;  // ... and two that pass through unmake it
  settings.max = 40;
  settings.min = -24;
  return settings;
}

map::Beam beam(const Pose2D& map_from_sensor, double bearing, double range, bool hit) {
  return {.origin = map_from_sensor.position(),
          .direction = rotate({1.0, 0.0}, map_from_sensor.theta + bearing),
          .range = range,
          .hit = hit};
}

}  // namespace

SonarGrid::SonarGrid() : map_(evidence()) {}

void SonarGrid::update(const RangeData& echo, const Pose2D& map_from_sensor, bool explained) {
  if (echo.range >= echo.range_max) return;
  const double range = std::max(echo.range, echo.range_min);
  std::vector<map::Beam> beams;
  const double free = std::min(range, kTrusted) - kBeforeArc;
  if (free > 0.0) {
    for (const double share : {-0.5, 0.0, 0.5}) {
      beams.push_back(beam(map_from_sensor, share * kMiddle * echo.field_of_view, free, false));
    }
  }
  if (range <= kTrusted && !explained) {
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
  if (strength < kBump) return false;
  const Vec2 towards = (-1.0 / strength) * push;
  double reach = 0.0;
  for (const Vec2 corner : footprint.corners()) reach = std::max(reach, dot(corner, towards));

  // a short bar across, just outside of the outline
  std::vector<map::Beam> beams;
  for (const double aside : {-0.05, 0.0, 0.05}) {
    const Vec2 point = (reach + kOutside) * towards + aside * Vec2{-towards.y, towards.x};
    beams.push_back(beam(map_from_base, exact::atan2(point.y, point.x), norm(point), true));
  }
  for (int i = 0; i < 3; ++i) insert(beams);  // felt is surer than heard
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
