#include "threewe/core/pose.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include "core/exact.hpp"
#include "draw.hpp"

namespace threewe {
namespace {

constexpr double kPi = exact::kPi;

void check_near(const Pose2D& a, const Pose2D& b, double tolerance) {
  CHECK(std::fabs(a.x - b.x) <= tolerance);
  CHECK(std::fabs(a.y - b.y) <= tolerance);
  CHECK(std::fabs(wrap_angle(a.theta - b.theta)) <= tolerance);
}

TEST_CASE("wrapped angles lie in (-pi, pi] and differ by whole turns") {
  Draw draw(1);
  for (int i = 0; i < 20000; ++i) {
    const double angle = i % 2 ? draw(-20.0, 20.0) : draw(-1e5, 1e5);
    const double wrapped = wrap_angle(angle);
    CAPTURE(angle);
    REQUIRE(wrapped > -kPi);
    REQUIRE(wrapped <= kPi);
    const double turns = (angle - wrapped) / (2 * kPi);
    REQUIRE(std::fabs(turns - std::round(turns)) < 1e-9);
    REQUIRE(wrap_angle(wrapped) == wrapped);
  }
}

TEST_CASE("wrapping at the ends and just beyond them") {
  CHECK(wrap_angle(kPi) == kPi);
  CHECK(wrap_angle(-kPi) == kPi);
  CHECK(wrap_angle(0.0) == 0.0);
  for (int k = -9; k <= 9; k += 2) {
    for (int step = -3; step <= 3; ++step) {
      double angle = k * kPi;
      for (int i = 0; i < std::abs(step); ++i) {
        angle = std::nextafter(
            angle, step < 0 ? -std::numeric_limits<double>::infinity() : std::numeric_limits<double>::infinity());
      }
      CAPTURE(angle);
      const double wrapped = wrap_angle(angle);
      CHECK(wrapped > -kPi);
      CHECK(wrapped <= kPi);
      CHECK(std::fabs(std::fabs(wrapped) - kPi) < 1e-13);
    }
  }
}

TEST_CASE("poses are a group") {
  Draw draw(2);
  for (int i = 0; i < 5000; ++i) {
    CAPTURE(i);
    const Pose2D a = draw.pose(-50.0, 50.0);
    const Pose2D b = draw.pose(-50.0, 50.0);
    const Pose2D c = draw.pose(-50.0, 50.0);
    check_near((a * b) * c, a * (b * c), 1e-12);
    check_near(a * inverse(a), {}, 1e-12);
    check_near(inverse(a) * a, {}, 1e-12);
    check_near(inverse(a * b), inverse(b) * inverse(a), 1e-12);
    CHECK(a * Pose2D{} == a);
    CHECK(Pose2D{} * a == a);
  }
}

TEST_CASE("a pose maps points as a rotation and a shift") {
  Draw draw(3);
  for (int i = 0; i < 5000; ++i) {
    CAPTURE(i);
    const Pose2D a = draw.pose(-50.0, 50.0);
    const Pose2D b = draw.pose(-50.0, 50.0);
    const Vec2 p = draw.point(-50.0, 50.0);
    const Vec2 q = draw.point(-50.0, 50.0);
    CHECK(distance(a * p, a * q) == doctest::Approx(distance(p, q)).epsilon(1e-12));
    CHECK(distance((a * b) * p, a * (b * p)) < 1e-12);
    const double s = std::sin(a.theta);
    const double c = std::cos(a.theta);
    CHECK(distance(a * p, {a.x + c * p.x - s * p.y, a.y + s * p.x + c * p.y}) < 1e-12);
    CHECK(cross(p, rotate(p, kPi / 2)) == doctest::Approx(dot(p, p)));
  }
}

TEST_CASE("interpolation takes the short way round") {
  const Pose2D a{0.0, 0.0, kPi - 0.1};
  const Pose2D b{2.0, -4.0, -kPi + 0.1};
  check_near(interpolate(a, b, 0.5), {1.0, -2.0, kPi}, 1e-15);
  check_near(interpolate(a, b, 0.25), {0.5, -1.0, kPi - 0.05}, 1e-15);
  Draw draw(4);
  for (int i = 0; i < 2000; ++i) {
    CAPTURE(i);
    const Pose2D p = draw.pose(-50.0, 50.0);
    const Pose2D q = draw.pose(-50.0, 50.0);
    CHECK(interpolate(p, q, 0.0) == p);
    check_near(interpolate(p, q, 1.0), q, 1e-13);
    check_near(interpolate(p, q, 0.3), interpolate(q, p, 0.7), 1e-13);
  }
}

TEST_CASE("integration follows the arc that small Euler steps approach") {
  Draw draw(5);
  for (int i = 0; i < 200; ++i) {
    const Pose2D start = draw.pose(-50.0, 50.0);
    const Velocity velocity{draw(-1.0, 1.0), draw(-1.0, 1.0), draw(-3.0, 3.0)};
    const double seconds = draw(0.0, 2.0);
    constexpr int kSteps = 2000;
    Pose2D euler = start;
    for (int k = 0; k < kSteps; ++k) {
      const double h = seconds / kSteps;
      const double heading = euler.theta + 0.5 * velocity.omega * h;  // the midpoint rule: an error of h^2
      euler.x += h * (velocity.vx * std::cos(heading) - velocity.vy * std::sin(heading));
      euler.y += h * (velocity.vx * std::sin(heading) + velocity.vy * std::cos(heading));
      euler.theta += velocity.omega * h;
    }
    CAPTURE(i);
    check_near(integrate(start, velocity, seconds), euler, 1e-5);
  }
}

TEST_CASE("integration in parts is integration in one") {
  Draw draw(6);
  for (int i = 0; i < 5000; ++i) {
    CAPTURE(i);
    const Pose2D start = draw.pose(-50.0, 50.0);
    const double omega = i % 3 == 0 ? draw(-2e-4, 2e-4) : draw(-3.0, 3.0);  // both sides of where the series ends
    const Velocity velocity{draw(-1.0, 1.0), draw(-1.0, 1.0), omega};
    const double t1 = draw(0.0, 1.0);
    const double t2 = draw(0.0, 1.0);
    check_near(integrate(integrate(start, velocity, t1), velocity, t2), integrate(start, velocity, t1 + t2), 1e-11);
    check_near(integrate(integrate(start, velocity, t1), velocity, -t1), start, 1e-11);
  }
}

TEST_CASE("integration straight ahead, sideways, on the spot and once around") {
  check_near(integrate({1.0, 2.0, kPi / 2}, {0.5, 0.0, 0.0}, 2.0), {1.0, 3.0, kPi / 2}, 1e-15);
  check_near(integrate({1.0, 2.0, kPi / 2}, {0.0, 0.5, 0.0}, 2.0), {0.0, 2.0, kPi / 2}, 1e-15);
  check_near(integrate({1.0, 2.0, 0.0}, {0.0, 0.0, 0.5}, 2.0), {1.0, 2.0, 1.0}, 1e-15);
  check_near(integrate({1.0, 2.0, 0.3}, {1.0, 0.0, 2 * kPi}, 1.0), {1.0, 2.0, 0.3}, 1e-14);
}

TEST_CASE("the closest point of a segment is no further than any other of it") {
  Draw draw(7);
  for (int i = 0; i < 2000; ++i) {
    const Vec2 a = draw.point(-2.0, 2.0);
    const Vec2 b = i % 10 == 0 ? a : draw.point(-2.0, 2.0);
    const Vec2 p = draw.point(-2.0, 2.0);
    CAPTURE(i);
    for (int k = 0; k <= 100; ++k) CHECK(distance_to_segment(p, a, b) <= distance(p, a + 0.01 * k * (b - a)) + 1e-12);
    const Vec2 closest = closest_on_segment(p, a, b);
    CHECK(distance(a, closest) + distance(closest, b) == doctest::Approx(distance(a, b)));
  }
}

TEST_CASE("what is not finite is found") {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  CHECK(is_finite(Velocity{1.0, 2.0, 3.0}));
  CHECK(is_finite(Pose2D{1.0, 2.0, 3.0}));
  for (const double bad : {kNaN, kInfinity, -kInfinity}) {
    CHECK_FALSE(is_finite(Velocity{bad, 0.0, 0.0}));
    CHECK_FALSE(is_finite(Velocity{0.0, bad, 0.0}));
    CHECK_FALSE(is_finite(Velocity{0.0, 0.0, bad}));
    CHECK_FALSE(is_finite(Pose2D{bad, 0.0, 0.0}));
    CHECK_FALSE(is_finite(Pose2D{0.0, bad, 0.0}));
    CHECK_FALSE(is_finite(Pose2D{0.0, 0.0, bad}));
  }
}

}  // namespace
}  // namespace threewe
