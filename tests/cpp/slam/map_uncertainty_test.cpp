// How far off the map is said to be, where the robot is.
#include "slam/map_uncertainty.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include <Eigen/Eigenvalues>

#include "draw.hpp"

namespace threewe::slam {
namespace {

/// A scan that tells the pose to 2 mm and 1 mrad.
View view(double unknown, double scatter = 0.01) { return {unknown, scatter, Vector3(2.5e5, 2.5e5, 1e6).asDiagonal()}; }

/// Along a line, a scan every 10 cm.
double trace_after(MapUncertainty& error, double from, double to, double unknown, double scatter = 0.01) {
  const double step = to > from ? 0.1 : -0.1;
  const int steps = static_cast<int>(std::ceil((to - from) / step));
  for (int i = 0; i < steps; ++i) error.update({from + step * i, 0.0}, view(unknown, scatter));
  return error.covariance().trace();
}

TEST_CASE("new places are less certain, and a place is as certain as it was when the robot comes back") {
  MapUncertainty error;
  error.update({}, view(0.0));
  std::vector<double> there{error.covariance().trace()};
  for (int metre = 1; metre <= 20; ++metre) there.push_back(trace_after(error, metre - 1, metre, 0.3));
  for (std::size_t i = 1; i < there.size(); ++i) CHECK(there[i] > there[i - 1]);
  for (int metre = 15; metre >= 0; --metre) {
    CAPTURE(metre);
    const double back = trace_after(error, metre == 15 ? 20 : metre + 1, metre, 0.0);
    CHECK(back < 1.3 * there[static_cast<std::size_t>(metre + 2)]);
    CHECK(back > 0.4 * there[static_cast<std::size_t>(metre)]);
  }
}

TEST_CASE("to and fro in a known place nothing grows, for however long") {
  MapUncertainty error;
  trace_after(error, 0.0, 8.0, 0.3);
  const double first = trace_after(error, 8.0, 0.0, 0.0);
  for (int lap = 0; lap < 100; ++lap) {
    trace_after(error, 0.0, 8.0, 0.0);
    CHECK(trace_after(error, 8.0, 0.0, 0.0) <= first + 1e-12);
  }
}

TEST_CASE("a turned map is off to the side, seen from where it was turned") {
  MapUncertainty error;
  error.update({}, view(0.0));
  trace_after(error, 0.0, 10.0, 0.3);
  const Matrix3 covariance = error.covariance();
  CHECK(covariance(kY, kY) > 2.0 * covariance(kX, kX));
  CHECK(covariance(kY, kTheta) > 0.0);
}

TEST_CASE("far from where it began the map may be stretched") {
  const auto along = [](double x) {
    MapUncertainty error;
    error.update({1.0, 0.0}, view(0.0));
    for (int i = 1; i <= 10; ++i) error.update({1.0 + 0.1 * i * (x - 1.0), 0.0}, view(0.0));
    return error.covariance();
  };
  const Matrix3 grown = along(21.0) - along(1.0);
  CHECK(std::sqrt(grown(kX, kX)) == doctest::Approx(20.0 * 0.0005).epsilon(0.01));
}

TEST_CASE("a lidar that scatters less than usual draws better maps; that one scatters more its information says") {
  const auto drawn = [](double scatter) {
    MapUncertainty error;
    return trace_after(error, 0.0, 10.0, 0.3, scatter);
  };
  CHECK(drawn(0.006) < 0.4 * drawn(0.0115));
  CHECK(drawn(0.04) > drawn(0.0115));
  CHECK(drawn(0.04) < 1.1 * drawn(0.0115));
}

TEST_CASE("along a corridor whose walls do not tell the way the map is worse that way") {
  MapUncertainty error;
  const View along{0.3, 0.01, Vector3(1e3, 2.5e5, 1e6).asDiagonal()};
  for (int i = 0; i < 20; ++i) error.update({0.1 * i, 0.0}, along);
  CHECK(error.covariance()(kX, kX) > 5.0 * error.covariance()(kY, kY));
}

TEST_CASE("whoever was put elsewhere is as certain as the place is") {
  MapUncertainty error;
  error.update({}, view(0.0));
  const double at_start = error.covariance().trace();
  trace_after(error, 0.0, 20.0, 0.3);
  error.forget_way();
  error.update({0.1, 0.0}, view(0.0));
  CHECK(error.covariance().trace() < 1.1 * at_start);
  error.forget_way();
  error.update({19.0, 0.0}, view(0.0));
  CHECK(error.covariance().trace() > 2.0 * at_start);
}

TEST_CASE("it is a covariance wherever the robot goes, and a copy goes on the same") {
  for (std::uint64_t seed = 0; seed < cases(200); ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    MapUncertainty error;
    Vec2 at;
    for (int i = 0; i < 300; ++i) {
      at = at + draw.point(-0.5, 0.5);
      if (draw.whole(0, 60) == 0) error.forget_way();
      View seen{draw(0.0, 1.0), draw(0.0, 0.05), Matrix3::Zero()};
      for (int beam = draw.whole(0, 20); beam > 0; --beam) {  // with one it tells nothing but how far it is to one wall
        const Vector3 tells(draw(-1.0, 1.0), draw(-1.0, 1.0), draw(-5.0, 5.0));
        seen.information += 1600.0 * tells * tells.transpose();
      }
      MapUncertainty copy = error;
      error.update(at, seen);
      copy.update(at, seen);
      REQUIRE(copy.covariance() == error.covariance());
      const Eigen::SelfAdjointEigenSolver<Matrix3> eigen(error.covariance());
      REQUIRE(eigen.eigenvalues().minCoeff() > 0.0);
    }
  }
}

}  // namespace
}  // namespace threewe::slam
