// The `link:` section of a profile: how a real robot is reached.
#include <doctest/doctest.h>

#include <algorithm>
#include <string>

#include "threewe/core/errors.hpp"
#include "threewe/hardware/profile.hpp"

namespace threewe {
namespace {

const std::string kSection = R"(
link:
  driver: ros2
  namespace: /robot
  topics:
    lidar: {topic: /scan, type: sensor_msgs/msg/LaserScan, reliability: reliable}
    odometry: {topic: /tf, type: tf2_msgs/msg/TFMessage}
  command: {topic: /cmd_vel, type: geometry_msgs/msg/TwistStamped, shared: true}
  frames: {odom: odom_combined, base: base_footprint}
  stops: {by: the driver, after: 0.5}
)";

std::string without_link() {
  const std::string yaml = load_profile("3we_standard_v2").yaml;
  return yaml.substr(0, yaml.find("\nlink:"));
}

std::string error_with(const std::string& from, const std::string& to) {
  std::string section = kSection;
  const std::size_t at = section.find(from);
  REQUIRE_MESSAGE(at != std::string::npos, from);
  try {
    parse_profile(without_link() + section.replace(at, from.size(), to), "mine.yaml");
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

TEST_CASE("a link says where each sensor comes from, and who stops the robot") {
  const RobotProfile profile = parse_profile(without_link() + kSection, "mine.yaml");
  REQUIRE(profile.link);
  const LinkSpec& link = *profile.link;
  CHECK(link.driver == "ros2");
  REQUIRE(link.topics.size() == 2);
  CHECK(link.topics[0].sensor == "odometry");
  CHECK(link.topics[0].topic == "/robot/tf");
  CHECK_FALSE(link.topics[0].reliable);  // what everyone's offer is enough for
  CHECK(link.topics[1].sensor == "lidar");
  CHECK(link.topics[1].topic == "/robot/scan");
  CHECK(link.topics[1].type == "sensor_msgs/msg/LaserScan");
  CHECK(link.topics[1].reliable);
  CHECK(link.command.topic == "/robot/cmd_vel");
  CHECK(link.command.reliable);
  CHECK(link.shared_command);
  CHECK(link.odom_frame == "odom_combined");
  CHECK(link.base_frame == "base_footprint");
  CHECK(link.stopped_by == "the driver");
  CHECK(link.stopped_after == 500ms);
}

TEST_CASE("the standard robot delivers all but its camera, in the frames that REP 105 names") {
  const RobotProfile profile = load_profile("3we_standard_v2");
  REQUIRE(profile.link);
  CHECK(profile.link->topics.size() == 8);
  CHECK(std::ranges::none_of(profile.link->topics, [](const TopicSpec& topic) { return topic.sensor == "camera"; }));
  CHECK_FALSE(profile.link->shared_command);
  CHECK(profile.link->odom_frame == "odom");
  CHECK(profile.link->base_frame == "base_link");
  CHECK(profile.link->stopped_after == 200ms);
}

TEST_CASE("a profile without a link is of a robot that is simulated alone") {
  CHECK_FALSE(parse_profile(without_link(), "mine.yaml").link);
}

TEST_CASE("a topic of a sensor that the profile does not describe is refused with the reason") {
  const std::string yaml = load_profile("turtlebot3_burger").yaml;
  const std::string rest = yaml.substr(0, yaml.find("\nlink:")) + kSection;
  const auto error = [&](const std::string& sensor) -> std::string {
    std::string section = rest;
    section.replace(section.find("    lidar:"), 10, "    " + sensor + ":");
    try {
      parse_profile(section, "mine.yaml");
    } catch (const ConfigError& wrong) {
      return wrong.what();
    }
    return "";
  };
  CHECK(error("camera").find("the profile describes no camera: add one") != std::string::npos);
  CHECK(error("depth").find("the profile describes no depth") != std::string::npos);
  CHECK(error("lidar").empty());
}

TEST_CASE("every mistake in a link names its place and what would be right") {
  struct Case {
    const char* from;
    const char* to;
    const char* message;
  };
  for (const auto& [from, to, message] : {
           Case{"driver: ros2", "driver: ros1", "did you mean 'ros2'?"},
           Case{"namespace: /robot", "namespace: robot", "expected a name such as /scan"},
           Case{"topic: /scan", "topic: /scan/", "expected a name such as /scan"},
           Case{"topic: /scan", "topic: /2d", "expected a name such as /scan"},
           Case{"topic: /scan", "topic: /a scan", "expected a name such as /scan"},
           Case{"topic: /scan", "topic: ''", "expected a name such as /scan"},
           Case{"sensor_msgs/msg/LaserScan", "sensor_msgs/msg/LaserScam", "did you mean 'sensor_msgs/msg/LaserScan'?"},
           Case{"reliability: reliable", "reliability: reliably", "did you mean 'reliable'?"},
           Case{"    lidar:", "    lidr:", "lidar"},
           Case{"    odometry:", "    odometri:", "odometry"},
           Case{"after: 0.5", "after: 0.01", "0.05"},
           Case{"after: 0.5", "after: 200", "2"},
           Case{"shared: true", "shared: 2", "shared"},
           Case{"command:", "comand:", "command"},
           Case{"frames:", "fames:", "frames"},
       }) {
    CAPTURE(to);
    const std::string error = error_with(from, to);
    CHECK_MESSAGE(error.find(message) != std::string::npos, error);
    CHECK_MESSAGE(error.starts_with("mine.yaml:"), error);
  }
}

}  // namespace
}  // namespace threewe
