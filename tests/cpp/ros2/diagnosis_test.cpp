// What is said of a robot that cannot be reached.
#include "ros2/diagnosis.hpp"

#include <doctest/doctest.h>

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

TEST_CASE("lost images name the kernel's buffer where that is too small") {
  CHECK(explain_lost_images(212992) ==
        "an image comes as one burst of packets, of which the kernel keeps 208 KiB at most: sysctl -w "
        "net.core.rmem_max=4194304");
  CHECK(explain_lost_images(4U << 20U).find("sysctl") == std::string::npos);
}

TEST_CASE("where there is nothing, what to try") {
  CHECK(diagnose_silence({}).find("ROS_AUTOMATIC_DISCOVERY_RANGE=SUBNET") != std::string::npos);
  CHECK(diagnose_silence({3, DiscoveryRange::localhost, {}}).find("domain 3 on this computer") != std::string::npos);
  CHECK(diagnose_silence({3, DiscoveryRange::subnet, {}}).find("multicast") != std::string::npos);
}

}  // namespace
}  // namespace threewe::ros2
