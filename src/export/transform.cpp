#include "export/transform.hpp"

#include <algorithm>

namespace threewe::exports {

Quaternion about_x(double angle) { return {exact::cos(angle / 2), exact::sin(angle / 2), 0.0, 0.0}; }
Quaternion about_y(double angle) { return {exact::cos(angle / 2), 0.0, exact::sin(angle / 2), 0.0}; }
Quaternion about_z(double angle) { return {exact::cos(angle / 2), 0.0, 0.0, exact::sin(angle / 2)}; }

Quaternion operator*(const Quaternion& a, const Quaternion& b) {
  return {a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
          a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x, a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
}

Vec3 rotated(const Quaternion& q, const Vec3& v) {
  const Quaternion turned = q * Quaternion{0.0, v.x, v.y, v.z} * Quaternion{q.w, -q.x, -q.y, -q.z};
  return {turned.x, turned.y, turned.z};
}

Vec3 roll_pitch_yaw(const Quaternion& q) {
  const double roll = exact::atan2(2 * (q.w * q.x + q.y * q.z), 1 - 2 * (q.x * q.x + q.y * q.y));
  const double sine = std::clamp(2 * (q.w * q.y - q.z * q.x), -1.0, 1.0);
  const double pitch = exact::atan2(sine, exact::sqrt(1 - sine * sine));
  const double yaw = exact::atan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y * q.y + q.z * q.z));
  return {roll, pitch, yaw};
}

Transform operator*(const Transform& a_from_b, const Transform& b_from_c) {
  return {a_from_b * b_from_c.position, a_from_b.rotation * b_from_c.rotation};
}

Vec3 operator*(const Transform& a_from_b, const Vec3& point_in_b) {
  return a_from_b.position + rotated(a_from_b.rotation, point_in_b);
}

}  // namespace threewe::exports
