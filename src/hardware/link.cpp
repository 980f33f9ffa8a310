#include "hardware/link.hpp"

#include <algorithm>
#include <cctype>

#include <fmt/format.h>

namespace threewe {
namespace {

constexpr double kSoonest = 0.05;  // [s] commands come every 0.02 s, and one may be lost
constexpr double kLatest = 2.0;    // [s] at 0.5 m/s, a metre without control

// What a sensor other than an ultrasonic one may come as, and whether a robot has it.
struct Kind {
  Deliverable deliverable;
  bool (*is_on)(const RobotProfile&);
};

const std::vector<Kind>& kinds() {
  static const std::vector<Kind> all{
      {{"odometry", {"nav_msgs/msg/Odometry", "tf2_msgs/msg/TFMessage"}}, [](const RobotProfile&) { return true; }},
      {{"lidar", {"sensor_msgs/msg/LaserScan", "sensor_msgs/msg/PointCloud2"}},
       [](const RobotProfile& profile) { return profile.lidar.has_value(); }},
      {{"imu", {"sensor_msgs/msg/Imu"}}, [](const RobotProfile& profile) { return profile.imu.has_value(); }},
      {{"battery", {"sensor_msgs/msg/BatteryState"}},
       [](const RobotProfile& profile) { return profile.battery.has_value(); }},
      {{"camera", {"sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"}},
       [](const RobotProfile& profile) { return profile.camera.has_value(); }},
      {{"depth", {"sensor_msgs/msg/Image"}},
       [](const RobotProfile& profile) { return profile.camera && profile.camera->depth; }}};
  return all;
}

constexpr const char* kUltrasonic = "sensor_msgs/msg/Range";

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
  std::vector<Deliverable> all;
  for (const Kind& kind : kinds()) {
    if (kind.is_on(profile)) all.push_back(kind.deliverable);
  }
  if (profile.ultrasonics) {
    for (const auto& mount : profile.ultrasonics->mounts) all.push_back({mount.name, {kUltrasonic}});
  }
  return all;
}

std::string_view sensor_of(std::string_view type) {
  if (type == kUltrasonic) return "ultrasonics";
  for (const Kind& kind : kinds()) {
    const auto& [sensor, types] = kind.deliverable;
    if (std::ranges::find(types, type) != types.end()) return sensor;
  }
  return "";
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
  for (const Kind& kind : kinds()) {
    const std::string& sensor = kind.deliverable.sensor;
    if (!kind.is_on(profile) && topics.has(sensor)) {
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
