#include "threewe/hardware/profile.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "threewe/core/assets.hpp"
#include "threewe/core/errors.hpp"

using namespace threewe;

namespace {

std::string text_of(std::string_view profile) {
  std::ifstream stream(find_asset("robots", profile));
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

// The standard profile with the first `from` replaced by `to`, and the line on which that was.
struct Broken {
  std::string file;
  int line = 0;
};

Broken break_profile(const std::string& from, const std::string& to) {
  std::string text = text_of("3we_standard_v2");
  const std::size_t at = text.find(from);
  REQUIRE_MESSAGE(at != std::string::npos, from);
  text.replace(at, from.size(), to);
  const auto file = std::filesystem::temp_directory_path() / "threewe_profile_test.yaml";
  std::ofstream(file) << text;
  return {file.string(), 1 + static_cast<int>(std::count(text.begin(), text.begin() + static_cast<long>(at), '\n'))};
}

std::string error_of(const std::string& file) {
  try {
    load_profile(file);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("the standard robot is the one that is sold") {
  const RobotProfile robot = load_profile("3we_standard_v2");
  CHECK(robot.name == "3we_standard_v2");
  CHECK(robot.kinematics() == Kinematics::holonomic);
  CHECK(robot.body.footprint == Footprint::rectangle(0.25, 0.22));
  CHECK(robot.body.mass == 2.5);
  CHECK(robot.body.wheels.radius == 0.0325);
  CHECK(robot.body.wheels.rollers == 9);
  CHECK(robot.body.casters.empty());
  CHECK(robot.hardware_limits.linear == 1.2);
  CHECK(robot.hardware_limits.angular == 3.0);
  CHECK(robot.operating_limits.linear == 0.5);
  CHECK(robot.operating_limits.angular == 1.0);
  CHECK(robot.command_latency == 40ms);
  REQUIRE(robot.lidar);
  CHECK(robot.lidar->points_per_turn == 450);
  CHECK(robot.lidar->turn == 100ms);
  CHECK(robot.lidar->beams == 360);
  CHECK(robot.lidar->clockwise);
  CHECK(robot.lidar->rolling);
  CHECK(robot.imu);
  REQUIRE(robot.ultrasonics);
  CHECK(robot.ultrasonics->mounts.size() == 4);
  CHECK(robot.ultrasonics->interval == 60ms);
  CHECK(robot.ultrasonics->period() == 240ms);
  CHECK(robot.ultrasonics->field_of_view == doctest::Approx(15.0 * M_PI / 180.0).epsilon(1e-4));
  CHECK(robot.ultrasonics->max_incidence == doctest::Approx(25.0 * M_PI / 180.0).epsilon(1e-4));
  CHECK(robot.odometry.period == 20ms);
  REQUIRE(robot.battery);
  CHECK(robot.battery->capacity / robot.battery->idle_power > 2.0);
}

TEST_CASE("cameras: a rectified pinhole view on every robot of ours, depth on one") {
  for (const char* name : {"3we_standard_v2", "3we_base_v2", "3we_depth_v2"}) {
    CAPTURE(name);
    const RobotProfile robot = load_profile(name);
    REQUIRE(robot.camera);
    CHECK(robot.camera->width == 640);
    CHECK(robot.camera->height == 480);
    CHECK(robot.camera->sigma == 3.0);
    CHECK(robot.camera->latency == 80ms);
    CHECK(to_seconds(robot.camera->period) == doctest::Approx(1.0 / 30.0));
    CHECK(robot.camera->mount_height < robot.body.height);
    CHECK(robot.body.footprint.contains(robot.camera->base_from_camera.position()));
    CHECK(robot.camera->depth.has_value() == (robot.name == "3we_depth_v2"));
  }
  const RobotProfile real = load_profile("3we_depth_v2");
  CHECK(real.lidar);
  const RobotProfile ideal = with_noise(real, NoiseLevel::ideal);
  REQUIRE(ideal.camera);
  CHECK(ideal.camera->sigma == 0.0);
  CHECK(ideal.camera->latency == Duration::zero());
  CHECK(ideal.camera->depth->sigma == 0.0);
  CHECK(ideal.camera->depth->range_max == real.camera->depth->range_max);
  CHECK_FALSE(load_profile("turtlebot_like").camera);
}

TEST_CASE("the base robot is the standard one without its lidar") {
  const RobotProfile base = load_profile("3we_base_v2");
  const RobotProfile standard = load_profile("3we_standard_v2");
  CHECK_FALSE(base.lidar);
  CHECK(base.imu);
  REQUIRE(base.ultrasonics);
  CHECK(base.ultrasonics->mounts.size() == 4);
  CHECK(base.body.footprint == standard.body.footprint);
  CHECK(base.body.mass < standard.body.mass);
  CHECK(base.operating_limits == standard.operating_limits);
  CHECK(base.battery->idle_power < standard.battery->idle_power);
}

TEST_CASE("the differential robot has its base between the wheels, ahead of its middle") {
  const RobotProfile robot = load_profile("turtlebot_like");
  CHECK(robot.kinematics() == Kinematics::differential);
  CHECK(robot.body.wheels.wheel_count() == 2);
  REQUIRE(robot.body.casters.size() == 1);
  CHECK(robot.body.casters.front().position == Vec2{-0.081, 0.0});
  CHECK(robot.body.wheels.width == 0.018);
  CHECK(robot.body.wheels.rollers == 0);
  CHECK(robot.body.footprint.contains({-0.1, 0.0}));
  CHECK_FALSE(robot.body.footprint.contains({0.05, 0.0}));
}

TEST_CASE("every profile loads, and brakes within friction") {
  const auto names = profile_names();
  CHECK(names.size() >= 2);
  for (const std::string& name : names) {
    CAPTURE(name);
    CHECK_NOTHROW(load_profile(name));
  }
}

TEST_CASE("a profile keeps its text, from which it is read again without its file") {
  for (const std::string& name : profile_names()) {
    const RobotProfile profile = load_profile(name);
    CHECK(profile.yaml == text_of(name));
    const RobotProfile again = parse_profile(profile.yaml, name + ".yaml");
    CHECK(again.name == name);
    CHECK(again.yaml == profile.yaml);
    CHECK(again.body.mass == profile.body.mass);
    CHECK(again.has(SensorType::lidar) == profile.has(SensorType::lidar));
  }
  CHECK_THROWS_WITH_AS((void)parse_profile("a: [", "mine.yaml"), doctest::Contains("mine.yaml:"), ConfigError);
}

TEST_CASE("how wheels pull that slip freely is told by a profile, or not") {
  CHECK_FALSE(load_profile("3we_standard_v2").body.traction);
  const std::string lag = "  motor_lag: 0.03 ";
  const std::string traction =
      "  traction: {ahead: 0.99, turning: 0.98, turning_lag: 0.005, load: 1, mass_height: 0.08, sideways: 0.97, shift: "
      "0.5, shift_speed: 0.6}\n" +
      lag;
  const RobotProfile fitted = load_profile(break_profile(lag, traction).file);
  REQUIRE(fitted.body.traction);
  CHECK(fitted.body.traction->sideways == 0.97);
  CHECK(fitted.body.traction->turning_lag == 5ms);
  CHECK(fitted.body.traction->shift_speed == 0.6);

  const auto says = [&](const std::string& from, const std::string& to) {
    std::string wrong = traction;
    wrong.replace(wrong.find(from), from.size(), to);
    return error_of(break_profile(lag, wrong).file);
  };
  CHECK(says("load: 1", "lode: 1").find("missing field 'load'") != std::string::npos);
  CHECK(says("ahead: 0.99", "ahead: 99").find("outside [0.5, 1.5]") != std::string::npos);
  CHECK(says("shift_speed: 0.6", "shift_speed: 0.6, shiver: 1").find("unknown field 'shiver'") != std::string::npos);
}

TEST_CASE("an unknown profile names the nearest") {
  try {
    load_profile("3we_standart_v2");
    FAIL("did not throw");
  } catch (const ConfigError& error) {
    CHECK(std::string(error.what()).find("'3we_standard_v2'") != std::string::npos);
  }
  CHECK_THROWS_AS(load_profile("no/such/file.yaml"), ConfigError);
}

TEST_CASE("every mistake names its file, its line and what would be right") {
  struct Case {
    std::string from;
    std::string to;
    std::string says;
  };
  const Case cases[] = {
      {"mass: 2.5", "mas: 2.5", "missing field 'mass'"},
      {"friction: 0.7", "friction: slippery", "expected a number"},
      {"friction: 0.7", "friction: .nan", "finite"},
      {"friction: 0.7", "friction: -1", "outside [0.01, 5]"},
      {"mass: 2.5", "mass: 2500000", "outside"},
      {"kinematics: holonomic", "kinematics: holonomous", "did you mean 'holonomic'"},
      {"radius: 0.0325", "radius: 32.5", "outside"},
      {"width: 0.03 ", "width: 0.04 ", "less than the radius of a mecanum wheel"},
      {"mass: 0.06", "mass: 0.7", "leave nothing of the robot's 2.5 kg"},
      {"mass: 0.06", "mass: 0.4", "kg m^2 of inertia"},
      {"rollers: 9", "rollers: 2", "outside"},
      {"{length: 0.25, width: 0.22}", "{corners: [[0.1, 0.1], [0.1, -0.1], [-0.1, 0]]}", "counter-clockwise"},
      {"{length: 0.25, width: 0.22}", "{corners: [[0.1, 0.1], [-0.1, -0.1]]}", "at least 3 corners"},
      {"{length: 0.25, width: 0.22}", "{length: 0.25, width: 0.22, hight: 1}", "unknown field 'hight'"},
      {"hardware: {linear: 1.2", "hardware: {linear: 1.9", "beyond the motors'"},
      {"linear_braking: 4.0", "linear_braking: 8.0", "friction"},
      {"operating: {linear: 0.5", "operating: {linear: 1.5", "beyond the hardware limit"},
      {"points_per_turn: 450", "points_per_turn: 450.5", "whole number"},
      {"points_per_turn: 450", "points_per_turn: 2", "outside"},
      {"clockwise: true", "clockwise: maybe", "true or false"},
      {"beams: 360", "beams: 451", "cannot be made of 450 points"},
      {"range_min: 0.02", "range_min: 12.0", "below range_max"},
      {"width: 640", "width: 0", "outside [1, 8192]"},
      {"height: 480", "height: 1000000000", "outside [1, 8192]"},
      {"base_from_lidar: [0.04,", "base_from_lidar: [40,", "base_from_lidar[0]: 40 is outside [-5, 5]"},
      {"left: [0.0, 0.11, 1.5708]", "left: [0.0, 0.11, 90]", "left[2]: 90 is outside"},
      {"horizontal_fov: 1.5708", "horizontal_fov: 90", "outside"},
      {"interval: 0.06", "interval: 60", "outside"},
      {"field_of_view: 0.2618", "field_of_view: 15", "outside"},
      {"left: [0.0, 0.11, 1.5708]", "left: [0.0]", "[x, y, theta]"},
      {"left: [0.0, 0.11, 1.5708]", "front_left: [0.0, 0.11, 1.5708]", "twice"},
      {"lateral_scale: [0.85, 0.98]", "lateral_scale: [0.98, 0.85]", "expected [low, high]"},
      {"lateral_scale: [0.85, 0.98]", "lateral_scale: 0.9", "expected a list"},
      {"voltage_empty: 6.0", "voltage_empty: 9.0", "must not exceed voltage_full"},
      {"command_latency: 0.04", "command_latency: 40", "outside"},
      {"  lidar:", "  lydar:", "did you mean 'lidar'"},
      {"description:", "{description:", "malformed YAML"},
  };
  for (const Case& c : cases) {
    CAPTURE(c.to);
    const Broken broken = break_profile(c.from, c.to);
    const std::string error = error_of(broken.file);
    CAPTURE(error);
    CHECK(error.find(c.says) != std::string::npos);
    CHECK(error.starts_with(broken.file + ":"));
    // a missing field, or bad indentation, is reported where the mapping begins or the parser gave up
    if (c.says.starts_with("missing") || c.says.starts_with("malformed")) continue;
    CHECK(error.starts_with(broken.file + ":" + std::to_string(broken.line) + ":"));
  }
}

TEST_CASE("a robot may lack any sensor but its wheels") {
  std::string text = text_of("3we_standard_v2");
  const auto cut = [&](const std::string& from, const std::string& to) {
    const std::size_t begin = text.find(from);
    const std::size_t end = text.find(to);
    REQUIRE(begin < end);
    text.erase(begin, end - begin);
  };
  cut("  lidar:", "  odometry:");
  text.erase(text.find("battery:"));
  const auto file = std::filesystem::temp_directory_path() / "threewe_profile_test.yaml";
  std::ofstream(file) << text;
  const RobotProfile robot = load_profile(file.string());
  CHECK_FALSE(robot.lidar);
  CHECK_FALSE(robot.imu);
  CHECK_FALSE(robot.ultrasonics);
  for (const SensorType type : {SensorType::lidar, SensorType::imu, SensorType::battery, SensorType::ultrasonic}) {
    CHECK_FALSE(robot.has(type));
  }
  CHECK(robot.has(SensorType::odometry));
  CHECK_FALSE(robot.battery);
}

TEST_CASE("a sensor's place by its name") {
  const RobotProfile robot = load_profile("3we_standard_v2");
  CHECK(robot.base_from_sensor(SensorType::lidar, "lidar") == robot.lidar->base_from_lidar);
  CHECK(robot.base_from_sensor(SensorType::ultrasonic, "ultrasonic_left").position() == Vec2{0.0, 0.11});
  CHECK(robot.base_from_sensor(SensorType::ultrasonic, "ultrasonic_rear") == Pose2D{});
  CHECK(robot.base_from_sensor(SensorType::imu, "imu") == Pose2D{});
}

TEST_CASE("noise levels by name") {
  CHECK(noise_level("realistic") == NoiseLevel::realistic);
  CHECK(noise_level("ideal") == NoiseLevel::ideal);
  try {
    noise_level("idael");
    FAIL("did not throw");
  } catch (const ConfigError& error) {
    CHECK(std::string(error.what()).find("'ideal'") != std::string::npos);
  }
}

TEST_CASE("ideal switches off the imperfections, not the sensors, nor what the body obeys") {
  const RobotProfile real = load_profile("3we_standard_v2");
  const RobotProfile ideal = with_noise(real, NoiseLevel::ideal);
  REQUIRE(ideal.lidar);
  REQUIRE(ideal.imu);
  REQUIRE(ideal.battery);
  CHECK(ideal.command_latency == Duration::zero());
  CHECK(ideal.lidar->sigma == 0.0);
  CHECK(ideal.lidar->bias == 0.0);
  CHECK(ideal.lidar->dropout == 0.0);
  CHECK(ideal.lidar->latency == Duration::zero());
  CHECK_FALSE(ideal.lidar->rolling);
  CHECK(ideal.lidar->points_per_turn == ideal.lidar->beams);
  CHECK(ideal.lidar->beams == real.lidar->beams);
  CHECK(ideal.lidar->range_max == real.lidar->range_max);
  REQUIRE(ideal.ultrasonics);
  CHECK(ideal.ultrasonics->sigma == 0.0);
  CHECK(ideal.ultrasonics->latency == Duration::zero());
  CHECK(ideal.ultrasonics->max_incidence > 1.5);
  CHECK(ideal.ultrasonics->field_of_view == real.ultrasonics->field_of_view);
  CHECK(ideal.imu->gyro_bias == 0.0);
  CHECK(ideal.imu->period == real.imu->period);
  CHECK(ideal.odometry.wheel_scale == 0.0);
  CHECK(ideal.odometry.lateral_scale_min == 1.0);
  CHECK(ideal.odometry.ticks_per_turn == 0);
  CHECK(ideal.odometry.period == real.odometry.period);
  CHECK(ideal.body.motor_lag == real.body.motor_lag);
  CHECK(ideal.body.friction == real.body.friction);
  CHECK(with_noise(real, NoiseLevel::realistic).lidar->sigma == real.lidar->sigma);
}
