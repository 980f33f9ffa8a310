#include "threewe/map/zone.hpp"

#include <algorithm>
#include <cstddef>
#include <limits>

namespace threewe::map {

bool Zone::contains(Vec2 point) const {
  bool inside = false;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec2 a = corners[i];
    const Vec2 b = corners[(i + 1) % corners.size()];
    if ((a.y > point.y) == (b.y > point.y)) continue;
    if (point.x < a.x + (point.y - a.y) / (b.y - a.y) * (b.x - a.x)) inside = !inside;
  }
  return inside;
}

double Zone::distance_to(Vec2 point) const {
  if (contains(point)) return 0.0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec2 a = corners[i];
    const Vec2 along = corners[(i + 1) % corners.size()] - a;
    const double t = std::clamp(dot(point - a, along) / std::max(dot(along, along), 1e-18), 0.0, 1.0);
    least = std::min(least, distance(point, a + t * along));
  }
  return least;
}

}  // namespace threewe::map
