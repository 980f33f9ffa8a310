// Keep-out and speed-limit zones: polygons on the floor.
#pragma once

#include <optional>
#include <vector>

#include "threewe/core/pose.hpp"

namespace threewe::map {

/// A polygon on the floor. Without a `speed_limit` it is kept out of: no part of the body is planned to enter it.
struct Zone {
  std::vector<Vec2> corners;            ///< [m] in `map`, in order, at least three; the last is joined to the first
  std::optional<double> speed_limit{};  ///< [m/s] while any part of the body is in it

  /// Whether a point lies inside (by crossings: Shimrat 1962).
  bool contains(Vec2 point) const;
  /// Distance [m] from a point to the zone, 0 inside.
  double distance_to(Vec2 point) const;
  friend bool operator==(const Zone&, const Zone&) = default;
};

}  // namespace threewe::map
