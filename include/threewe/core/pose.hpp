// Points, poses and velocities in the plane. Right-handed, X forward, Y left, angles counter-clockwise [rad].
#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

namespace threewe {

/// A point or a direction in the plane [m].
struct Vec2 {
  double x = 0.0;  ///< [m] ahead
  double y = 0.0;  ///< [m] to the left
  friend bool operator==(const Vec2&, const Vec2&) = default;
};

/// Component by component.
constexpr Vec2 operator+(Vec2 a, Vec2 b) { return {a.x + b.x, a.y + b.y}; }
/// Component by component.
constexpr Vec2 operator-(Vec2 a, Vec2 b) { return {a.x - b.x, a.y - b.y}; }
/// `s` times as long.
constexpr Vec2 operator*(double s, Vec2 a) { return {s * a.x, s * a.y}; }
/// The scalar product.
constexpr double dot(Vec2 a, Vec2 b) { return a.x * b.x + a.y * b.y; }
/// The z component of the cross product: positive when `b` lies counter-clockwise of `a`.
constexpr double cross(Vec2 a, Vec2 b) { return a.x * b.y - a.y * b.x; }
/// The length [m].
inline double norm(Vec2 a) { return std::sqrt(dot(a, a)); }  // correctly rounded on every machine (IEEE 754)
/// The distance [m] between two points.
inline double distance(Vec2 a, Vec2 b) { return norm(a - b); }
/// The point between `a` and `b` that is nearest to `p`.
constexpr Vec2 closest_on_segment(Vec2 p, Vec2 a, Vec2 b) {
  const Vec2 along = b - a;
  const double length_squared = dot(along, along);
  if (length_squared == 0.0) return a;
  return a + std::clamp(dot(p - a, along) / length_squared, 0.0, 1.0) * along;
}
/// The distance from `p` to the nearest point between `a` and `b`.
inline double distance_to_segment(Vec2 p, Vec2 a, Vec2 b) { return distance(p, closest_on_segment(p, a, b)); }

/// The same angle in (-pi, pi].
double wrap_angle(double angle);

/// A pose in the plane: position [m] and heading [rad] in (-pi, pi].
/// A transform is a pose too, and is named for what it maps: `map_from_base * base_from_lidar == map_from_lidar`.
struct Pose2D {
  double x = 0.0;      ///< [m] ahead
  double y = 0.0;      ///< [m] to the left
  double theta = 0.0;  ///< [rad] counter-clockwise, in (-pi, pi]
  /// The position [m] without the heading.
  constexpr Vec2 position() const { return {x, y}; }
  friend bool operator==(const Pose2D&, const Pose2D&) = default;
};

/// Composition: `a_from_b * b_from_c` is `a_from_c`.
Pose2D operator*(const Pose2D& a_from_b, const Pose2D& b_from_c);
/// `a_from_b * point_in_b` is the point in a.
Vec2 operator*(const Pose2D& a_from_b, Vec2 point_in_b);
/// The same for many points.
std::vector<Vec2> transformed(const Pose2D& a_from_b, std::span<const Vec2> points_in_b);
/// `inverse(a_from_b)` is `b_from_a`.
Pose2D inverse(const Pose2D& a_from_b);
/// The pose a fraction `t` of the way from `a` to `b`: straight in position, the short way round in heading.
Pose2D interpolate(const Pose2D& a, const Pose2D& b, double t);
/// `v` turned counter-clockwise by `angle` [rad].
Vec2 rotate(Vec2 v, double angle);

/// A velocity in the body frame: forward and left [m/s], counter-clockwise [rad/s].
struct Velocity {
  double vx = 0.0;     ///< [m/s] ahead
  double vy = 0.0;     ///< [m/s] to the left
  double omega = 0.0;  ///< [rad/s] counter-clockwise
  friend bool operator==(const Velocity&, const Velocity&) = default;
};

/// True when every component is finite.
bool is_finite(const Velocity& v);
/// True when every component is finite.
bool is_finite(const Pose2D& p);

/// The pose after moving at a constant body velocity for `seconds`, exact along the arc.
Pose2D integrate(const Pose2D& pose, const Velocity& velocity, double seconds);

}  // namespace threewe
