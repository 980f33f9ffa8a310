#include "ros2/dds/served_robot.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "export/robot_description.hpp"
#include "ros2/diagnosis.hpp"
#include "ros2/publications.hpp"
#include "ros2/readings.hpp"
#include "threewe/core/errors.hpp"
#include "threewe/export/export.hpp"

namespace threewe::ros2 {
namespace {

constexpr Duration kWatchdog = 500ms;  // as that of ROS 2's diff_drive_controller
constexpr Duration kDiagnostics = 1s;  // from one message of them to the next
constexpr int kImagesAhead = 20;       // that lockstep sends before it waits until all have been received
constexpr const char* kMapFrame = "map";
constexpr const char* kFootprintFrame = "base_footprint";
constexpr Distribution kLayout = Distribution::jazzy;  // as the hashes say that our endpoints have
constexpr Qos kKept{.reliable = true, .transient_local = true, .depth = 1};

std::string_view type_name(SensorType type) {
  switch (type) {
    case SensorType::lidar: return sensor_msgs::LaserScan::kType;
    case SensorType::imu: return sensor_msgs::Imu::kType;
    case SensorType::odometry: return nav_msgs::Odometry::kType;
    case SensorType::battery: return sensor_msgs::BatteryState::kType;
    case SensorType::ultrasonic: return sensor_msgs::Range::kType;
    case SensorType::camera: return sensor_msgs::Image::kType;
  }
  return "";
}

// By its frame's name in the URDF; what is measured of the base has none of its own.
std::string frame_of(const SensorInfo& sensor, const std::string& base_frame) {
  switch (sensor.type) {
    case SensorType::lidar:
    case SensorType::ultrasonic: return sensor.name;
    case SensorType::camera: return sensor.name + "_optical_frame";
    default: return base_frame;
  }
}

geometry_msgs::TransformStamped to_message(const std::string& parent, const std::string& child,
                                           const exports::Transform& parent_from_child) {
  geometry_msgs::TransformStamped message;
  message.header.frame_id = parent;
  message.child_frame_id = child;
  const auto& [position, rotation] = parent_from_child;
  message.transform.translation = {position.x, position.y, position.z};
  message.transform.rotation = {rotation.x, rotation.y, rotation.z, rotation.w};
  return message;
}

// Where everything is on the robot, wheels included, that never turn: what robot_state_publisher makes of the URDF.
tf2_msgs::TFMessage fixed_frames(const RobotProfile& profile, const std::string& base_frame) {
  const exports::RobotDescription robot = exports::without_rollers(exports::describe(profile));
  tf2_msgs::TFMessage frames;
  const auto add = [&](const std::string& parent, const std::string& child, const exports::Transform& transform) {
    frames.transforms.push_back(to_message(parent == robot.base().name ? base_frame : parent, child, transform));
  };
  add(base_frame, kFootprintFrame, {});
  for (const exports::Joint& joint : robot.joints) add(joint.parent, joint.child, joint.parent_from_child);
  for (const exports::SensorMount& mount : robot.sensors) {
    add(base_frame, mount.name, mount.base_from_sensor);
    if (mount.type != SensorType::camera) continue;
    const auto turned = exports::about_z(-exact::kPi / 2) * exports::about_x(-exact::kPi / 2);
    add(mount.name, mount.name + "_optical_frame", {{}, turned});
  }
  return frames;
}

// "/camera" of "/camera/image_raw".
std::string folder_of(const std::string& topic) { return topic.substr(0, topic.rfind('/')); }

std::string without_ending(std::string text, std::string_view ending) {
  if (text.ends_with(ending)) text.resize(text.size() - ending.size());
  return text;
}

}  // namespace

ServedRobot::ServedRobot(backend::World& world, const backend::TruthService& truth, std::size_t index,
                         const std::string& name_space, const ServeOptions& options, const Discovery& discovery,
                         Bell& bell)
    : port_(world.robot(index)),
      world_(world),
      truth_(truth.truth(index)),
      profile_(port_.profile()),
      name_space_(name_space),
      with_map_(options.map),
      in_lockstep_(options.lockstep),
      depth_(options.lockstep ? 200 : 10),
      odom_frame_(profile_.link ? profile_.link->odom_frame : "odom"),
      base_frame_(profile_.link ? profile_.link->base_frame : "base_link"),
      watchdog_(profile_.link ? profile_.link->stopped_after : kWatchdog),
      bell_(bell),
      autonomy_(options.autonomies.empty() ? nullptr : options.autonomies[index]),
      node_(discovery, name_space.empty() ? "/" : name_space, "simulator") {
  port_.connect();
  for (const SensorInfo& sensor : port_.features().sensors) outlets_.push_back(advertise(sensor));
  newest_.resize(outlets_.size());
  diagnostics_ = node_.advertise("/diagnostics", diagnostic_msgs::DiagnosticArray::kType, {.depth = depth_});
  transforms_ = node_.advertise(name_space_ + "/tf", tf2_msgs::TFMessage::kType, {.depth = std::max(depth_, 100)});
  if (index == 0) clock_ = node_.advertise("/clock", rosgraph_msgs::Clock::kType, {.depth = depth_});

  const Node::Handle fixed = node_.advertise(name_space_ + "/tf_static", tf2_msgs::TFMessage::kType, kKept);
  send(fixed, fixed_frames(profile_, base_frame_));
  std_msgs::String urdf;
  urdf.data = exports::files(truth_.scene(), profile_, exports::Format::urdf).front().contents;
  send(node_.advertise(name_space_ + "/robot_description", std_msgs::String::kType, kKept), urdf);
  if (with_map_) {
    const auto map = node_.advertise(name_space_ + "/map", nav_msgs::OccupancyGrid::kType, kKept);
    send(map, to_message(exports::map_of(truth_.scene(), profile_), {to_stamp(world.now()), kMapFrame}));
  }

  if (autonomy_ != nullptr) {
    map_ = node_.advertise(name_space_ + "/map", nav_msgs::OccupancyGrid::kType, kKept);
    plan_ = node_.advertise(name_space_ + "/plan", nav_msgs::Path::kType, {.depth = 1});
    (void)node_.subscribe(name_space_ + "/goal_pose", geometry_msgs::PoseStamped::kType, {.depth = 1},
                          [this](std::span<const std::uint8_t> payload, std::uint64_t) {
                            const auto message = decode<geometry_msgs::PoseStamped>(payload, kLayout);
                            if (!message) return;
                            const auto& [position, rotation] = message->pose;
                            const auto pose = to_pose({{position.x, position.y, position.z}, rotation});
                            if (!pose) return;
                            const std::scoped_lock lock(bell_.mutex);
                            goal_.emplace(message->header.frame_id, *pose);
                          });
  }

  const std::string topic = name_space_ + (profile_.link ? profile_.link->command.topic : "/cmd_vel");
  receive<geometry_msgs::Twist>(topic);
  receive<geometry_msgs::TwistStamped>(topic);
}

std::string ServedRobot::topic_of(const SensorInfo& sensor) const {
  if (profile_.link) {
    const auto& topics = profile_.link->topics;
    const auto known = std::ranges::find(topics, sensor.name, &TopicSpec::sensor);
    // transforms are published anyway
    if (known != topics.end() && known->type != tf2_msgs::TFMessage::kType) return name_space_ + known->topic;
  }
  switch (sensor.type) {
    case SensorType::lidar: return name_space_ + "/scan";
    case SensorType::imu: return name_space_ + "/imu";
    case SensorType::odometry: return name_space_ + "/odom";
    case SensorType::battery: return name_space_ + "/battery_state";
    case SensorType::ultrasonic:
      return fmt::format("{}/ultrasonic/{}", name_space_, sensor.name.substr(sensor.name.find('_') + 1));
    case SensorType::camera: return name_space_ + "/camera/image_raw";
  }
  return "";
}

ServedRobot::Outlets ServedRobot::advertise(const SensorInfo& sensor) {
  const int image_depth = in_lockstep_ ? 2 * kImagesAhead : 5;
  Outlets outlets;
  outlets.frame = frame_of(sensor, base_frame_);
  const std::string topic = without_ending(topic_of(sensor), "/compressed");
  outlets.main = node_.advertise(topic, type_name(sensor.type),
                                 {.depth = sensor.type == SensorType::camera ? image_depth : depth_});
  if (sensor.type != SensorType::camera) return outlets;
  outlets.compressed =
      node_.advertise(topic + "/compressed", sensor_msgs::CompressedImage::kType, {.depth = image_depth});
  outlets.info = node_.advertise(folder_of(topic) + "/camera_info", sensor_msgs::CameraInfo::kType, {.depth = depth_});
  if (!profile_.camera->depth) return outlets;
  std::string depth = folder_of(topic) + "/depth/image_raw";
  if (profile_.link) {
    const auto known = std::ranges::find(profile_.link->topics, "depth", &TopicSpec::sensor);
    if (known != profile_.link->topics.end()) depth = name_space_ + known->topic;
  }
  outlets.depth = node_.advertise(depth, sensor_msgs::Image::kType, {.depth = image_depth});
  return outlets;
}

// Commands.

template <Message T>
void ServedRobot::receive(const std::string& topic) {
  (void)node_.subscribe(topic, T::kType, {.depth = 10}, [this](std::span<const std::uint8_t> payload, std::uint64_t) {
    const auto message = decode<T>(payload, kLayout);
    if (!message) return;  // of a sender that does not keep to the type: the robot stops as if it had sent nothing
    const geometry_msgs::Twist* twist = nullptr;
    if constexpr (std::same_as<T, geometry_msgs::Twist>) {
      twist = &*message;
    } else {
      twist = &message->twist;
    }
    Velocity velocity{twist->linear.x, twist->linear.y, twist->angular.z};
    if (!is_finite(velocity)) return;
    if (profile_.kinematics() == Kinematics::differential) velocity.vy = 0.0;  // as such a base does
    constexpr std::size_t kMostCommands = 100;
    const std::scoped_lock lock(bell_.mutex);
    if (commands_.size() < kMostCommands) commands_.push_back(velocity);
    bell_.rung.notify_all();
  });
}

void ServedRobot::drive(Time now) {
  std::optional<Velocity> newest;
  begin_goal();
  {
    const std::scoped_lock lock(bell_.mutex);
    if (!commands_.empty()) newest = commands_.back();
    commands_.clear();
  }
  if (newest) port_.command(*newest, now + watchdog_);
}

void ServedRobot::begin_goal() {
  std::optional<std::pair<std::string, Pose2D>> goal;
  {
    const std::scoped_lock lock(bell_.mutex);
    goal = std::exchange(goal_, std::nullopt);
  }
  if (goal) autonomy_->go_to(goal->first, goal->second);
}

void ServedRobot::step(Time now) {
  begin_goal();
  Velocity velocity;
  {
    const std::scoped_lock lock(bell_.mutex);
    velocity = commands_.front();
    commands_.pop_front();
  }
  port_.command(velocity, now + kControlPeriod);
}

// What is published.

template <Message T>
void ServedRobot::send(std::optional<Node::Handle> outlet, const T& message) {
  node_.publish(*outlet, encode(message, kLayout));
}

void ServedRobot::publish_clock(Time now) {
  if (clock_) send(clock_, rosgraph_msgs::Clock{to_stamp(now)});
}

void ServedRobot::publish() {
  for (const Sample& sample : port_.poll()) {
    newest_[sample.sensor] = sample.received;
    send(sample);
  }
  if (autonomy_ != nullptr) show_autonomy();
  if (world_.now() - diagnosed_ >= kDiagnostics) diagnose();
}

void ServedRobot::diagnose() {
  diagnosed_ = world_.now();
  diagnostic_msgs::DiagnosticArray array{{to_stamp(diagnosed_), ""}, {}};
  const std::string whose = name_space_.empty() ? "" : name_space_.substr(1) + ": ";
  const std::vector<SensorInfo>& sensors = port_.features().sensors;
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    const auto age = newest_[i] ? std::optional<Duration>(diagnosed_ - *newest_[i]) : std::nullopt;
    array.status.push_back(to_status(profile_, whose + sensors[i].name, "", age, patience_with(sensors[i])));
  }
  send(diagnostics_, array);
}

// Maps are large, and plans are drawn for people to look at.
void ServedRobot::show_autonomy() {
  constexpr Duration kOften = 500ms;
  const Time now = world_.now();
  if (map_version_ && now - shown_ < kOften) return;
  shown_ = now;
  const std_msgs::Header header{to_stamp(now), kMapFrame};
  if (std::exchange(map_version_, autonomy_->map_version()) != autonomy_->map_version()) {
    send(map_, to_message(autonomy_->map(), header));
  }
  const std::vector<Vec2> path = autonomy_->path();
  if (path.empty() && !has_plan_) return;
  has_plan_ = !path.empty();
  send(plan_, to_message(path, header));
}

void ServedRobot::send(const Sample& sample) {
  const Outlets& outlets = outlets_[sample.sensor];
  std_msgs::Header header{to_stamp(sample.measured), outlets.frame};
  if (const auto* scan = std::get_if<LaserScan>(&sample.data)) {
    send(outlets.main, to_message(*scan, *profile_.lidar, std::move(header)));
  } else if (const auto* imu = std::get_if<IMUData>(&sample.data)) {
    send(outlets.main, to_message(*imu, *profile_.imu, std::move(header)));
  } else if (const auto* odometry = std::get_if<Odometry>(&sample.data)) {
    header.frame_id = odom_frame_;
    send(outlets.main, to_message(*odometry, base_frame_, std::move(header)));
    send_transforms(sample, *odometry);
  } else if (const auto* battery = std::get_if<BatteryState>(&sample.data)) {
    send(outlets.main, to_message(*battery, std::move(header)));
  } else if (const auto* range = std::get_if<RangeData>(&sample.data)) {
    send(outlets.main, to_message(*range, std::move(header)));
  } else if (const auto* picture = std::get_if<Picture>(&sample.data)) {
    send_picture(outlets, header, *picture);
  }
}

// Images that are not received are neither drawn nor compressed.
void ServedRobot::send_picture(const Outlets& outlets, const std_msgs::Header& header, const Picture& picture) {
  constexpr Duration kPatience = 1s;
  const bool wait = in_lockstep_ && ++pictures_ % kImagesAhead == 0;
  const auto send_image = [&](std::optional<Node::Handle> outlet, auto make) {
    if (!outlet || node_.peers(*outlet) == 0) return;
    send(outlet, make(picture.image(), header));
    if (wait) node_.wait_until_received(*outlet, kPatience);
  };
  send(outlets.info, to_message(profile_.camera->intrinsics(), header));
  send_image(outlets.main, color_message);
  send_image(outlets.compressed, compressed_message);
  send_image(outlets.depth, depth_message);
}

void ServedRobot::send_transforms(const Sample& sample, const Odometry& odometry) {
  tf2_msgs::TFMessage message;
  message.transforms.push_back(to_transform(sample.measured, odom_frame_, base_frame_, odometry.pose));
  if (with_map_ || autonomy_ != nullptr) {
    const Pose2D map_from_odom = with_map_ ? truth_.true_pose() * inverse(odometry.pose) : autonomy_->map_from_odom();
    message.transforms.push_back(to_transform(sample.measured, kMapFrame, odom_frame_, map_from_odom));
  }
  send(transforms_, message);
}

}  // namespace threewe::ros2
