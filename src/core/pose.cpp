#include "threewe/core/pose.hpp"

#include <hwy/highway.h>

#include "core/exact.hpp"
#include "core/pose-inl.hpp"

namespace threewe {

double wrap_angle(double angle) { return HWY_NAMESPACE::wrap_angle(angle); }

Vec2 rotate(Vec2 v, double angle) {
  const auto [x, y] = HWY_NAMESPACE::rotate(v.x, v.y, angle);
  return {x, y};
}

Pose2D operator*(const Pose2D& a_from_b, const Pose2D& b_from_c) {
  const Vec2 p = a_from_b * b_from_c.position();
  return {p.x, p.y, wrap_angle(a_from_b.theta + b_from_c.theta)};
}

Vec2 operator*(const Pose2D& a_from_b, Vec2 point_in_b) {
  return a_from_b.position() + rotate(point_in_b, a_from_b.theta);
}

std::vector<Vec2> transformed(const Pose2D& a_from_b, std::span<const Vec2> points_in_b) {
  const auto [s, c] = exact::sincos(a_from_b.theta);
  std::vector<Vec2> points;
  points.reserve(points_in_b.size());
  for (const Vec2 p : points_in_b) points.push_back({c * p.x - s * p.y + a_from_b.x, s * p.x + c * p.y + a_from_b.y});
  return points;
}

Pose2D inverse(const Pose2D& a_from_b) {
  const Vec2 p = rotate({-a_from_b.x, -a_from_b.y}, -a_from_b.theta);
  return {p.x, p.y, wrap_angle(-a_from_b.theta)};
}

Pose2D interpolate(const Pose2D& a, const Pose2D& b, double t) {
  return {a.x + t * (b.x - a.x), a.y + t * (b.y - a.y), wrap_angle(a.theta + t * wrap_angle(b.theta - a.theta))};
}

bool is_finite(const Velocity& v) { return std::isfinite(v.vx) && std::isfinite(v.vy) && std::isfinite(v.omega); }
bool is_finite(const Pose2D& p) { return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.theta); }

Pose2D integrate(const Pose2D& pose, const Velocity& velocity, double seconds) {
  const auto [x, y, theta] = HWY_NAMESPACE::integrate<double>({pose.x, pose.y, pose.theta},
                                                              {velocity.vx, velocity.vy, velocity.omega}, seconds);
  return {x, y, theta};
}

}  // namespace threewe
