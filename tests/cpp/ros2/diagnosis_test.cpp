// What is said of a robot that cannot be reached.
#include "ros2/diagnosis.hpp"

#include <doctest/doctest.h>

#include <cstddef>
#include <optional>

namespace threewe::ros2 {
namespace {

const TopicSpec kScan{"lidar", "/scan", "sensor_msgs/msg/LaserScan", false};

Endpoint publisher(const char* topic, const char* type) {
  Endpoint endpoint;
  endpoint.publishes = true;
  endpoint.topic = topic;
  endpoint.type = type;
  return endpoint;
}

TEST_CASE("what matches is no mistake") {
  CHECK(diagnose(kScan, false, {publisher("/scan", "sensor_msgs/msg/LaserScan")}).empty());
}

TEST_CASE("an absent topic names others of its type") {
  CHECK(diagnose(kScan, false, {}) == "lidar: no node publishes /scan (sensor_msgs/msg/LaserScan)");
  CHECK(diagnose(kScan, false, {publisher("/base_scan", "sensor_msgs/msg/LaserScan")}) ==
        "lidar: no node publishes /scan (sensor_msgs/msg/LaserScan); of that type there is /base_scan");
}

TEST_CASE("another type is named, as where velocities are stamped") {
  Endpoint theirs = publisher("/cmd_vel", "geometry_msgs/msg/TwistStamped");
  theirs.publishes = false;
  CHECK(diagnose({"command", "/cmd_vel", "geometry_msgs/msg/Twist", true}, true, {theirs}) ==
        "command: /cmd_vel is of type geometry_msgs/msg/TwistStamped, the profile has geometry_msgs/msg/Twist");
}

TEST_CASE("an offer of less than is asked for is named, as is a type of another make") {
  TopicSpec topic = kScan;
  topic.reliable = true;
  Endpoint theirs = publisher("/scan", "sensor_msgs/msg/LaserScan");
  theirs.qos.reliable = false;
  CHECK(diagnose(topic, false, {theirs}) ==
        "lidar: /scan is best effort there, the profile has reliable: the two do not match");
  theirs.hash = "RIHS01_00";
  CHECK(diagnose(kScan, false, {theirs}).find("RIHS01_00") != std::string::npos);
}

TEST_CASE("a type of another make is named whichever of several publishers has it") {
  Endpoint wrong = publisher("/scan", "sensor_msgs/msg/LaserScan");
  wrong.hash = "RIHS01_00";
  CHECK(diagnose(kScan, false, {publisher("/scan", "sensor_msgs/msg/LaserScan"), wrong}).find("RIHS01_00") !=
        std::string::npos);
}

TEST_CASE("velocities are of the type that the robot takes") {
  const TopicSpec command{"command", "/cmd_vel", "geometry_msgs/msg/Twist", true};
  Endpoint stamped = publisher("/cmd_vel", "geometry_msgs/msg/TwistStamped");
  CHECK(command_type(command, {stamped}) == "geometry_msgs/msg/Twist");  // another driver's
  stamped.publishes = false;
  CHECK(command_type(command, {}) == "geometry_msgs/msg/Twist");
  CHECK(command_type(command, {stamped}) == "geometry_msgs/msg/TwistStamped");
  Endpoint plain = stamped;
  plain.type = "geometry_msgs/msg/Twist";
  CHECK(command_type(command, {stamped, plain}) == "geometry_msgs/msg/Twist");
  plain.type = "std_msgs/msg/String";
  CHECK(command_type(command, {plain}) == "geometry_msgs/msg/Twist");
}

TEST_CASE("other nodes that command the robot, or publish what it measures, are named") {
  Endpoint other = publisher("/cmd_vel", "geometry_msgs/msg/Twist");
  const TopicSpec command{"command", "/cmd_vel", "geometry_msgs/msg/Twist", true};
  CHECK(diagnose_drivers(command, {}).empty());
  CHECK(diagnose_drivers(command, {publisher("/odom", "nav_msgs/msg/Odometry")}).empty());
  other.node = "/teleop";
  CHECK(diagnose_drivers(command, {other}).starts_with("command: /cmd_vel is published by /teleop as well"));
  other.type = "geometry_msgs/msg/TwistStamped";  // of which a robot may take both
  other.node.clear();
  CHECK(diagnose_drivers(command, {other}).find("a node without a name") != std::string::npos);
  CHECK(diagnose_rivals(
            kScan, {publisher("/scan", "sensor_msgs/msg/LaserScan"), publisher("/scan", "sensor_msgs/msg/LaserScan")})
            .starts_with("lidar: two nodes publish it on /scan (a node without a name, a node without a name)"));
}

TEST_CASE("lost images name the kernel's buffer where that is too small") {
  CHECK(explain_lost_images(212992) ==
        "an image comes as one burst of packets, of which the kernel keeps 208 KiB at most: sysctl -w "
        "net.core.rmem_max=4194304");
  CHECK(explain_lost_images(4U << 20U).find("sysctl") == std::string::npos);
}

TEST_CASE("where there is nothing, what was seen and what to try") {
  Search search{10s, 0, {"eth0 192.168.7.2"}};
  CHECK(diagnose_silence({}, search).find("ROS_AUTOMATIC_DISCOVERY_RANGE=SUBNET") != std::string::npos);
  CHECK(diagnose_silence({3, DiscoveryRange::localhost, {}}, search)
            .starts_with("no ROS 2 node was found in domain 3 on this computer within 10 s (interfaces: eth0 "
                         "192.168.7.2); to look farther"));
  CHECK(diagnose_silence({3, DiscoveryRange::subnet, {}}, search).find("multicast") != std::string::npos);
  CHECK(diagnose_silence({3, DiscoveryRange::off, {}}, search).find("is OFF") != std::string::npos);
  search.participants = 2;
  CHECK(diagnose_silence({3, DiscoveryRange::subnet, {}}, search).find("2 participants of DDS without a topic") !=
        std::string::npos);
  search.interfaces.clear();
  CHECK(diagnose_silence({}, search).find("(no network interface is up)") != std::string::npos);
}

TEST_CASE("a part is ok, stale or mistaken") {
  const RobotProfile profile = load_profile("nav2_robot");
  const auto ok = to_status(profile, "lidar", "", 100ms, 1s);
  CHECK(ok.name == "threewe: lidar");
  CHECK(ok.hardware_id == "nav2_robot");
  CHECK(ok.level == std::byte{0});
  CHECK(ok.message == "ok");
  const auto stale = to_status(profile, "lidar", "", 2500ms, 1s);
  CHECK(stale.level == std::byte{3});
  CHECK(stale.message == "no message for 2.5 s");
  CHECK(to_status(profile, "lidar", "", std::nullopt, 1s).message == "no message yet");
  const auto wrong = to_status(profile, "lidar", "two nodes publish it", 100ms, 1s);
  CHECK(wrong.level == std::byte{2});
  CHECK(wrong.message == "two nodes publish it");
}

}  // namespace
}  // namespace threewe::ros2
