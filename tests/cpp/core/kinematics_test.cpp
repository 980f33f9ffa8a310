#include "threewe/core/kinematics.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <random>

namespace threewe {
namespace {

constexpr WheelGeometry kMecanum{Kinematics::holonomic, 0.0325, 0.09, 0.1};
constexpr WheelGeometry kTwoWheels{Kinematics::differential, 0.033, 0.0, 0.08};

void check_near(const Velocity& a, const Velocity& b) {
  CHECK(std::fabs(a.vx - b.vx) < 1e-13);
  CHECK(std::fabs(a.vy - b.vy) < 1e-13);
  CHECK(std::fabs(a.omega - b.omega) < 1e-13);
}

TEST_CASE("body to wheels and back") {
  std::mt19937_64 bits(1);
  std::uniform_real_distribution<double> draw(-2.0, 2.0);
  for (int i = 0; i < 5000; ++i) {
    CAPTURE(i);
    const Velocity v{draw(bits), draw(bits), draw(bits)};
    check_near(body_velocity(kMecanum, wheel_speeds(kMecanum, v)), v);
    check_near(body_velocity(kTwoWheels, wheel_speeds(kTwoWheels, v)), {v.vx, 0.0, v.omega});
  }
}

TEST_CASE("wheels turn as one sees them turn") {
  const auto forward = wheel_speeds(kMecanum, {0.325, 0.0, 0.0});
  for (const double speed : forward) CHECK(speed == doctest::Approx(10.0));

  const auto [front_left, front_right, rear_left, rear_right] = wheel_speeds(kMecanum, {0.0, 0.325, 0.0});
  CHECK(front_left == doctest::Approx(-10.0));
  CHECK(front_right == doctest::Approx(10.0));
  CHECK(rear_left == doctest::Approx(10.0));
  CHECK(rear_right == doctest::Approx(-10.0));

  const auto turning = wheel_speeds(kTwoWheels, {0.0, 0.0, 1.0});
  CHECK(turning[0] < 0.0);  // counter-clockwise: the left wheel backward
  CHECK(turning[1] == -turning[0]);
  CHECK(turning[2] == 0.0);
  CHECK(turning[3] == 0.0);
}

TEST_CASE("a holonomic body velocity is the least-squares fit of its wheels") {
  std::mt19937_64 bits(2);
  std::uniform_real_distribution<double> draw(-10.0, 10.0);
  const auto residual = [](const Velocity& v, const WheelSpeeds& speeds) {
    const WheelSpeeds fit = wheel_speeds(kMecanum, v);
    double sum = 0.0;
    for (std::size_t i = 0; i < 4; ++i) sum += (fit[i] - speeds[i]) * (fit[i] - speeds[i]);
    return sum;
  };
  for (int i = 0; i < 1000; ++i) {
    CAPTURE(i);
    const WheelSpeeds speeds{draw(bits), draw(bits), draw(bits), draw(bits)};
    const Velocity best = body_velocity(kMecanum, speeds);
    const double least = residual(best, speeds);
    for (const double step : {-1e-3, 1e-3}) {
      CHECK(residual({best.vx + step, best.vy, best.omega}, speeds) > least);
      CHECK(residual({best.vx, best.vy + step, best.omega}, speeds) > least);
      CHECK(residual({best.vx, best.vy, best.omega + step}, speeds) > least);
    }
  }
}

}  // namespace
}  // namespace threewe
