// What a robot makes of its samples: which it uses, and where it takes something to stand.
#include "perception/perception.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <limits>
#include <span>
#include <vector>

using namespace threewe;
using namespace threewe::perception;

namespace {

// A standard robot with one ultrasonic sensor, inertial unit and wheels; with its lidar or without.
PerceptionModel robot(bool with_lidar) {
  PerceptionModel model{load_profile("3we_standard_v2"),
                        {{"ultrasonic_front", SensorType::ultrasonic, 10.0},
                         {"imu", SensorType::imu, 50.0},
                         {"odometry", SensorType::odometry, 50.0}}};
  if (!with_lidar) model.profile.lidar.reset();
  return model;
}

Sample echo(Time at, double range) { return {0, 0, at, at, RangeData{0.2618, 0.02, 4.0, range}}; }

// One period that brings a sample, to a robot that stands at `pose`.
void bring(Perception& perception, const PerceptionModel& model, const Sample& sample, const slam::PoseEstimate& pose,
           std::span<const Vec2> hits = {}) {
  REQUIRE(perception.examine(model, sample));
  const std::vector<const Sample*> samples = {&sample};
  perception.update(model, {sample.received, samples, pose, hits, {}});
}

// Whether one of the points stands within 5 cm of `range` ahead of the front sensor.
bool stands_ahead(const PerceptionModel& model, std::span<const Vec2> points, const Pose2D& odom_from_base,
                  double range) {
  const Pose2D sensor = odom_from_base * model.profile.base_from_sensor(SensorType::ultrasonic, model.sensors[0].name);
  return std::ranges::any_of(points, [&](Vec2 p) { return distance(p, sensor * Vec2{range, 0.0}) < 0.05; });
}

}  // namespace

TEST_CASE("without a lidar something stands where an echo came from, in odom, until the robot is connected anew") {
  const PerceptionModel model = robot(false);
  Perception perception(model);
  perception.begin(model, 0ns);
  slam::PoseEstimate pose;
  pose.odom_from_base = {2.0, 1.0, 0.7};
  pose.map_from_odom = {-3.0, 0.5, -0.4};
  CHECK(perception.obstacles(model, {}).empty());
  bring(perception, model, echo(100ms, 0.6), pose);
  CHECK(stands_ahead(model, perception.obstacles(model, {}), pose.odom_from_base, 0.6));
  CHECK(perception.sonar_grid().version() > 0);

  perception.begin(model, 200ms);
  CHECK(perception.obstacles(model, {}).empty());
  CHECK(perception.sonar_grid().version() > 0);  // the place is the same
}

TEST_CASE("beside a lidar an echo counts only where no beam has met anything") {
  const PerceptionModel model = robot(true);
  const Pose2D sensor = model.profile.base_from_sensor(SensorType::ultrasonic, model.sensors[0].name);
  const std::vector<Vec2> far = {sensor * Vec2{3.0, 0.0}};
  const std::vector<Vec2> near = {sensor * Vec2{0.7, 0.0}};
  for (const std::vector<Vec2>& hits : {far, near}) {
    Perception perception(model);
    perception.begin(model, 0ns);
    for (int i = 1; i <= 3; ++i) bring(perception, model, echo(100ms * i, 0.6), {}, hits);
    const auto found = perception.obstacles(model, hits);
    CHECK(stands_ahead(model, found, {}, 0.6) == (hits == far));
    CHECK(std::ranges::find(found, hits.front()) != found.end());  // what the lidar hits is never forgotten
  }
}

TEST_CASE("what no such sensor can measure is not used, and is a fault of that sensor alone") {
  const PerceptionModel model = robot(true);
  Perception perception(model);
  perception.begin(model, 0ns);
  Sample broken = echo(100ms, std::numeric_limits<double>::quiet_NaN());
  CHECK_FALSE(perception.examine(model, broken));
  CHECK(perception.examine(model, {1, 0, 100ms, 100ms, IMUData{{}, {0.0, 0.0, 9.81}}}));
  CHECK(perception.take_health_changes() == std::vector<std::size_t>{0});
  CHECK(perception.health().sensors()[0].fault == SensorFault::implausible);
  CHECK(perception.health().sensors()[1].ok());
}
