#include "ros2/dds/real_robot.hpp"

#include <algorithm>
#include <fstream>
#include <set>
#include <string>
#include <thread>
#include <type_traits>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <pthread.h>
#include <sched.h>

#include "core/names.hpp"
#include "hardware/sample_checks.hpp"
#include "ros2/diagnosis.hpp"
#include "ros2/network_interfaces.hpp"
#include "ros2/publications.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::ros2 {
namespace {

using Call = backend::PluginRequest::Call;

constexpr Duration kReach = 10s;  // for discovery, and for the first reading of each sensor that has several a second
constexpr Duration kReachMap = 20s;  // with a map, which a link that loses packets may need several times
// Of Fast DDS before 2.14.5, where it is the one that begins.
constexpr const char* kUnreadableKey =
    "\n  security: another node has begun by a key in a form that Cyclone DDS does not read, as older ones on Fast DDS "
    "do: "
    "make this enclave anew under another name, until it is this side that begins";
constexpr int kStepsToRefresh = 50;   // about once a second
constexpr std::size_t kManyLost = 3;  // images of a connection
constexpr int kLastWords = 3;         // commands to stand, as one may be lost
constexpr int kDepth = 5;             // samples kept that have not been taken yet

// Sensors that deliver in less than this have delivered once they are connected.
constexpr double kQuick = 2.0;  // [Hz]

double rate_of(SensorType type, const RobotProfile& profile) {
  switch (type) {
    case SensorType::lidar: return 1.0 / to_seconds(profile.lidar->turn);
    case SensorType::imu: return 1.0 / to_seconds(profile.imu->period);
    case SensorType::odometry: return 1.0 / to_seconds(profile.odometry.period);
    case SensorType::battery: return 1.0 / to_seconds(profile.battery->period);
    case SensorType::ultrasonic: return 1.0 / to_seconds(profile.ultrasonics->period());
    case SensorType::camera: return 1.0 / to_seconds(profile.camera->period);
  }
  return 0.0;
}

SensorType type_of(std::string_view sensor) {
  for (const SensorType type :
       {SensorType::lidar, SensorType::imu, SensorType::odometry, SensorType::battery, SensorType::camera}) {
    if (sensor == to_string(type)) return type;
  }
  return sensor == "depth" ? SensorType::camera : SensorType::ultrasonic;
}

template <Message T>
tl::expected<T, std::string> decode_any(std::span<const std::uint8_t> payload) {
  auto newest = decode<T>(payload, kDistributions.back());
  if (newest) return newest;
  auto oldest = decode<T>(payload, kDistributions.front());  // the layouts differ in length: one of them fits
  return oldest ? oldest : newest;
}

// [bytes] that the kernel grants to a socket; 0 where it does not say.
std::size_t most_receive_buffer() {
  std::size_t most = 0;
  std::ifstream("/proc/sys/net/core/rmem_max") >> most;
  return most;
}

// This thread comes before all that are not of real time; nothing changes where the system does not permit it.
void set_priority(int priority) {
  const sched_param wanted{.sched_priority = ::sched_get_priority_min(SCHED_FIFO) + priority};
  (void)::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &wanted);
}

}  // namespace

backend::Features features_of(const RobotProfile& profile) {
  if (!profile.link) {
    throw ConfigError(
        fmt::format("robot '{}' has no link: a real robot needs a `link:` section in its profile, with the "
                    "topics of its sensors",
                    profile.name));
  }
  backend::Features features;
  features.kinematics = profile.kinematics();
  for (const TopicSpec& topic : profile.link->topics) {
    if (topic.sensor == "depth") continue;  // comes with the camera's pictures
    const SensorType type = type_of(topic.sensor);
    features.sensors.push_back({topic.sensor, type, rate_of(type, profile)});
  }
  return features;
}

RealRobot::RealRobot(std::shared_ptr<backend::PluginLink> mailbox, Discovery discovery)
    : mailbox_(std::move(mailbox)),
      discovery_(std::move(discovery)),
      profile_(mailbox_->profile()),
      link_(*profile_.link),
      clock_(mailbox_->features().sensors.size()),
      transforms_(link_.odom_frame, link_.base_frame) {}

backend::ExternalLocalizer& RealRobot::delegate_localization(std::string_view program,
                                                             const std::optional<Pose2D>& map_from_start) {
  const std::vector<std::string> known(kLocalizationPrograms.begin(), kLocalizationPrograms.end());
  if (std::ranges::find(known, program) == known.end()) throw ConfigError(unknown_name("localization", program, known));
  localization_ = std::make_unique<LocalizationClient>(std::string(program), link_, map_from_start,
                                                       [this] { return mailbox_->robot_time(); });
  return *localization_;
}

backend::ExternalNavigator& RealRobot::delegate_navigation(std::string_view program) {
  const std::vector<std::string> known{"nav2"};
  if (program != known.front()) throw ConfigError(unknown_name("navigation", program, known));
  navigation_ = std::make_unique<NavigationClient>(link_);
  return *navigation_;
}

void RealRobot::run() {
  while (const auto request = mailbox_->take()) {
    try {
      if (request->call == Call::connect) connect();
      if (request->call == Call::step) send(request->velocity);
      if (request->call == Call::disconnect) disconnect();
      mailbox_->answer({});
    } catch (const std::exception& error) {
      mailbox_->fail(error.what());
    }
  }
}

// Connecting.

void RealRobot::connect() {
  set_priority(0);  // which the threads of Cyclone DDS inherit: what a sensor says should not wait, either
  const auto& sensors = mailbox_->features().sensors;
  clock_ = StampClock(sensors.size());
  transforms_ = {link_.odom_frame, link_.base_frame};
  static_frames_ = {};
  odom_from_theirs_.reset();
  odom_from_base_ = {};
  command_topic_ = link_.command;
  command_.reset();
  sources_.clear();
  for (const TopicSpec& topic : link_.topics) {
    const std::string_view name = topic.sensor == "depth" ? to_string(SensorType::camera) : topic.sensor;
    const auto sensor = std::ranges::find(sensors, name, &SensorInfo::name);
    Source& source = sources_.emplace_back();
    source.topic = topic;
    source.sensor = static_cast<std::size_t>(sensor - sensors.begin());
  }
  if (profile_.camera) {
    const bool with_depth = std::ranges::find(link_.topics, "depth", &TopicSpec::sensor) != link_.topics.end();
    pictures_.emplace(*profile_.camera, with_depth);
  }

  try {
    begun_ = Clock::now();
    node_ = std::make_unique<Node>(discovery_, "/", "threewe");
    diagnostics_ = node_->advertise("/diagnostics", diagnostic_msgs::DiagnosticArray::kType, {});
    for (std::size_t i = 0; i < sources_.size(); ++i) subscribe(i);
    subscribe_to_static_frames();
    if (localization_) localization_->connect(*node_);
    if (navigation_) navigation_->connect(*node_);
    wait_until_reached();
    set_priority(1);  // commands are due 50 times a second, whatever else the computer does
  } catch (...) {
    node_.reset();
    throw;
  }
}

void RealRobot::subscribe(std::size_t source) {
  const TopicSpec& topic = sources_[source].topic;
  const Qos qos{.reliable = topic.reliable, .transient_local = false, .depth = kDepth};
  auto receiver = [this, source](std::span<const std::uint8_t> payload, std::uint64_t publisher) {
    receive(source, payload, publisher);
  };
  const Node::Handle handle = node_->subscribe(topic.topic, topic.type, qos, std::move(receiver));
  const std::scoped_lock lock(mutex_);
  sources_[source].handle = handle;
}

/// In the namespace of the scans, if there is one.
void RealRobot::subscribe_to_static_frames() {
  const auto scans = std::ranges::find(link_.topics, sensor_msgs::LaserScan::kType, &TopicSpec::type);
  if (scans == link_.topics.end()) return;
  const std::string name_space = scans->topic.substr(0, scans->topic.rfind('/'));
  constexpr int kPublishers = 100;  // each keeps its own
  for (const std::string& topic : std::set<std::string>{"/tf_static", name_space + "/tf_static"}) {
    node_->subscribe(topic, tf2_msgs::TFMessage::kType,
                     {.reliable = true, .transient_local = true, .depth = kPublishers},
                     [this](std::span<const std::uint8_t> payload, std::uint64_t) {
                       const std::scoped_lock lock(mutex_);
                       if (const auto message = decode_any<tf2_msgs::TFMessage>(payload)) static_frames_.add(*message);
                     });
  }
}

/// Waits until every topic has its other end and the quick sensors have delivered.
void RealRobot::wait_until_reached() {
  const auto give_up = Clock::now() + (localization_ ? kReachMap : kReach);
  for (;;) {
    const std::string still = missing();
    if (still.empty()) return;
    if (Clock::now() > give_up) {
      throw ConnectionError(discovery_.enclave && received_unreadable_key() ? still + kUnreadableKey : still);
    }
    std::this_thread::sleep_for(kControlPeriod);
  }
}

/// What of the link is not there; empty where all of it is.
std::string RealRobot::missing() {
  const std::vector<Endpoint> endpoints = node_->endpoints();
  if (endpoints.empty()) return silence();
  std::vector<std::string> absent{missing_command(endpoints)};
  for (const Source& source : sources()) absent.push_back(missing_readings(source, endpoints));
  if (localization_) absent.push_back(localization_->missing(*node_));
  if (navigation_) absent.push_back(navigation_->missing(*node_));
  std::erase(absent, "");
  if (absent.empty()) return "";
  return fmt::format("the robot cannot be reached:\n  {}", fmt::join(absent, "\n  "));
}

std::string RealRobot::silence() {
  const auto lasted = std::chrono::duration_cast<Duration>(Clock::now() - begun_);
  return diagnose_silence(discovery_, {lasted, node_->participants(), network_interfaces()});
}

std::string RealRobot::missing_command(const std::vector<Endpoint>& endpoints) {
  if (!command_) {
    command_topic_.type = command_type(link_.command, endpoints);
    if (std::string mistake = diagnose(command_topic_, true, endpoints); !mistake.empty()) return mistake;
    command_ = node_->advertise(command_topic_.topic, command_topic_.type, {.reliable = command_topic_.reliable});
  }
  std::string mistake = mistake_in_command(endpoints);
  if (!mistake.empty() || node_->peers(*command_) > 0) return mistake;
  return fmt::format("command: {} does not answer", command_topic_.topic);
}

std::string RealRobot::missing_readings(const Source& source, const std::vector<Endpoint>& endpoints) {
  const auto& [sensor, topic, type, reliable] = source.topic;
  if (std::string mistake = mistake_in(source, endpoints); !mistake.empty()) return mistake;
  if (node_->peers(source.handle) == 0) return fmt::format("{}: {} does not answer", sensor, topic);
  if (source.delivered || mailbox_->features().sensors[source.sensor].rate < kQuick) return "";
  if (!source.mistake.empty()) return fmt::format("{}: {} delivers {}", sensor, topic, source.mistake);
  if (type == tf2_msgs::TFMessage::kType) {
    const std::scoped_lock lock(mutex_);
    return fmt::format("{}: {} has {}", sensor, topic, transforms_.missing());
  }
  std::string what = fmt::format("{}: nothing has come on {}", sensor, topic);
  if (type == sensor_msgs::Image::kType && node_->lost(source.handle) > 0) {
    what += fmt::format(": images are lost: {}", explain_lost_images(most_receive_buffer()));
  }
  return what;
}

// What the graph shows of the robot that should not be so, while it is connected, too.

std::string RealRobot::mistake_in_command(const std::vector<Endpoint>& endpoints) const {
  if (std::string mistake = diagnose(command_topic_, true, endpoints); !mistake.empty()) return mistake;
  const bool shared = link_.shared_command || navigation_;  // then other nodes of Nav2 publish it as well
  return shared ? "" : diagnose_drivers(command_topic_, endpoints);
}

std::string RealRobot::mistake_in(const Source& source, const std::vector<Endpoint>& endpoints) const {
  if (source.rival && mailbox_->robot_time() - *source.rival < patience(source)) {
    return diagnose_rivals(source.topic, endpoints);
  }
  return diagnose(source.topic, false, endpoints);
}

std::vector<RealRobot::Source> RealRobot::sources() {
  const std::scoped_lock lock(mutex_);
  return sources_;
}

void RealRobot::disconnect() {
  if (!node_) return;
  if (navigation_) navigation_->release(*node_);
  for (int i = 0; i < kLastWords; ++i) {
    send({});
    std::this_thread::sleep_for(kControlPeriod);
  }
  node_.reset();
}

// Commands.

void RealRobot::send(const Velocity& velocity) {
  if (++steps_ % kStepsToRefresh == 0) {
    node_->refresh();
    watch();
  }
  if (localization_) localization_->step(*node_);
  if (navigation_) navigation_->step(*node_);
  if (navigation_ && navigation_->drives()) return;  // two that command one robot would take turns
  geometry_msgs::Twist twist;
  twist.linear = {velocity.vx, velocity.vy, 0.0};
  twist.angular.z = velocity.omega;
  if (command_topic_.type == geometry_msgs::Twist::kType) {
    node_->publish(*command_, encode(twist, kAnyLayout));
  } else {
    geometry_msgs::TwistStamped stamped;
    stamped.header = {robot_stamp(), link_.base_frame};
    stamped.twist = twist;
    node_->publish(*command_, encode(stamped, kAnyLayout));
  }
}

/// Now, by the clock that stamps odometry, which is the one that commands are judged by: that of this computer may be
/// off. Zero, which stands for no stamp, where odometry has none.
builtin_interfaces::Time RealRobot::robot_stamp() {
  const Time now = mailbox_->robot_time();
  const std::scoped_lock lock(mutex_);
  const auto odometry = std::ranges::find_if(
      sources_, [](const Source& source) { return type_of(source.topic.sensor) == SensorType::odometry; });
  return to_stamp(clock_.stamp_at(odometry->sensor, now).value_or(Time::zero()));
}

/// Looks for what no sample shows, and says on /diagnostics how each topic is.
void RealRobot::watch() {
  const std::vector<Endpoint> endpoints = node_->endpoints();
  const Time now = mailbox_->robot_time();
  diagnostic_msgs::DiagnosticArray array{{robot_stamp(), ""}, {}};
  std::vector<std::string> faults{mistake_in_command(endpoints)};
  array.status.push_back(to_status(profile_, "command", faults.front()));
  for (const Source& source : sources()) {
    std::string fault = mistake_in(source, endpoints);
    if (fault.empty()) fault = lost_images(source);
    if (fault.empty() && !source.contradiction.empty()) {
      fault = fmt::format("{}: {}: {}", source.topic.sensor, source.topic.topic, source.contradiction);
    }
    const auto age = source.publisher == 0 ? std::nullopt : std::optional<Duration>(now - source.newest);
    array.status.push_back(to_status(profile_, source.topic.sensor, fault, age, patience(source)));
    faults.push_back(std::move(fault));
  }
  node_->publish(diagnostics_, encode(array, kAnyLayout));
  std::erase(faults, "");
  mailbox_->note_link_fault(endpoints.empty() ? "no ROS 2 node is there any more"
                                              : fmt::format("{}", fmt::join(faults, "; ")));
}

// Those of the first second are lost while both sides find each other.
std::string RealRobot::lost_images(const Source& source) {
  if (source.topic.type != sensor_msgs::Image::kType || node_->lost(source.handle) < kManyLost) return "";
  return fmt::format("{}: images of {} are lost: {}", source.topic.sensor, source.topic.topic,
                     explain_lost_images(most_receive_buffer()));
}

// Readings, in threads of the middleware's.

void RealRobot::receive(std::size_t index, std::span<const std::uint8_t> payload, std::uint64_t publisher) {
  const Time arrival = mailbox_->robot_time();
  const std::scoped_lock lock(mutex_);
  Source& source = sources_[index];
  const bool shared = source.topic.type == tf2_msgs::TFMessage::kType;  // most of its messages do not concern us
  if (!shared && !admit(source, publisher, arrival)) return;
  auto read_of_it = read(source, payload, publisher, arrival);
  if (!read_of_it) return;
  if (!*read_of_it) {
    source.mistake = read_of_it->error();
    return;
  }
  Reading& reading = **read_of_it;
  if (auto* odometry = std::get_if<Odometry>(&reading.data)) place_odometry(*odometry);

  const SensorInfo& sensor = mailbox_->features().sensors[source.sensor];
  try {
    check_data(sensor, reading.data, profile_);
  } catch (const ContractError& error) {
    source.mistake = error.what();
    return;
  }
  const auto measured = clock_.measured(source.sensor, reading.stamp, reading.to_measured, reading.to_end, arrival);
  if (!measured) return;
  for (Source& other : sources_) other.delivered |= other.sensor == source.sensor;  // a picture is of two topics
  mailbox_->push({.sensor = sensor.name, .measured = *measured, .data = std::move(reading.data)});
}

/// Whether a message is one of the publisher's that this sensor has: the first, or the next one once that has been
/// silent, as a node is that was started again. Two at once would be two robots.
bool RealRobot::admit(Source& source, std::uint64_t publisher, Time arrival) {
  if (source.publisher != publisher) {
    if (source.publisher != 0 && arrival - source.newest < patience(source)) {
      source.rival = arrival;
      return false;
    }
    source.publisher = publisher;
    clock_.restart(source.sensor);
    if (source.topic.sensor == "odometry") {
      odom_from_theirs_.reset();
      transforms_ = {link_.odom_frame, link_.base_frame};
    }
  }
  source.newest = arrival;
  return true;
}

Duration RealRobot::patience(const Source& source) const {
  return patience_with(mailbox_->features().sensors[source.sensor]);
}

std::optional<ReadingOrMistake> RealRobot::read(Source& source, std::span<const std::uint8_t> payload,
                                                std::uint64_t publisher, Time arrival) {
  const auto converted = [&]<typename M>(std::type_identity<M>, auto&& convert) -> std::optional<ReadingOrMistake> {
    auto message = decode_any<M>(payload);
    if (!message) return tl::unexpected(std::move(message.error()));
    return convert(std::move(*message));
  };
  using namespace sensor_msgs;
  if (source.topic.type == tf2_msgs::TFMessage::kType) {
    return converted(std::type_identity<tf2_msgs::TFMessage>(),
                     [&](const tf2_msgs::TFMessage& message) -> std::optional<ReadingOrMistake> {
                       if (!transforms_.is_in(message) || !admit(source, publisher, arrival)) return std::nullopt;
                       return transforms_.to_reading(message);
                     });
  }
  if (source.topic.type == CompressedImage::kType) {
    return converted(std::type_identity<CompressedImage>(), [this](CompressedImage image) {
      return pictures_->add_compressed(std::make_shared<const CompressedImage>(std::move(image)));
    });
  }
  if (source.topic.type == PointCloud2::kType) {
    return converted(std::type_identity<PointCloud2>(),
                     [this](const PointCloud2& cloud) { return to_reading(cloud, *profile_.lidar, link_.base_frame); });
  }
  switch (type_of(source.topic.sensor)) {
    case SensorType::lidar:
      return converted(std::type_identity<sensor_msgs::LaserScan>(), [&](const sensor_msgs::LaserScan& scan) {
        source.contradiction = contradiction(scan, *profile_.lidar);
        const auto mount = static_frames_.pose(scan.header.frame_id, link_.base_frame);
        if (source.contradiction.empty() && mount) source.contradiction = mount_contradiction(*mount, *profile_.lidar);
        return to_reading(scan, *profile_.lidar);
      });
    case SensorType::imu: return converted(std::type_identity<Imu>(), [](const Imu& imu) { return to_reading(imu); });
    case SensorType::odometry:
      return converted(std::type_identity<nav_msgs::Odometry>(),
                       [](const nav_msgs::Odometry& odometry) { return to_reading(odometry); });
    case SensorType::battery:
      return converted(std::type_identity<sensor_msgs::BatteryState>(),
                       [this](const auto& battery) { return to_reading(battery, *profile_.battery); });
    case SensorType::ultrasonic:
      return converted(std::type_identity<Range>(),
                       [this](const Range& range) { return to_reading(range, *profile_.ultrasonics); });
    case SensorType::camera:
      return converted(std::type_identity<Image>(), [&](Image image) {
        auto shared = std::make_shared<const Image>(std::move(image));
        return source.topic.sensor == "depth" ? pictures_->add_depth(std::move(shared)) : pictures_->add_color(shared);
      });
  }
  return std::nullopt;
}

/// Odometry begins where the robot stands when it is connected, and goes on from where it was when its sender begins
/// anew.
void RealRobot::place_odometry(Odometry& odometry) {
  if (!odom_from_theirs_) {
    odom_from_theirs_ = odom_from_base_ * inverse(odometry.pose);
    if (localization_) localization_->place(*odom_from_theirs_);
  }
  odometry.pose = odom_from_base_ = *odom_from_theirs_ * odometry.pose;
}

}  // namespace threewe::ros2
