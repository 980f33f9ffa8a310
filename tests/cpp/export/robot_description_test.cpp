// What is exported of a robot is what its profile says.
#include "export/robot_description.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "core/rng.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::exports {
namespace {

using doctest::Approx;

double inertia_about_base(const RobotDescription& robot) {
  const auto [mass, center, moments] = total_inertia(robot);
  return moments.z + mass * (center.x * center.x + center.y * center.y);
}

TEST_CASE("mass and inertia of every robot are its profile's, with rollers and without") {
  for (const std::string& name : profile_names()) {
    CAPTURE(name);
    const RobotProfile profile = load_profile(name);
    const RobotDescription rolling = describe(profile);
    for (const RobotDescription& robot : {rolling, without_rollers(rolling)}) {
      CHECK(total_inertia(robot).mass == Approx(profile.body.mass).epsilon(1e-14));
      CHECK(inertia_about_base(robot) == Approx(profile.body.inertia).epsilon(1e-13));
      for (const Link& link : robot.links) {
        CAPTURE(link.name);
        const auto& [x, y, z] = link.inertia.moments;
        CHECK(link.inertia.mass > 0);
        CHECK(std::min({x, y, z}) > 0);
        CHECK(x <= (y + z) * (1 + 1e-12));  // what engines demand of a rigid body
        CHECK(y <= (x + z) * (1 + 1e-12));
        CHECK(z <= (x + y) * (1 + 1e-12));
      }
    }
    const Inertia a = total_inertia(rolling);
    const Inertia b = total_inertia(without_rollers(rolling));
    CHECK(a.moments.x == Approx(b.moments.x).epsilon(1e-12));
    CHECK(a.moments.y == Approx(b.moments.y).epsilon(1e-12));
  }
}

TEST_CASE("a robot stands within its wheels and casters") {
  for (const std::string& name : profile_names()) {
    CAPTURE(name);
    const RobotDescription robot = describe(load_profile(name));
    std::vector<Vec2> feet;
    for (const Joint& joint : robot.joints) {
      if (joint.kind == Joint::Kind::wheel) {
        feet.push_back({joint.parent_from_child.position.x, joint.parent_from_child.position.y});
      }
    }
    for (const Caster& caster : robot.profile.body.casters) feet.push_back(caster.position);
    const Vec3 center = total_inertia(robot).center;
    const auto [low, high] = std::ranges::minmax(feet, {}, &Vec2::x);
    CHECK(low.x < center.x);
    CHECK(center.x < high.x);
    CHECK(center.y == Approx(0.0).epsilon(1e-12));
  }
}

// How far a wheel of rollers reaches from its axle at an angle, by the support function of each ellipsoid.
double reach(const RobotDescription& robot, const std::string& wheel, double angle) {
  double farthest = 0.0;
  const Vec3 outwards{std::sin(angle), 0.0, -std::cos(angle)};
  for (std::size_t i = 0; i < robot.joints.size(); ++i) {
    const Joint& joint = robot.joints[i];
    if (joint.parent != wheel) continue;
    const auto& [a, b, c] = robot.links[i + 1].shapes.front().size;
    const auto& [position, rotation] = joint.parent_from_child;
    const auto along = [&](const Vec3& v) { return v.x * outwards.x + v.y * outwards.y + v.z * outwards.z; };
    const double x = a * along(rotated(rotation, {1, 0, 0}));
    const double y = b * along(rotated(rotation, {0, 1, 0}));
    const double z = c * along(rotated(rotation, {0, 0, 1}));
    farthest = std::max(farthest, along(position) + std::sqrt(x * x + y * y + z * z));
  }
  return farthest;
}

TEST_CASE("rollers make a wheel round and as wide as the profile says") {
  const RobotProfile profile = load_profile("3we_standard_v2");
  const RobotDescription robot = describe(profile);
  const WheelGeometry& wheels = profile.body.wheels;
  CHECK(robot.links.size() == 1 + 4 + 4 * static_cast<std::size_t>(wheels.rollers));
  for (int i = 0; i < 720; ++i) {
    const double angle = i * M_PI / 360;
    const double r = reach(robot, "front_left_wheel", angle);
    CHECK(r <= wheels.radius * (1 + 1e-12));
    CHECK(r >= wheels.radius * 0.994);  // 0.2 mm where one roller hands over to the next
  }
  CHECK(reach(robot, "rear_right_wheel", 0.0) == Approx(wheels.radius).epsilon(1e-14));
  const auto& [a, b, c] = robot.links[5].shapes.front().size;
  CHECK(2 * std::sqrt((a * a) / 2) == Approx(wheels.width));  // of the axle, at 45 degrees
}

TEST_CASE("lowest rollers hold in the directions that the kinematics assume") {
  const WheelGeometry& wheels = load_profile("3we_standard_v2").body.wheels;
  Vec2 places[] = {{wheels.half_length, wheels.half_width},
                   {wheels.half_length, -wheels.half_width},
                   {-wheels.half_length, wheels.half_width},
                   {-wheels.half_length, -wheels.half_width}};
  for (std::uint32_t i = 0; i < 1000; ++i) {
    CAPTURE(i);
    const RngKey key{.seed = 7, .stream = Stream::scene};
    const Velocity v{normal(key, i, 0), normal(key, i, 1), normal(key, i, 2)};
    const WheelSpeeds speeds = wheel_speeds(wheels, v);
    for (std::size_t wheel = 0; wheel < 4; ++wheel) {
      // the point of the roller on the floor does not move along its axle
      const Vec2 p = places[wheel];
      const Vec2 moved{v.vx - v.omega * p.y - wheels.radius * speeds[wheel], v.vy + v.omega * p.x};
      const Vec3 friction = friction_direction(wheel);
      CHECK(friction.x * moved.x + friction.y * moved.y == Approx(0.0).epsilon(1e-12));
    }
  }
}

TEST_CASE("sensors are where the profile mounts them") {
  const RobotProfile profile = load_profile("3we_depth_v2");
  const RobotDescription robot = describe(profile);
  REQUIRE(robot.sensors.size() == 3 + profile.ultrasonics->mounts.size());
  for (const SensorMount& mount : robot.sensors) {
    CAPTURE(mount.name);
    const Pose2D expected = profile.base_from_sensor(mount.type, mount.name);
    CHECK(mount.base_from_sensor.position.x == expected.x);
    CHECK(mount.base_from_sensor.position.y == expected.y);
    CHECK(roll_pitch_yaw(mount.base_from_sensor.rotation).z == Approx(expected.theta).epsilon(1e-14));
  }
  CHECK(robot.sensors.front().base_from_sensor.position.z == profile.lidar->height);
}

TEST_CASE("wheels that leave the base no inertia are refused") {
  RobotProfile profile = load_profile("3we_standard_v2");
  profile.body.inertia = 0.003;
  CHECK_THROWS_AS(describe(profile), ConfigError);
}

TEST_CASE("angles of URDF and SDF turn as the quaternion does") {
  for (std::uint32_t i = 0; i < 1000; ++i) {
    CAPTURE(i);
    const RngKey key{.seed = 11, .stream = Stream::scene};
    const Quaternion q = about_z(normal(key, i, 0)) * about_y(0.5 * normal(key, i, 1)) * about_x(normal(key, i, 2));
    const auto [roll, pitch, yaw] = roll_pitch_yaw(q);
    const Quaternion back = about_z(yaw) * about_y(pitch) * about_x(roll);
    const Vec3 v{0.3, -0.5, 0.8};
    const Vec3 off = rotated(q, v) - rotated(back, v);
    CHECK(std::abs(off.x) + std::abs(off.y) + std::abs(off.z) < 1e-12);
  }
}

}  // namespace
}  // namespace threewe::exports
