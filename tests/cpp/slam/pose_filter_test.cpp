// Kalman filter of poses and calibration, beside the textbook's update.
#include "slam/pose_filter.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <optional>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "draw.hpp"

namespace threewe::slam {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// A robot that has driven somewhere and turned, so that everything is correlated with everything.
PoseFilter driven(Draw& draw) {
  SensorModel sensors;
  sensors.lateral_scale_sigma = 0.03;
  PoseFilter filter(sensors);
  filter.widen(0.02, 0.01);
  for (int i = 0; i < 20; ++i)
    filter.predict(draw(-3, 3), {draw(0.0, 0.1), draw(-0.05, 0.05)}, draw(-0.1, 0.1), 0.1, true);
  return filter;
}

TEST_CASE("a scan updates everything as a Kalman filter does, and leaves alone what it is not to tell") {
  for (std::uint64_t seed = 0; seed < cases(2000); ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    const double angle = draw(-3, 3);
    const Vec2 along{std::cos(angle), std::sin(angle)};
    const bool blind = seed % 2 == 0;  // along this direction
    Matrix4 beams = Matrix4::NullaryExpr([&] { return draw(-30, 30); });
    if (blind) {
      const Vector4 direction(along.x, along.y, 0.0, 0.0);
      beams = (beams * (Matrix4::Identity() - direction * direction.transpose())).eval();
    }
    PoseFilter filter = driven(draw);
    const MatrixXd before = filter.covariance();

    // Joseph's form holds for any gain
    MatrixXd h = MatrixXd::Zero(4, 7);
    h.leftCols<4>() = beams;
    const MatrixXd s = h * before * h.transpose() + MatrixXd::Identity(4, 4);
    MatrixXd gain = before * h.transpose() * s.inverse();
    const VectorXd measured = VectorXd::NullaryExpr(4, [&] { return draw(-2, 2); });
    const Vector4 shift = (gain * measured).head<4>();
    if (blind) {
      VectorXd direction = VectorXd::Zero(7);
      direction.head<2>() << along.x, along.y;
      gain -= (direction * (direction.transpose() * gain)).eval();
      gain.row(kForwardScale).setZero();
      gain.row(kLateralScale).setZero();
    }
    const MatrixXd left = MatrixXd::Identity(7, 7) - gain * h;
    const MatrixXd after = left * before * left.transpose() + gain * gain.transpose();

    const Matrix4 posterior = (filter.scan_covariance().inverse() + beams.transpose() * beams).inverse();
    const Vector7 shifts = filter.condition(shift, posterior, blind ? std::optional(along) : std::nullopt);
    CHECK((shifts - gain * measured).norm() < 1e-6 * (1.0 + measured.norm()));
    CHECK((filter.covariance() - after).norm() < 1e-6 * before.norm());
    const Eigen::SelfAdjointEigenSolver<Matrix7> values(filter.covariance());
    CHECK(values.eigenvalues()(0) > -1e-12);
    if (blind)
      CHECK(filter.covariance()(kForwardScale, kForwardScale) == doctest::Approx(before(kForwardScale, kForwardScale)));
  }
}

}  // namespace
}  // namespace threewe::slam
