// Which topics a link would use.
#include "ros2/link_proposal.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "threewe/core/errors.hpp"

namespace threewe::ros2 {
namespace {

Endpoint endpoint(const char* topic, const char* type, bool publishes = true) {
  Endpoint made;
  made.publishes = publishes;
  made.topic = topic;
  made.type = type;
  return made;
}

const std::vector<Endpoint> kRobot{
    endpoint("/base_scan", "sensor_msgs/msg/LaserScan"), endpoint("/camera/depth/image", "sensor_msgs/msg/Image"),
    endpoint("/camera/image", "sensor_msgs/msg/Image"),  endpoint("/cmd_vel", "geometry_msgs/msg/TwistStamped", false),
    endpoint("/odom", "nav_msgs/msg/Odometry"),          endpoint("/robot/cmd_vel_unused", "geometry_msgs/msg/Twist"),
    endpoint("/rosout", "rcl_interfaces/msg/Log"),       endpoint("/scan_filtered", "sensor_msgs/msg/LaserScan"),
    endpoint("/sonar/left", "sensor_msgs/msg/Range"),    endpoint("/tf", "tf2_msgs/msg/TFMessage"),
};

const TopicUse& use_of(const LinkProposal& proposal, std::string_view topic) {
  const auto found = std::ranges::find(proposal.topics, topic, &TopicUse::topic);
  REQUIRE(found != proposal.topics.end());
  return *found;
}

TEST_CASE("each sensor has the topic that fits, and each other topic a reason") {
  const LinkProposal proposal = propose_link(load_profile("3we_standard_v2"), kRobot);
  CHECK(use_of(proposal, "/base_scan").sensor == "lidar");
  CHECK(use_of(proposal, "/odom").sensor == "odometry");
  CHECK(use_of(proposal, "/cmd_vel").sensor == "command");
  CHECK(use_of(proposal, "/camera/image").sensor == "camera");
  CHECK(use_of(proposal, "/scan_filtered").reason == "lidar is /base_scan");
  CHECK(use_of(proposal, "/tf").reason == "odometry is /odom");
  CHECK(use_of(proposal, "/rosout").reason == "no sensor comes as this type");
  CHECK(use_of(proposal, "/robot/cmd_vel_unused").reason == "command is /cmd_vel");
  CHECK(std::ranges::find(proposal.missing, "imu") != proposal.missing.end());
  CHECK(std::ranges::all_of(proposal.topics,
                            [](const TopicUse& use) { return use.sensor.empty() != use.reason.empty(); }));
}

TEST_CASE("names decide among several of one type, those of the profile's own link first") {
  std::vector<Endpoint> more = kRobot;
  more.push_back(endpoint("/scan", "sensor_msgs/msg/LaserScan"));
  for (const char* side : {"/ultrasonic/right", "/ultrasonic/left", "/ultrasonic/front_left"}) {
    more.push_back(endpoint(side, "sensor_msgs/msg/Range"));
  }
  const LinkProposal proposal = propose_link(load_profile("3we_standard_v2"), more);
  CHECK(use_of(proposal, "/scan").sensor == "lidar");
  CHECK(use_of(proposal, "/ultrasonic/left").sensor == "ultrasonic_left");
  CHECK(use_of(proposal, "/ultrasonic/right").sensor == "ultrasonic_right");
  CHECK(use_of(proposal, "/ultrasonic/front_left").sensor == "ultrasonic_front_left");
}

TEST_CASE("what a profile does not have is said") {
  const LinkProposal proposal = propose_link(load_profile("turtlebot3_burger"), kRobot);
  CHECK(use_of(proposal, "/sonar/left").reason == "the profile has no ultrasonics");
  CHECK(use_of(proposal, "/camera/image").reason == "the profile has no camera");
}

TEST_CASE("a type of unknown hash is not used") {
  std::vector<Endpoint> changed = kRobot;
  for (Endpoint& one : changed) one.hash = "RIHS01_00";
  const LinkProposal proposal = propose_link(load_profile("3we_standard_v2"), changed);
  CHECK(use_of(proposal, "/odom").reason == "no distribution that we know has its type so");
}

TEST_CASE("what is written is read again; without who stops the robot it is refused") {
  const RobotProfile profile = load_profile("nav2_robot");
  const std::string rest = profile.yaml.substr(0, profile.yaml.find("\nlink:") + 1);
  const RobotProfile again = parse_profile(rest + propose_link(profile, kRobot).yaml, "written.yaml");
  REQUIRE(again.link);
  CHECK(again.link->command.type == "geometry_msgs/msg/TwistStamped");
  CHECK(again.link->stopped_by == profile.link->stopped_by);
  CHECK(again.link->stopped_after == profile.link->stopped_after);
  CHECK(again.link->odom_frame == profile.link->odom_frame);

  RobotProfile without = profile;
  without.link.reset();
  CHECK_THROWS_WITH_AS(parse_profile(rest + propose_link(without, kRobot).yaml, "written.yaml"),
                       doctest::Contains("stops"), ConfigError);
}

}  // namespace
}  // namespace threewe::ros2
