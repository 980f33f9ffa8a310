// Wheels and gyro against exact motion, and the filter against the textbook.
#include "slam/dead_reckoning.hpp"

#include <doctest/doctest.h>

#include <Eigen/LU>
#include <cmath>

#include "draw.hpp"
#include "slam/pose_filter.hpp"

namespace threewe::slam {
namespace {

TEST_CASE("calibrated dead reckoning follows any drive exactly, in between samples too") {
  for (std::uint64_t seed = 0; seed < cases(500); ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    const Calibration calibration{draw(-0.01, 0.01), draw(0.98, 1.02), draw(0.85, 1.0)};
    DeadReckoning track(calibration);
    Pose2D truth;
    Odometry wheels;
    Velocity v;
    track.add_gyro(0ms, calibration.gyro_bias);
    track.add_odometry(0ms, wheels);
    Time t{};
    for (int i = 0; i < 60; ++i) {
      if (i % 10 == 0) v = {draw(-0.5, 0.5), draw(-0.3, 0.3), draw(-1, 1)};
      const Pose2D before = truth;
      for (int j = 0; j < 2; ++j) {
        t += 10ms;
        truth = integrate(truth, v, 0.01);
        track.add_gyro(t, v.omega + calibration.gyro_bias);
      }
      const Velocity measured{v.vx / calibration.forward_scale, v.vy / calibration.lateral_scale, v.omega};
      wheels = {integrate(wheels.pose, measured, 0.02), measured};
      track.add_odometry(t, wheels);
      const Pose2D now = track.at(t);
      REQUIRE(distance(now.position(), truth.position()) < 1e-5 * (i + 1));
      REQUIRE(std::fabs(wrap_angle(now.theta - truth.theta)) < 1e-9);
      const Pose2D middle = track.at(t - 10ms);
      REQUIRE(distance(middle.position(), interpolate(before, truth, 0.5).position()) < 1e-4);
      const Pose2D ahead = track.at(t + 20ms);
      REQUIRE(distance(ahead.position(), integrate(truth, v, 0.02).position()) < 1e-4);
    }
  }
}

TEST_CASE("odom never jumps when the calibration changes") {
  DeadReckoning track({});
  Odometry wheels;
  for (int i = 0; i < 20; ++i) {
    track.add_gyro(i * 20ms, 0.5);
    wheels.pose = integrate(wheels.pose, {0.3, 0.0, 0.5}, i == 0 ? 0.0 : 0.02);
    track.add_odometry(i * 20ms, wheels);
  }
  const Pose2D before = track.at(380ms);
  track.calibrate({0.2, 1.1, 1.0, 0.02});
  CHECK(track.at(380ms) == before);
}

TEST_CASE("what a gyro measured stays what it was, whatever bias was subtracted meanwhile") {
  // a scan arrives late: what was integrated before it did, had the old bias
  DeadReckoning track({});
  for (int i = 0; i <= 30; ++i) {
    if (i == 14) track.calibrate({.gyro_bias = 0.025});
    track.add_gyro(i * 10ms, 0.03);
    if (i % 2 == 0) track.add_odometry(i * 10ms, {});
  }
  const MotionSummary motion = track.between(100ms, 300ms);
  CHECK(motion.measured / motion.seconds == doctest::Approx(0.03));
  CHECK(motion.at_rest);
}

TEST_CASE("without a gyro the wheels tell the heading") {
  DeadReckoning track({});
  Odometry wheels;
  for (int i = 0; i < 50; ++i) {
    track.add_odometry(i * 20ms, wheels);
    wheels.pose = integrate(wheels.pose, {0.3, 0.0, 0.8}, 0.02);
  }
  CHECK(track.at(980ms).theta == doctest::Approx(0.8 * 0.98));
}

TEST_CASE(
    "after a silence odom goes on as it was guessed where scans have followed, and as wheels say where none have") {
  for (const bool scans_follow : {false, true}) {
    CAPTURE(scans_follow);
    DeadReckoning track({}, scans_follow);
    const Velocity v{0.4, 0.0, 0.5};
    Odometry wheels{{}, v};
    track.add_odometry(0ms, wheels);
    wheels.pose = integrate({}, v, 0.02);
    track.add_odometry(20ms, wheels);
    const Pose2D guessed = track.at(2000ms);
    CHECK(distance(guessed.position(), integrate({}, v, 0.32).position()) < 1e-9);  // no farther than it may be
    wheels = {integrate({}, v, 0.1), {}};                                           // it has stopped much earlier
    track.add_odometry(2000ms, wheels);
    const Pose2D expected = scans_follow ? guessed : wheels.pose;
    CHECK(distance(track.at(2000ms).position(), expected.position()) < 1e-6);
    CHECK(track.at(2000ms).theta == doctest::Approx(expected.theta));
    wheels.pose = integrate(wheels.pose, v, 0.02);
    track.add_odometry(2020ms, wheels);
    CHECK(distance(track.at(2020ms).position(), integrate(expected, v, 0.02).position()) < 1e-5);
  }
}

TEST_CASE("conditioning on pose and bias is the Kalman update with the information that a scan brought") {
  for (std::uint64_t seed = 0; seed < cases(300); ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    SensorModel sensors;
    sensors.lateral_scale_sigma = 0.03;
    PoseFilter filter(sensors);
    for (int i = 0; i < 20; ++i) {
      filter.predict(draw(-3, 3), {draw(0, 0.02), draw(-0.01, 0.01)}, draw(-0.02, 0.02), 0.02, true);
    }
    const Matrix7 prior = filter.covariance();

    // a measurement z = H x of the first four with information H^T H
    Matrix4 root;
    for (int i = 0; i < 16; ++i) root(i / 4, i % 4) = draw(-50, 50);
    const Matrix4 scan = root.transpose() * root;
    const Matrix4 posterior = (scan + filter.scan_covariance().inverse()).inverse();
    Vector4 measured;
    for (int i = 0; i < 4; ++i) measured(i) = draw(-0.01, 0.01);
    const Vector4 shift = posterior * scan * measured;

    // the textbook: K = P H^T (H P H^T + I)^-1 with H = [root 0]
    Eigen::Matrix<double, 4, 7> h = Eigen::Matrix<double, 4, 7>::Zero();
    h.leftCols<4>() = root;
    const Matrix4 innovation = h * prior * h.transpose() + Matrix4::Identity();
    const Eigen::Matrix<double, 7, 4> gain = prior * h.transpose() * innovation.inverse();
    const Vector7 expected = gain * root * measured;
    const Matrix7 expected_covariance = prior - gain * h * prior;

    const Vector7 all = filter.condition(shift, posterior);
    const double scale = expected.cwiseAbs().maxCoeff();
    CHECK((all - expected).cwiseAbs().maxCoeff() < 1e-6 * scale);
    CHECK((filter.covariance() - expected_covariance).cwiseAbs().maxCoeff() < 1e-6 * prior.cwiseAbs().maxCoeff());
  }
}

}  // namespace
}  // namespace threewe::slam
