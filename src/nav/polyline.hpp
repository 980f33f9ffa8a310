// Polyline geometry: places on a polyline, and near others.
#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <span>

#include "core/exact.hpp"
#include "threewe/core/pose.hpp"

namespace threewe::nav {

/// Whether a point is nearer to `place` than `reach` [m], of points that are given later.
inline auto near(Vec2 place, double reach) {
  return [=](Vec2 p) { return distance(p, place) < reach; };
}

/// A point on piece `piece`, between corners `piece` and `piece + 1`.
struct PathPoint {
  std::size_t piece = 0;
  Vec2 point;
};

/// The point of a polyline that is nearest to `p`, on pieces that begin within `reach` [m] of its start, so that a path
/// that comes back to a place is not cut short; the first of equals. `path` must not be empty.
inline PathPoint nearest_on_path(std::span<const Vec2> path, Vec2 p, double reach = 1.0) {
  PathPoint best{0, path[0]};
  double best_distance = distance(p, path[0]);
  for (std::size_t i = 0; i + 1 < path.size() && reach >= 0.0; ++i) {
    const Vec2 d = path[i + 1] - path[i];
    const double length_squared = dot(d, d);
    const double t = length_squared > 0.0 ? std::clamp(dot(p - path[i], d) / length_squared, 0.0, 1.0) : 0.0;
    const Vec2 q = path[i] + t * d;
    if (const double there = distance(p, q); there < best_distance) best = {i, q}, best_distance = there;
    reach -= exact::sqrt(length_squared);
  }
  return best;
}

/// The place `ahead` [m] further along, at most the end.
inline PathPoint place_after(std::span<const Vec2> path, const PathPoint& from, double ahead) {
  Vec2 here = from.point;
  for (std::size_t i = from.piece; i + 1 < path.size(); ++i) {
    const double length = distance(here, path[i + 1]);
    if (length >= ahead && length > 0.0) return {i, here + (ahead / length) * (path[i + 1] - here)};
    ahead -= length;
    here = path[i + 1];
  }
  return {path.size() - 1, path.back()};
}

inline Vec2 point_after(std::span<const Vec2> path, const PathPoint& from, double ahead) {
  return place_after(path, from, ahead).point;
}

/// Length [m] from a point on the path to its end.
inline double length_after(std::span<const Vec2> path, const PathPoint& from) {
  double sum = 0.0;
  Vec2 here = from.point;
  for (std::size_t i = from.piece + 1; i < path.size(); ++i) {
    sum += distance(here, path[i]);
    here = path[i];
  }
  return sum;
}

/// The first point of a polyline for which `holds`, in steps of `step` [m].
template <class Holds>
std::optional<Vec2> first_along(std::span<const Vec2> path, double step, Holds holds) {
  if (path.empty()) return {};
  const int steps = static_cast<int>(length_after(path, {0, path.front()}) / step);
  for (int i = 0; i <= steps; ++i) {
    const Vec2 p = point_after(path, {0, path.front()}, step * i);
    if (holds(p)) return p;
  }
  return {};
}

}  // namespace threewe::nav
