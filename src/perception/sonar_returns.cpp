#include "perception/sonar_returns.hpp"
#include "core/exact.hpp"

#include <algorithm>
#include <cmath>

namespace threewe::perception {

std::vector<Vec2> sonar_arc(const RangeData& echo, double spacing) {
  if (echo.range >= echo.range_max) return {};
  const double range = std::max(echo.range, echo.range_min);
  const int gaps = 1 + static_cast<int>(range * echo.field_of_view / spacing);
  std::vector<Vec2> arc;
  for (int i = 0; i <= gaps; ++i) {
    const auto [s, c] = exact::sincos(echo.field_of_view * (static_cast<double>(i) / gaps - 0.5));
    arc.push_back({range * c, range * s});
  }
  return arc;
}

void SonarReturns::update(std::size_t sensor, const RangeData& echo, const Pose2D& odom_from_sensor) {
  if (sensor >= arcs_.size()) arcs_.resize(sensor + 1);
  arcs_[sensor] = sonar_arc(echo, spacing_);
  for (Vec2& point : arcs_[sensor]) point = odom_from_sensor * point;
  all_.clear();
  for (const std::vector<Vec2>& arc : arcs_) all_.insert(all_.end(), arc.begin(), arc.end());
}

}  // namespace threewe::perception
