#include "hardware/link.hpp"

#include <algorithm>
#include <cctype>

#include <fmt/format.h>

namespace threewe {
namespace {

constexpr double kSoonest = 0.05;  // [s] commands come every 0.02 s, and one may be lost
constexpr double kLatest = 2.0;    // [s] at 0.5 m/s, a metre without control

std::string read_name(const ConfigNode& node) {
  const std::string name = node.text();
  if (is_ros_name(name)) return name;
  node.fail(fmt::format("expected a name such as /scan or /robot/scan, of letters, digits, _ and /, got '{}'", name));
}

TopicSpec read_topic(ConfigNode node, const std::string& name_space, const std::string& sensor,
                     const std::vector<std::string>& types, bool reliable) {
  TopicSpec topic{
      .sensor = sensor, .topic = name_space + read_name(node.at("topic")), .type = {}, .reliable = reliable};
  topic.type = node.choice("type", types);
  if (node.has("reliability")) {
    topic.reliable = node.choice("reliability", {"best_effort", "reliable"}) == "reliable";
  }
  node.finish();
  return topic;
}

}  // namespace

bool is_ros_name(std::string_view name) {
  char before = ' ';
  for (const char c : name) {
    const auto letter = static_cast<unsigned char>(c);
    const bool fits = before == ' '   ? c == '/'
                      : before == '/' ? std::isalpha(letter) != 0 || c == '_'
                                      : std::isalnum(letter) != 0 || c == '_' || c == '/';
    if (!fits) return false;
    before = c;
  }
  return before != ' ' && before != '/';
}

std::vector<Deliverable> deliverables(const RobotProfile& profile) {
  std::vector<Deliverable> all{{"odometry", {"nav_msgs/msg/Odometry", "tf2_msgs/msg/TFMessage"}}};
  if (profile.lidar) all.push_back({"lidar", {"sensor_msgs/msg/LaserScan", "sensor_msgs/msg/PointCloud2"}});
  if (profile.imu) all.push_back({"imu", {"sensor_msgs/msg/Imu"}});
  if (profile.battery) all.push_back({"battery", {"sensor_msgs/msg/BatteryState"}});
  if (profile.camera) all.push_back({"camera", {"sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"}});
  if (profile.camera && profile.camera->depth) all.push_back({"depth", {"sensor_msgs/msg/Image"}});
  if (profile.ultrasonics) {
    for (const auto& mount : profile.ultrasonics->mounts) all.push_back({mount.name, {"sensor_msgs/msg/Range"}});
  }
  return all;
}

std::vector<std::string> command_types() { return {"geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped"}; }

LinkSpec read_link(ConfigNode node, const RobotProfile& profile) {
  LinkSpec link;
  link.driver = node.choice("driver", {"ros2"});
  if (node.has("namespace")) link.name_space = read_name(node.at("namespace"));

  ConfigNode topics = node.at("topics");
  topics.at("odometry");  // no robot is without
  for (const auto& [sensor, types] : deliverables(profile)) {
    if (topics.has(sensor)) {
      link.topics.push_back(read_topic(topics.at(sensor), link.name_space, sensor, types, false));
    }
  }
  for (const char* sensor : {"lidar", "imu", "battery", "camera", "depth"}) {
    const bool known = std::ranges::find(link.topics, sensor, &TopicSpec::sensor) != link.topics.end();
    if (!known && topics.has(sensor)) {
      topics.at(sensor).fail(fmt::format("the profile describes no {0}: add one, or leave its topic out", sensor));
    }
  }
  topics.finish();
  ConfigNode command = node.at("command");
  if (command.has("shared")) link.shared_command = command.at("shared").boolean();
  link.command = read_topic(command, link.name_space, "command", command_types(), true);

  if (node.has("frames")) {
    ConfigNode frames = node.at("frames");
    if (frames.has("map")) link.map_frame = frames.text("map");
    link.odom_frame = frames.text("odom");
    link.base_frame = frames.text("base");
    frames.finish();
  }
  ConfigNode stops = node.at("stops");
  link.stopped_by = stops.text("by");
  link.stopped_after = from_seconds(stops.number_in("after", kSoonest, kLatest));
  stops.finish();
  node.finish();
  return link;
}

}  // namespace threewe
