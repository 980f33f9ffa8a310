#include "ros2/dds/localization_client.hpp"

#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "ros2/publications.hpp"
#include "ros2/readings.hpp"

namespace threewe::ros2 {
namespace {

constexpr Qos kKept{.reliable = true, .transient_local = true, .depth = 1};
constexpr Qos kTransforms{.reliable = false, .transient_local = false, .depth = 100};

// With a slash before it, as old programs have it, a frame is the same.
bool is_frame(std::string_view frame, std::string_view name) {
  return frame == name || (frame.starts_with('/') && frame.substr(1) == name);
}

}  // namespace

LocalizationClient::LocalizationClient(std::string program, const LinkSpec& link,
                                       const std::optional<Pose2D>& initial_pose, std::function<Time()> robot_time)
    : program_(std::move(program)),
      name_space_(link.name_space),
      map_frame_(link.map_frame),
      odom_frame_(link.odom_frame),
      no_transform_(fmt::format("no transform {} -> {}", map_frame_, odom_frame_)),
      initial_pose_(initial_pose),
      robot_time_(std::move(robot_time)) {}

template <Message T>
void LocalizationClient::subscribe(Node& node, const std::string& topic, const Qos& qos) {
  (void)node.subscribe(name_space_ + topic, T::kType, qos,
                       [this](std::span<const std::uint8_t> payload, std::uint64_t) {
                         if (const auto message = decode<T>(payload, kAnyLayout)) receive(*message);
                       });
}

void LocalizationClient::connect(Node& node) {
  {
    const std::scoped_lock lock(mutex_);
    const std::uint64_t maps = report_.map_version;
    report_ = {};
    report_.map_version = maps;
    map_from_theirs_.reset();
    odom_from_theirs_ = {};
    refused_.clear();
  }
  subscribe<tf2_msgs::TFMessage>(node, "/tf", kTransforms);
  subscribe<nav_msgs::OccupancyGrid>(node, "/map", kKept);
  if (program_ == "amcl") {
    subscribe<geometry_msgs::PoseWithCovarianceStamped>(node, "/amcl_pose", kKept);
  } else {
    subscribe<geometry_msgs::PoseWithCovarianceStamped>(node, "/pose", {});
  }
  initial_.reset();
  if (initial_pose_) {
    initial_ =
        node.advertise(name_space_ + "/initialpose", geometry_msgs::PoseWithCovarianceStamped::kType, {.depth = 1});
  }
}

std::string LocalizationClient::missing(Node& node) {
  step(node);
  const std::scoped_lock lock(mutex_);
  std::vector<std::string> absent;
  if (initial_) absent.push_back(fmt::format("no node takes {}/initialpose", name_space_));
  if (!map_from_theirs_) {
    absent.push_back(fmt::format("{} has come on {}/tf{}", no_transform_, name_space_,
                                 initial_pose_ ? "" : "; it may need an initial_pose"));
  }
  if (!report_.map) {
    absent.push_back(refused_.empty() ? fmt::format("no map has come on {}/map", name_space_)
                                      : fmt::format("{}/map {}", name_space_, refused_));
  }
  return absent.empty() ? "" : fmt::format("localization '{}': {}", program_, fmt::join(absent, "; "));
}

/// Tells it where the robot starts, once there is who takes it: what it said before is about another place.
void LocalizationClient::step(Node& node) {
  if (!initial_ || node.peers(*initial_) == 0) return;
  constexpr double kPositionVariance = 0.25;    // [m^2] as RViz has them
  constexpr double kHeadingVariance = 0.06854;  // [rad^2]
  geometry_msgs::PoseWithCovarianceStamped message;
  message.header.frame_id = map_frame_;  // without a stamp: the newest transforms count
  message.pose.pose.position = {initial_pose_->x, initial_pose_->y, 0.0};
  message.pose.pose.orientation = to_quaternion(initial_pose_->theta);
  message.pose.covariance[0] = message.pose.covariance[7] = kPositionVariance;
  message.pose.covariance[35] = kHeadingVariance;
  node.publish(*std::exchange(initial_, std::nullopt), encode(message, kAnyLayout));
  const std::scoped_lock lock(mutex_);
  map_from_theirs_.reset();
}

void LocalizationClient::place(const Pose2D& odom_from_theirs) {
  const std::scoped_lock lock(mutex_);
  odom_from_theirs_ = odom_from_theirs;
}

backend::ExternalLocalizer::Report LocalizationClient::report() const {
  const std::scoped_lock lock(mutex_);
  Report report = report_;
  if (map_from_theirs_) report.map_from_odom = *map_from_theirs_ * inverse(odom_from_theirs_);
  report.missing = refused_.empty() ? no_transform_ : refused_;
  return report;
}

void LocalizationClient::receive(const tf2_msgs::TFMessage& message) {
  for (const geometry_msgs::TransformStamped& stamped : message.transforms) {
    if (!is_frame(stamped.header.frame_id, map_frame_) || !is_frame(stamped.child_frame_id, odom_frame_)) continue;
    const auto pose = to_pose(stamped.transform);
    if (!pose) continue;
    const Time now = robot_time_();
    const std::scoped_lock lock(mutex_);
    map_from_theirs_ = *pose;
    report_.updated = now;
  }
}

void LocalizationClient::receive(const geometry_msgs::PoseWithCovarianceStamped& message) {
  if (const auto covariance = planar_covariance(message.pose.covariance)) {
    const std::scoped_lock lock(mutex_);
    report_.covariance = *covariance;
  }
}

void LocalizationClient::receive(const nav_msgs::OccupancyGrid& message) {
  auto grid = to_grid(message);
  const std::scoped_lock lock(mutex_);
  refused_ = grid ? "" : grid.error();
  if (!grid) return;
  report_.map = std::make_shared<const map::OccupancyGrid>(std::move(*grid));
  ++report_.map_version;
}

}  // namespace threewe::ros2
