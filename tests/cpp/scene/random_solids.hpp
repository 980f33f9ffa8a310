// Random solids, and what they are by the slow and obvious way.
#pragma once

#include <vector>

#include "core/exact.hpp"
#include "core/rng.hpp"
#include "threewe/scene/solid.hpp"

namespace threewe::scene {

/// Draws numbers one after the other.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : key_{.seed = seed, .stream = Stream::scene} {}
  double in(double low, double high) { return uniform(key_, sample_++, 0, low, high); }
  bool coin() { return in(0.0, 1.0) < 0.5; }

 private:
  RngKey key_;
  std::uint64_t sample_ = 0;
};

/// A box or a disc with its middle in a square of `extent` [m] around the origin.
inline Solid random_solid(Dice& dice, double extent) {
  const Pose2D pose{dice.in(-extent, extent), dice.in(-extent, extent), dice.in(-exact::kPi, exact::kPi)};
  return dice.coin() ? make_box(pose, dice.in(0.05, 1.5), dice.in(0.05, 0.8))
                     : make_disc(pose.position(), dice.in(0.02, 0.5));
}

inline std::vector<Solid> random_solids(Dice& dice, int count, double extent) {
  std::vector<Solid> solids;
  for (int i = 0; i < count; ++i) solids.push_back(random_solid(dice, extent));
  return solids;
}

/// Whether a point is inside, from the definition of the shapes alone.
inline bool holds(const Solid& solid, Vec2 point) {
  if (solid.shape == Solid::Shape::disc) return distance(solid.center, point) <= solid.radius;
  const Vec2 along = solid.corners[1] - solid.corners[0];
  const Vec2 across = solid.corners[3] - solid.corners[0];
  const double a = dot(point - solid.corners[0], along) / dot(along, along);
  const double b = dot(point - solid.corners[0], across) / dot(across, across);
  return a >= 0.0 && a <= 1.0 && b >= 0.0 && b <= 1.0;
}

/// Points on the outline, `spacing` [m] apart or less.
inline std::vector<Vec2> outline_points(std::span<const Vec2> polygon, double spacing) {
  std::vector<Vec2> points;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec2 a = polygon[i];
    const Vec2 b = polygon[(i + 1) % polygon.size()];
    const int steps = static_cast<int>(distance(a, b) / spacing) + 1;
    for (int k = 0; k < steps; ++k) points.push_back(a + (static_cast<double>(k) / steps) * (b - a));
  }
  return points;
}

inline std::vector<Vec2> outline_points(const Solid& solid, double spacing) {
  if (solid.shape == Solid::Shape::box) return outline_points(solid.corners, spacing);
  std::vector<Vec2> points;
  const int steps = static_cast<int>(2.0 * exact::kPi * solid.radius / spacing) + 1;
  for (int k = 0; k < steps; ++k)
    points.push_back(solid.center + rotate({solid.radius, 0.0}, 2.0 * exact::kPi * k / steps));
  return points;
}

}  // namespace threewe::scene
