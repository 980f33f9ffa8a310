// Whether odometry, gyro and accelerometer tell the same story about a motion, in the right units and signs.
#include <cmath>

#include "backend/conformance_bench.hpp"
#include "core/exact.hpp"

namespace threewe::backend::conformance {

namespace {

Bench with(SensorType type, const Context& context, const char* otherwise) {
  Bench bench = context.connected();
  applies_if(bench.has(type), otherwise);
  return bench;
}

void odometry_starts_at_the_origin(const Context& context) {
  Bench bench = context.connected();
  bench.drive({}, 1s);
  const Pose2D pose = bench.odometry().pose;
  expect(norm(pose.position()) < 0.02 && std::abs(pose.theta) < 0.02,
         "a robot that has not moved is at ({:.3f}, {:.3f}, {:.3f}) by odometry", pose.x, pose.y, pose.theta);
}

void a_metre_driven_is_a_metre_in_odometry(const Context& context) {
  Bench bench = context.connected();
  bench.drive_and_stop({bench.cruise(), 0.0, 0.0}, from_seconds(1.0 / bench.cruise()));
  const Pose2D pose = bench.odometry().pose;
  expect(std::abs(pose.x - 1.0) < 0.1 && std::abs(pose.y) < 0.2,
         "driving forward by 1 m ended at ({:.3f}, {:.3f}) by odometry", pose.x, pose.y);
}

void odometry_turns_left(const Context& context) {
  Bench bench = context.connected();
  bench.drive_and_stop({0.0, 0.0, bench.turning()}, from_seconds(1.2 / bench.turning()));
  const double theta = bench.odometry().pose.theta;
  expect(std::abs(theta - 1.2) < 0.2, "turning left by 1.2 rad ended at {:.3f} rad by odometry", theta);
}

void heading_stays_within_pi(const Context& context) {
  Bench bench = context.connected();
  bench.drive_and_stop({0.0, 0.0, bench.turning()}, from_seconds(7.0 / bench.turning()));
  double highest = -10.0;
  for (const Sample& sample : bench.of(SensorType::odometry)) {
    const double theta = std::get<Odometry>(sample.data).pose.theta;
    expect(theta > -exact::kPi && theta <= exact::kPi, "a heading of {} rad is outside (-pi, pi]", theta);
    highest = std::max(highest, theta);
  }
  expect(highest > 2.5, "turning left by 7 rad never came near a heading of pi");
}

void odometry_velocity_is_in_the_body_frame(const Context& context) {
  Bench bench = context.connected();
  bench.drive_and_stop({0.0, 0.0, bench.turning()}, from_seconds(1.5 / bench.turning()));
  bench.drive({bench.cruise(), 0.0, 0.0}, 1s);
  bench.forget();
  bench.drive({bench.cruise(), 0.0, 0.0}, 500ms);
  Vec2 sum;
  const std::vector<Sample> odometry = bench.of(SensorType::odometry);
  expect(!odometry.empty(), "no odometry arrived within 0.5 s");
  for (const Sample& sample : odometry) {
    const Velocity& v = std::get<Odometry>(sample.data).velocity;
    sum = sum + Vec2{v.vx, v.vy};
  }
  const Vec2 mean = (1.0 / static_cast<double>(odometry.size())) * sum;
  expect(std::abs(mean.x - bench.cruise()) < 0.2 * bench.cruise() && std::abs(mean.y) < 0.2 * bench.cruise(),
         "driving forward at {:.2f} m/s after a left turn is ({:.3f}, {:.3f}) m/s by odometry", bench.cruise(), mean.x,
         mean.y);
}

void odometry_velocity_fits_its_pose(const Context& context) {
  Bench bench = context.connected();
  bench.drive({}, 100ms);
  bench.forget();
  bench.drive_and_stop({bench.cruise(), 0.0, 0.5 * bench.turning()}, 2s);
  const std::vector<Sample> odometry = bench.of(SensorType::odometry);
  expect(odometry.size() >= 2, "{} odometry samples within 3 s", odometry.size());
  double path = 0.0;
  double integral = 0.0;
  for (std::size_t i = 1; i < odometry.size(); ++i) {
    const auto& last = std::get<Odometry>(odometry[i - 1].data);
    const auto& next = std::get<Odometry>(odometry[i].data);
    path += distance(last.pose.position(), next.pose.position());
    integral +=
        norm({next.velocity.vx, next.velocity.vy}) * to_seconds(odometry[i].measured - odometry[i - 1].measured);
  }
  expect(std::abs(integral - path) < 0.1 * path + 0.02, "poses moved by {:.3f} m, velocities add up to {:.3f} m", path,
         integral);
}

/// Odometry that turns left and then drives forward must go where it heads: a flipped y shows on no straight drive.
void odometry_drives_where_it_heads(const Context& context) {
  Bench bench = context.connected();
  bench.drive_and_stop({0.0, 0.0, bench.turning()}, from_seconds(1.0 / bench.turning()));
  const Pose2D before = bench.odometry().pose;
  bench.drive_and_stop({bench.cruise(), 0.0, 0.0}, from_seconds(0.5 / bench.cruise()));
  const Vec2 driven = bench.odometry().pose.position() - before.position();
  expect(norm(driven) > 0.25, "driving forward by 0.5 m moved odometry by {:.3f} m", norm(driven));
  const double course = exact::atan2(driven.y, driven.x);
  expect(std::abs(wrap_angle(course - before.theta)) < 0.3,
         "odometry heads {:.2f} rad, but driving forward moved it along {:.2f} rad{}", before.theta, course,
         std::abs(wrap_angle(course + before.theta)) < 0.3 ? ": y, or the heading, has the wrong sign" : "");
}

void sideways_is_left(const Context& context) {
  Bench bench = context.connected();
  applies_if(bench.features().kinematics == Kinematics::holonomic, "the base cannot drive sideways");
  bench.drive_and_stop({0.0, bench.cruise(), 0.0}, from_seconds(0.5 / bench.cruise()));
  const Pose2D pose = bench.odometry().pose;
  expect(std::abs(pose.y - 0.5) < 0.15 && std::abs(pose.x) < 0.15,
         "driving left by 0.5 m ended at ({:.3f}, {:.3f}) by odometry", pose.x, pose.y);
}

void gyro_agrees_with_odometry(const Context& context) {
  Bench bench = with(SensorType::imu, context, "the robot has no IMU");
  bench.drive({}, 200ms);
  const double start = bench.odometry().pose.theta;
  bench.forget();
  bench.drive_and_stop({0.0, 0.0, bench.turning()}, from_seconds(1.2 / bench.turning()));
  const double turned = wrap_angle(bench.odometry().pose.theta - start);
  const std::vector<Sample> imu = bench.of(SensorType::imu);
  double integral = 0.0;
  for (std::size_t i = 1; i < imu.size(); ++i) {
    integral += std::get<IMUData>(imu[i].data).angular_velocity[2] * to_seconds(imu[i].measured - imu[i - 1].measured);
  }
  expect(std::abs(integral - turned) < 0.2, "a left turn of {:.3f} rad by odometry is {:.3f} rad by the gyro", turned,
         integral);
}

void imu_at_rest_measures_gravity_alone(const Context& context) {
  Bench bench = with(SensorType::imu, context, "the robot has no IMU");
  bench.drive({}, 2s);
  const std::vector<Sample> imu = bench.of(SensorType::imu);
  expect(!imu.empty(), "no IMU reading arrived within 2 s");
  std::array<double, 3> gyro{};
  std::array<double, 3> acceleration{};
  for (const Sample& sample : imu) {
    const auto& reading = std::get<IMUData>(sample.data);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      gyro[axis] += reading.angular_velocity[axis] / static_cast<double>(imu.size());
      acceleration[axis] += reading.linear_acceleration[axis] / static_cast<double>(imu.size());
    }
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const char name = "xyz"[axis];
    expect(std::abs(gyro[axis]) < 0.05, "at rest the gyro shows {:.3f} rad/s about {}", gyro[axis], name);
    expect(std::abs(acceleration[axis] - (axis == 2 ? 9.81 : 0.0)) < 0.5,
           "at rest the accelerometer shows {:.2f} m/s^2 along {}", acceleration[axis], name);
  }
}

void battery_is_a_fraction_and_never_rises(const Context& context) {
  Bench bench = with(SensorType::battery, context, "the robot has no battery");
  bench.drive({0.0, 0.0, bench.turning()}, 5s);
  double last = 1.0;
  for (const Sample& sample : bench.of(SensorType::battery)) {
    const auto& battery = std::get<BatteryState>(sample.data);
    expect(battery.charge >= 0.0 && battery.charge <= 1.0, "a charge of {}, outside 0 to 1", battery.charge);
    expect(battery.charge <= last, "the charge rose from {} to {}", last, battery.charge);
    expect(std::isfinite(battery.voltage) && battery.voltage > 0.0, "a voltage of {} V", battery.voltage);
    last = battery.charge;
  }
}

constexpr Check kMotionChecks[] = {
    {"odometry_starts_at_the_origin", odometry_starts_at_the_origin},
    {"a_metre_driven_is_a_metre_in_odometry", a_metre_driven_is_a_metre_in_odometry},
    {"odometry_turns_left", odometry_turns_left},
    {"heading_stays_within_pi", heading_stays_within_pi},
    {"odometry_velocity_is_in_the_body_frame", odometry_velocity_is_in_the_body_frame},
    {"odometry_velocity_fits_its_pose", odometry_velocity_fits_its_pose},
    {"odometry_drives_where_it_heads", odometry_drives_where_it_heads},
    {"sideways_is_left", sideways_is_left},
    {"gyro_agrees_with_odometry", gyro_agrees_with_odometry},
    {"imu_at_rest_measures_gravity_alone", imu_at_rest_measures_gravity_alone},
    {"battery_is_a_fraction_and_never_rises", battery_is_a_fraction_and_never_rises},
};

}  // namespace

std::span<const Check> motion_checks() { return kMotionChecks; }

}  // namespace threewe::backend::conformance
