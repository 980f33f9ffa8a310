#include "robot/echo_map.hpp"

#include <algorithm>
#include <cstddef>

namespace threewe {
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

EchoMap::EchoMap() : map_(evidence()) {}

void EchoMap::hear(const RangeData& echo, const Pose2D& map_from_sensor, bool explained) {
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
  map_.insert(beams);
}

bool EchoMap::feel(Vec2 push, const Footprint& footprint, const Pose2D& map_from_base) {
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
  for (int i = 0; i < 3; ++i) map_.insert(beams);  // felt is surer than heard
  return true;
}

std::vector<Vec2> EchoMap::occupied_near(Vec2 point, double radius) const {
  const map::OccupancyGrid& map = grid();
  const map::Cell low = map.cell(point - Vec2{radius, radius});
  const map::Cell high = map.cell(point + Vec2{radius, radius});
  std::vector<Vec2> occupied;
  const int from = std::max(low.x, 0);
  const int to = std::min(high.x, map.width - 1);
  for (int y = std::max(low.y, 0); y <= std::min(high.y, map.height - 1) && from <= to; ++y) {
    // next to nothing is occupied: a look at the whole row, without a branch for each cell
    const std::int8_t* row = map.data.data() + map.index({0, y});
    std::int8_t most = map::OccupancyGrid::kUnknown;
    for (int x = from; x <= to; ++x) most = std::max(most, row[x]);
    if (most < map::OccupancyGrid::kOccupiedThreshold) continue;
    for (int x = from; x <= to; ++x) {
      if (row[x] < map::OccupancyGrid::kOccupiedThreshold) continue;
      const Vec2 center = map.center({x, y});
      if (distance(center, point) <= radius) occupied.push_back(center);
    }
  }
  return occupied;
}

}  // namespace threewe
