// Rigid transforms in space, as exported files state them. Right-handed, X forward, Y left, Z up.
#pragma once

#include "core/exact.hpp"

namespace threewe::exports {

/// A point or a direction in space [m].
struct Vec3 {
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;
  friend bool operator==(const Vec3&, const Vec3&) = default;
};

constexpr Vec3 operator+(const Vec3& a, const Vec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
constexpr Vec3 operator-(const Vec3& a, const Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
constexpr Vec3 operator*(double s, const Vec3& a) { return {s * a.x, s * a.y, s * a.z}; }

/// A rotation, as a unit quaternion.
struct Quaternion {
  double w = 1.0;
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;
  friend bool operator==(const Quaternion&, const Quaternion&) = default;
};

/// Turns by an angle [rad] about an axis.
Quaternion about_x(double angle);
Quaternion about_y(double angle);
Quaternion about_z(double angle);
/// `b` first, then `a`.
Quaternion operator*(const Quaternion& a, const Quaternion& b);
/// A direction, turned.
Vec3 rotated(const Quaternion& rotation, const Vec3& v);
/// The angles [rad] by which URDF and SDF turn about the fixed axes: x first, then y, then z.
Vec3 roll_pitch_yaw(const Quaternion& rotation);

/// Where something is, and how it is turned, in the frame of another: `a_from_b`.
struct Transform {
  Vec3 position;
  Quaternion rotation;
  friend bool operator==(const Transform&, const Transform&) = default;
};

/// `a_from_b * b_from_c` is `a_from_c`.
Transform operator*(const Transform& a_from_b, const Transform& b_from_c);
/// `a_from_b * point_in_b` is the point in a.
Vec3 operator*(const Transform& a_from_b, const Vec3& point_in_b);

}  // namespace threewe::exports
