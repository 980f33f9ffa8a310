// Stand-in for a robot with micro-ROS: another process, on another DDS, with the embedded simulator as its body.
//
//   ros2_robot DOMAIN [--profile NAME] [--scene NAME] [--seed N] [--pose X,Y,THETA] [--jazzy] [--camera] [--mute TOPIC]
//              [--turtlebot4] [--linked] [--truth] [--delay S] [--jitter S] [--loss SHARE]
//              [--hash HASH]
//
// With --truth it publishes /ground_truth, for who plays a program that knows where it is: map -> base and map -> odom.
// As a TurtleBot 4 it takes TwistStamped, has its odometry in /tf alone, and sends JPEGs. With --linked its topics,
// types and frames are those of the link of its profile. Each message in either direction takes `delay` +- `jitter`, so
// that some overtake others, or is lost. Its types have no hash, or this one. SIGUSR1 cuts the link, SIGUSR2 mends it.
//
// It takes velocities on /cmd_vel, and stops 200 ms after the last: after it was stamped, by this robot's own clock,
// where it is; one without a stamp is as new as its arrival, as ros2_controllers have it. Once no program drives
// it any more it is put back to where it started. It prints a line when it is ready, and what is true of it when it is
// asked to end.
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <limits>
#include <map>
#include <mutex>
#include <optional>
#include <queue>
#include <random>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>
#include <turbojpeg.h>

#include "node.hpp"
#include "robotPubSubTypes.h"
#include "threewe/backend/registry.hpp"
#include "threewe/scene/truth_view.hpp"

using namespace threewe;
using Clock = std::chrono::steady_clock;

namespace {

constexpr Duration kWatchdog = 200ms;
// Its odometry began long ago, elsewhere; its clock is one that was never set.
constexpr Pose2D kTheirsFromStart{3.0, -2.0, 1.2};
constexpr Time kUptime = 5000s;

std::atomic<bool> g_ended = false;
std::atomic<bool> g_cut = false;

struct Options {
  unsigned domain = 0;
  std::string profile = "3we_standard_v2";
  std::string scene = "office_v2";
  std::string mute;
  std::string hash;  // of all types
  std::uint64_t seed = 0;
  std::optional<Pose2D> pose;
  double delay = 0.0;   // [s]
  double jitter = 0.0;  // [s]
  double loss = 0.0;    // share of the messages
  bool jazzy = false;
  bool camera = false;
  bool turtlebot4 = false;
  bool linked = false;
  bool truth = false;
};

Options parse(int count, char** arguments) {
  Options options;
  options.domain = static_cast<unsigned>(std::stoul(arguments[1]));
  for (int i = 2; i < count; ++i) {
    const std::string_view name = arguments[i];
    if (name == "--jazzy") {
      options.jazzy = true;
    } else if (name == "--turtlebot4") {
      options.turtlebot4 = options.camera = true;
    } else if (name == "--linked") {
      options.linked = options.camera = true;
    } else if (name == "--truth") {
      options.truth = true;
    } else if (name == "--camera") {
      options.camera = true;
    } else if (++i == count) {
      throw std::runtime_error("a value is missing");
    } else if (name == "--profile") {
      options.profile = arguments[i];
    } else if (name == "--scene") {
      options.scene = arguments[i];
    } else if (name == "--seed") {
      options.seed = std::stoull(arguments[i]);
    } else if (name == "--delay") {
      options.delay = std::stod(arguments[i]);
    } else if (name == "--jitter") {
      options.jitter = std::stod(arguments[i]);
    } else if (name == "--loss") {
      options.loss = std::stod(arguments[i]);
    } else if (name == "--pose") {
      Pose2D pose;
      if (std::sscanf(arguments[i], "%lf,%lf,%lf", &pose.x, &pose.y, &pose.theta) != 3) {
        throw std::runtime_error("a pose is X,Y,THETA");
      }
      options.pose = pose;
    } else if (name == "--mute") {
      options.mute = arguments[i];
    } else if (name == "--hash") {
      options.hash = arguments[i];
    } else {
      throw std::runtime_error("unknown option");
    }
  }
  return options;
}

/// A link that delays, loses and reorders messages, in one direction. Any thread may send; one delivers.
class Link {
 public:
  Link(const Options& options, unsigned direction)
      : options_(options), random_(static_cast<unsigned>(options.seed) * 2 + direction) {}
  void send(std::function<void()> deliver) {
    const std::scoped_lock lock(mutex_);
    if (g_cut || std::bernoulli_distribution(options_.loss)(random_)) return;
    const double late = std::uniform_real_distribution(-1.0, 1.0)(random_) * options_.jitter + options_.delay;
    const auto due = Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(late));
    messages_.push({due, std::move(deliver)});
  }
  /// What is due.
  void deliver() {
    for (;;) {
      std::function<void()> next;
      {
        const std::scoped_lock lock(mutex_);
        if (messages_.empty() || messages_.top().due > Clock::now()) return;
        next = messages_.top().deliver;
        messages_.pop();
      }
      if (!g_cut) next();
    }
  }

 private:
  struct Message {
    Clock::time_point due;
    std::function<void()> deliver;
    bool operator<(const Message& other) const { return due > other.due; }
  };
  const Options& options_;
  std::mutex mutex_;
  std::mt19937 random_;
  std::priority_queue<Message> messages_;
};

/// What the base did each time that the link was cut.
class Cuts {
 public:
  /// At each step, with whether the base is commanded to move, and how it truly does.
  void note(bool moving, const Velocity& truth) {
    constexpr double kStill = 0.02;         // [m/s]
    constexpr double kStillTurning = 0.05;  // [rad/s]
    const bool rolling = norm({truth.vx, truth.vy}) > kStill || std::abs(truth.omega) > kStillTurning;
    const auto now = Clock::now();
    const bool cut = g_cut;
    if (cut && !was_cut_) cuts_.push_back({now});
    if (!cut && was_cut_) mended_ = now;
    was_cut_ = cut;
    if (cuts_.empty()) return;
    if (cut && moving) cuts_.back().last_moving = now;
    if (cut && rolling) cuts_.back().last_rolling = now;
    if (!cut && moving && now - mended_ < kUntouched) cuts_.back().started = true;
  }
  std::string json() const {
    std::string text;
    for (const Cut& cut : cuts_) {
      const auto since = [&](Clock::time_point last) {
        return std::max(std::chrono::duration<double>(last - cut.begin).count(), 0.0);
      };
      text += fmt::format(R"({}{{"moving_for": {:.4f}, "rolling_for": {:.4f}, "started": {}}})",
                          text.empty() ? "" : ", ", since(cut.last_moving), since(cut.last_rolling), cut.started);
    }
    return "[" + text + "]";
  }

 private:
  static constexpr auto kUntouched = std::chrono::milliseconds(700);  // after it is mended
  struct Cut {
    Clock::time_point begin;
    Clock::time_point last_moving{};
    Clock::time_point last_rolling{};
    bool started = false;
  };
  std::vector<Cut> cuts_;
  Clock::time_point mended_{};
  bool was_cut_ = false;
};

/// The last velocity that came, until the watchdog takes it away.
class Commands : public fast::DataReaderListener {
 public:
  /// `origin` is when the robot's clock showed `kUptime`.
  Commands(Link& link, bool stamped, Clock::time_point origin) : link_(link), stamped_(stamped), origin_(origin) {}
  void on_data_available(fast::DataReader* reader) override {
    geometry_msgs::msg::dds_::TwistStamped_ message;
    geometry_msgs::msg::dds_::Twist_& twist = message.twist();
    fast::SampleInfo info;
    void* const taken = stamped_ ? static_cast<void*>(&message) : static_cast<void*>(&twist);
    while (reader->take_next_sample(taken, &info) == eprosima::fastrtps::types::ReturnCode_t::RETCODE_OK) {
      if (!info.valid_data) continue;
      const auto& stamp = message.header().stamp();
      const Time stamped = std::chrono::seconds(stamp.sec()) + std::chrono::nanoseconds(stamp.nanosec());
      link_.send([this, stamped, velocity = Velocity{twist.linear().x(), twist.linear().y(), twist.angular().z()}] {
        const auto given = stamped == Time::zero() ? Clock::now() : origin_ + (stamped - kUptime);
        if (Clock::now() - given >= kWatchdog) return;
        const std::scoped_lock lock(mutex_);
        velocity_ = velocity;
        given_ = given;
        ++count_;
      });
    }
  }
  void on_subscription_matched(fast::DataReader*, const fast::SubscriptionMatchedStatus& status) override {
    drivers_ = status.current_count;
  }
  Velocity velocity() {
    const std::scoped_lock lock(mutex_);
    return Clock::now() - given_ < kWatchdog ? velocity_ : Velocity{};
  }
  int drivers() const { return drivers_; }
  std::uint64_t count() {
    const std::scoped_lock lock(mutex_);
    return count_;
  }

 private:
  Link& link_;
  bool stamped_;
  Clock::time_point origin_;
  std::mutex mutex_;
  Velocity velocity_;
  Clock::time_point given_{};
  std::uint64_t count_ = 0;
  std::atomic<int> drivers_ = 0;
};

/// The names of the nodes that told of themselves in Humble's layout, with how many endpoints each has.
class Graph : public fast::DataReaderListener {
 public:
  void on_data_available(fast::DataReader* reader) override {
    rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_ info;
    fast::SampleInfo sample;
    while (reader->take_next_sample(&info, &sample) == eprosima::fastrtps::types::ReturnCode_t::RETCODE_OK) {
      if (!sample.valid_data) continue;
      const std::scoped_lock lock(mutex_);
      for (const auto& node : info.node_entities_info_seq()) {
        nodes_[std::string(node.node_namespace().c_str()) + node.node_name().c_str()] =
            node.reader_gid_seq().size() + node.writer_gid_seq().size();
      }
    }
  }
  std::string json() {
    const std::scoped_lock lock(mutex_);
    std::string text;
    for (const auto& [name, endpoints] : nodes_) {
      text += (text.empty() ? "\"" : ", \"") + name + "\": " + std::to_string(endpoints);
    }
    return "{" + text + "}";
  }

 private:
  std::mutex mutex_;
  std::map<std::string, std::size_t> nodes_;
};

std_msgs::msg::dds_::Header_ header(Time stamp, const std::string& frame) {
  const auto nanoseconds = (stamp + kUptime).count();
  std_msgs::msg::dds_::Header_ header;
  header.stamp().sec(static_cast<std::int32_t>(nanoseconds / 1'000'000'000));
  header.stamp().nanosec(static_cast<std::uint32_t>(nanoseconds % 1'000'000'000));
  header.frame_id(frame);
  return header;
}

// inf for no return and nan for no measurement, as REP 117 has them.
float as_rep_117(double range, double range_max) {
  if (range == 0.0) return std::numeric_limits<float>::quiet_NaN();
  return range >= range_max ? std::numeric_limits<float>::infinity() : static_cast<float>(range);
}

/// Publishes where the robot is, and what its odometry would have to be corrected by.
class Truth {
 public:
  explicit Truth(Node& node)
      : writer_(node.advertise<tf2_msgs::msg::dds_::TFMessage_PubSubType>("/ground_truth",
                                                                          "tf2_msgs::msg::dds_::TFMessage_", true)) {}
  void publish(const Pose2D& map_from_base, const Pose2D& odometry) {
    tf2_msgs::msg::dds_::TFMessage_ message;
    const auto add = [&](const std::string& child, const Pose2D& pose) {
      auto& added = message.transforms().emplace_back();
      added.header().frame_id("map");
      added.child_frame_id(child);
      added.transform().translation().x(pose.x);
      added.transform().translation().y(pose.y);
      added.transform().rotation().z(std::sin(0.5 * pose.theta));
      added.transform().rotation().w(std::cos(0.5 * pose.theta));
    };
    add("base_link", map_from_base);
    add("odom", map_from_base * inverse(kTheirsFromStart * odometry));
    writer_->write(&message);
  }

 private:
  fast::DataWriter* writer_;
};

/// Publishes what the simulated sensors deliver.
class Publications {
 public:
  Publications(Node& node, const backend::Features& features, const Options& options, const LinkSpec* link)
      : jazzy_(options.jazzy), in_tf_(options.turtlebot4), jpegs_(options.turtlebot4) {
    if (link != nullptr) frames_ = {link->odom_frame, link->base_frame};
    const std::string type = "sensor_msgs::msg::dds_::";
    for (const SensorInfo& sensor : features.sensors) {
      using namespace sensor_msgs::msg::dds_;
      fast::DataWriter* writer = nullptr;
      const TopicSpec* linked = nullptr;
      for (std::size_t i = 0; link != nullptr && i < link->topics.size(); ++i) {
        if (link->topics[i].sensor == sensor.name) linked = &link->topics[i];
      }
      const std::string topic = linked != nullptr ? linked->topic : topic_of(sensor);
      if (linked != nullptr && sensor.type == SensorType::odometry) in_tf_ = linked->type.starts_with("tf2_msgs/");
      if (linked != nullptr && sensor.type == SensorType::camera) jpegs_ = linked->type.ends_with("CompressedImage");
      if ((link == nullptr || linked != nullptr) && topic != options.mute &&
          (options.camera || sensor.type != SensorType::camera)) {
        switch (sensor.type) {
          case SensorType::lidar: writer = node.advertise<LaserScan_PubSubType>(topic, type + "LaserScan_"); break;
          case SensorType::imu: writer = node.advertise<Imu_PubSubType>(topic, type + "Imu_"); break;
          case SensorType::odometry:
            if (in_tf_) {
              writer =
                  node.advertise<tf2_msgs::msg::dds_::TFMessage_PubSubType>("/tf", "tf2_msgs::msg::dds_::TFMessage_");
              break;
            }
            writer = node.advertise<nav_msgs::msg::dds_::Odometry_PubSubType>(topic, "nav_msgs::msg::dds_::Odometry_");
            break;
          case SensorType::battery:
            writer = node.advertise<BatteryState_PubSubType>(topic, type + "BatteryState_");
            break;
          case SensorType::ultrasonic:
            writer = jazzy_ ? node.advertise<RangeWithVariance_PubSubType>(topic, type + "Range_")
                            : node.advertise<Range_PubSubType>(topic, type + "Range_");
            break;
          case SensorType::camera:
            writer = jpegs_ ? node.advertise<CompressedImage_PubSubType>(
                                  topic + (linked == nullptr ? "/compressed" : ""), type + "CompressedImage_")
                            : node.advertise<Image_PubSubType>(topic, type + "Image_");
            break;
        }
      }
      writers_.push_back(writer);
    }
  }
  void publish(const Sample& sample) {
    fast::DataWriter* writer = writers_[sample.sensor];
    if (writer == nullptr) return;
    std::visit([&](const auto& data) { send(*writer, sample.measured, data); }, sample.data);
  }

 private:
  static std::string topic_of(const SensorInfo& sensor) {
    switch (sensor.type) {
      case SensorType::lidar: return "/scan";
      case SensorType::imu: return "/imu";
      case SensorType::odometry: return "/odom";
      case SensorType::battery: return "/battery_state";
      case SensorType::ultrasonic: return "/ultrasonic/" + sensor.name.substr(std::string_view("ultrasonic_").size());
      case SensorType::camera: return "/camera/image_raw";
    }
    return "";
  }

  /// The turn of a device that turns clockwise, as it measures: from beam to beam the angle falls.
  static void send(fast::DataWriter& writer, Time measured, const LaserScan& scan) {
    sensor_msgs::msg::dds_::LaserScan_ message;
    const std::size_t count = scan.ranges.size();
    const auto last = static_cast<double>(count - 1);
    message.header(header(measured + from_seconds(last * scan.time_increment), "lidar"));
    message.angle_min(static_cast<float>(scan.angle_min + last * scan.angle_increment));
    message.angle_max(static_cast<float>(scan.angle_min));
    message.angle_increment(static_cast<float>(-scan.angle_increment));
    message.time_increment(static_cast<float>(-scan.time_increment));
    message.scan_time(static_cast<float>(-scan.time_increment * static_cast<double>(count)));
    message.range_min(static_cast<float>(scan.range_min));
    message.range_max(static_cast<float>(scan.range_max));
    for (std::size_t i = count; i-- > 0;) {
      message.ranges().push_back(as_rep_117(static_cast<double>(scan.ranges[i]), scan.range_max));
    }
    writer.write(&message);
  }
  static void send(fast::DataWriter& writer, Time measured, const IMUData& imu) {
    sensor_msgs::msg::dds_::Imu_ message;
    message.header(header(measured, "imu"));
    message.orientation_covariance()[0] = -1.0;  // not measured
    message.angular_velocity().x(imu.angular_velocity[0]);
    message.angular_velocity().y(imu.angular_velocity[1]);
    message.angular_velocity().z(imu.angular_velocity[2]);
    message.linear_acceleration().x(imu.linear_acceleration[0]);
    message.linear_acceleration().y(imu.linear_acceleration[1]);
    message.linear_acceleration().z(imu.linear_acceleration[2]);
    writer.write(&message);
  }
  void send(fast::DataWriter& writer, Time measured, const Odometry& odometry) const {
    if (in_tf_) return send_transform(writer, measured, kTheirsFromStart * odometry.pose);
    nav_msgs::msg::dds_::Odometry_ message;
    message.header(header(measured, frames_.first));
    message.child_frame_id(frames_.second);
    const Pose2D pose = kTheirsFromStart * odometry.pose;
    message.pose().pose().position().x(pose.x);
    message.pose().pose().position().y(pose.y);
    message.pose().pose().orientation().z(std::sin(0.5 * pose.theta));
    message.pose().pose().orientation().w(std::cos(0.5 * pose.theta));
    message.twist().twist().linear().x(odometry.velocity.vx);
    message.twist().twist().linear().y(odometry.velocity.vy);
    message.twist().twist().angular().z(odometry.velocity.omega);
    writer.write(&message);
  }
  static void send(fast::DataWriter& writer, Time measured, const BatteryState& battery) {
    sensor_msgs::msg::dds_::BatteryState_ message;
    message.header(header(measured, ""));
    message.voltage(static_cast<float>(battery.voltage));
    message.current(static_cast<float>(-battery.current));
    message.percentage(static_cast<float>(battery.charge));
    message.present(true);
    writer.write(&message);
  }
  void send(fast::DataWriter& writer, Time measured, const RangeData& range) const {
    const auto fill = [&](auto message) {
      message.header(header(measured, "ultrasonic"));
      message.field_of_view(static_cast<float>(range.field_of_view));
      message.min_range(static_cast<float>(range.range_min));
      message.max_range(static_cast<float>(range.range_max));
      message.range(as_rep_117(range.range, range.range_max));
      writer.write(&message);
    };
    if (jazzy_) return fill(sensor_msgs::msg::dds_::RangeWithVariance_());
    fill(sensor_msgs::msg::dds_::Range_());
  }
  /// After that of a wheel, as transforms of all kinds come together.
  void send_transform(fast::DataWriter& writer, Time measured, const Pose2D& pose) const {
    tf2_msgs::msg::dds_::TFMessage_ message;
    message.transforms().resize(2);
    message.transforms()[0].header(header(measured, "base_link"));
    message.transforms()[0].child_frame_id("left_wheel");
    message.transforms()[0].transform().rotation().w(1.0);
    auto& odometry = message.transforms()[1];
    odometry.header(header(measured, frames_.first));
    odometry.child_frame_id(frames_.second);
    odometry.transform().translation().x(pose.x);
    odometry.transform().translation().y(pose.y);
    odometry.transform().rotation().z(std::sin(0.5 * pose.theta));
    odometry.transform().rotation().w(std::cos(0.5 * pose.theta));
    writer.write(&message);
  }
  static void send_jpeg(fast::DataWriter& writer, Time measured, const RGBDImage& image) {
    unsigned char* data = nullptr;
    unsigned long size = 0;
    const tjhandle compressor = tjInitCompress();
    const auto [width, height] = std::pair(image.intrinsics.width, image.intrinsics.height);
    tjCompress2(compressor, image.color.data(), width, 3 * width, height, TJPF_BGR, &data, &size, TJSAMP_444, 95, 0);
    sensor_msgs::msg::dds_::CompressedImage_ message;
    message.header(header(measured, "camera"));
    message.format("jpeg");
    message.data().assign(data, data + size);
    tjFree(data);
    tjDestroy(compressor);
    writer.write(&message);
  }
  void send(fast::DataWriter& writer, Time measured, const Picture& picture) const {
    const RGBDImage& image = picture.image();
    if (jpegs_) return send_jpeg(writer, measured, image);
    sensor_msgs::msg::dds_::Image_ message;
    message.header(header(measured, "camera"));
    message.height(static_cast<std::uint32_t>(image.intrinsics.height));
    message.width(static_cast<std::uint32_t>(image.intrinsics.width));
    message.step(3 * message.width());
    message.encoding("rgb8");
    message.data().resize(image.color.size());
    for (std::size_t i = 0; i < image.color.size(); i += 3) {
      for (std::size_t k = 0; k < 3; ++k) message.data()[i + k] = image.color[i + 2 - k];
    }
    writer.write(&message);
  }

  bool jazzy_;
  bool in_tf_;  // odometry
  bool jpegs_;
  std::pair<std::string, std::string> frames_{"odom", "base_link"};
  std::vector<fast::DataWriter*> writers_;  // null for one that is mute
};

void run(const Options& options) {
  backend::WorldOptions world_options;
  world_options.scene = options.scene;
  world_options.robots = {options.profile};
  world_options.seed = options.seed;
  if (options.pose) world_options.poses = {*options.pose};
  const auto world = backend::make_world("mock", world_options);
  const scene::TruthView& truth = world->truth_service()->truth(0);
  backend::RobotPort& port = world->robot(0);
  port.connect();

  Node node(options.domain, options.hash.empty() ? "" : "typehash=" + options.hash + ";");
  const LinkSpec* link = options.linked ? &port.profile().link.value() : nullptr;
  Publications publications(node, port.features(), options, link);
  Link inbound(options, 0);
  Link outbound(options, 1);
  const bool stamped = link != nullptr ? link->command.type.ends_with("Stamped") : options.turtlebot4;
  const std::string topic = link != nullptr ? link->command.topic : "/cmd_vel";
  const auto origin = Clock::now();
  Commands commands(inbound, stamped, origin);
  Cuts cuts;
  using namespace geometry_msgs::msg::dds_;
  if (stamped) {
    node.subscribe<TwistStamped_PubSubType>(topic, "geometry_msgs::msg::dds_::TwistStamped_", commands);
  } else {
    node.subscribe<Twist_PubSubType>(topic, "geometry_msgs::msg::dds_::Twist_", commands);
  }
  Graph graph;
  node.join_graph<rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_PubSubType>(
      "ros_discovery_info", "rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_", graph);
  std::optional<Truth> known;
  if (options.truth) known.emplace(node);
  std::puts("ready");
  std::fflush(stdout);

  bool driven = false;
  while (!g_ended) {
    const Time next = world->now() + kControlPeriod / 4;  // 5 ms, as readings of 100 Hz should not come in pairs
    std::this_thread::sleep_until(origin + next);
    inbound.deliver();
    const Velocity velocity = commands.velocity();
    cuts.note(velocity != Velocity{}, truth.true_velocity());
    port.command(velocity, next + kControlPeriod);
    world->advance_to(next);
    for (Sample& sample : port.poll()) {
      const auto* odometry = std::get_if<Odometry>(&sample.data);
      if (known && odometry != nullptr) known->publish(truth.true_pose(), odometry->pose);
      outbound.send([&publications, message = std::move(sample)] { publications.publish(message); });
    }
    outbound.deliver();
    if (std::exchange(driven, commands.drivers() > 0) && !driven) world->teleport(0, truth.start_pose());
  }
  const Pose2D pose = inverse(truth.start_pose()) * truth.true_pose();
  std::printf(
      R"({"pose": [%.4f, %.4f, %.4f], "max_collision_speed": %.4f, "commands": %llu, "speed": %.4f, "nodes": %s, "cuts": %s})"
      "\n",
      pose.x, pose.y, pose.theta, truth.max_collision_speed(), static_cast<unsigned long long>(commands.count()),
      norm({truth.true_velocity().vx, truth.true_velocity().vy}), graph.json().c_str(), cuts.json().c_str());
}

}  // namespace

int main(int count, char** arguments) {
  if (count < 2) {
    std::fputs(
        "usage: ros2_robot DOMAIN [--profile NAME] [--scene NAME] [--seed N] [--pose X,Y,THETA] [--jazzy] [--camera]\n"
        "                  [--turtlebot4] [--linked] [--truth] [--mute TOPIC] [--delay S] [--jitter S] [--loss "
        "SHARE] [--hash HASH]\n",
        stderr);
    return 2;
  }
  std::signal(SIGTERM, [](int) { g_ended = true; });
  std::signal(SIGUSR1, [](int) { g_cut = true; });
  std::signal(SIGUSR2, [](int) { g_cut = false; });
  std::signal(SIGINT, [](int) { g_ended = true; });
  try {
    run(parse(count, arguments));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "ros2_robot: %s\n", error.what());
    return 1;
  }
  return 0;
}
