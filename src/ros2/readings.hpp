// Conversions of ROS 2 sensor messages to readings of the contract.
#pragma once

#include <array>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <tl/expected.hpp>

#include "ros2/messages/nav_msgs.hpp"
#include "ros2/messages/sensor_msgs.hpp"
#include "ros2/messages/system_msgs.hpp"
#include "threewe/core/samples.hpp"
#include "threewe/hardware/profile.hpp"
#include "threewe/map/occupancy_grid.hpp"

namespace threewe::ros2 {

/// What one message says, by its sender's clock.
struct Reading {
  SampleData data;
  Time stamp{};            ///< of the message's header; 0 where its sender has no clock
  Duration to_measured{};  ///< from the stamp to what the contract calls `measured`
  Duration to_end{};       ///< from the stamp to when the last of it was measured
};
/// Or what is wrong with it.
using ReadingOrMistake = tl::expected<Reading, std::string>;

/// Of any number of beams, in either direction, over a turn or a part of it, with inf and nan as REP 117 has them: the
/// nearest return within each beam of the profile's, as the contract wants it; beams that it does not reach are
/// invalid.
ReadingOrMistake to_reading(const sensor_msgs::LaserScan& scan, const LidarSpec& spec);
/// What such a scan states that contradicts the profile; empty where nothing does.
std::string contradiction(const sensor_msgs::LaserScan& scan, const LidarSpec& spec);
/// Of a cloud in the lidar's own frame, the nearest point within each beam among those at its height; beams without one
/// are invalid. `base_frame` is the one that is refused, as it says nothing of the lidar's height.
ReadingOrMistake to_reading(const sensor_msgs::PointCloud2& cloud, const LidarSpec& spec, std::string_view base_frame);
/// In the base frame, as it comes: the profile has no pose of the inertial unit.
ReadingOrMistake to_reading(const sensor_msgs::Imu& imu);
/// The pose, and the velocity in the body frame.
ReadingOrMistake to_reading(const nav_msgs::Odometry& odometry);
/// Where the charge is not stated, it follows from the voltage.
ReadingOrMistake to_reading(const sensor_msgs::BatteryState& battery, const BatterySpec& spec);
/// inf is no return, as REP 117 has it; -inf and nan are invalid.
ReadingOrMistake to_reading(const sensor_msgs::Range& range, const UltrasonicSpec& spec);

/// Odometry from the transform odom -> base, and the velocity from one to the next.
class TransformOdometry {
 public:
  TransformOdometry(std::string odom_frame, std::string base_frame)
      : odom_frame_(std::move(odom_frame)), base_frame_(std::move(base_frame)) {}
  /// Whether a message has such a transform.
  bool is_in(const tf2_msgs::TFMessage& message);
  /// That it has not come, and what has instead.
  std::string missing() const;
  /// Nothing where the message has none, or none that is newer.
  std::optional<ReadingOrMistake> to_reading(const tf2_msgs::TFMessage& message);

 private:
  const geometry_msgs::TransformStamped* find(const tf2_msgs::TFMessage& message) const;

  std::string odom_frame_;
  std::string base_frame_;
  std::optional<std::pair<Time, Pose2D>> last_;
  std::set<std::string> others_;  // transforms that have come
};

/// Frames that do not move, as `/tf_static` has them.
class StaticFrames {
 public:
  void add(const tf2_msgs::TFMessage& message);
  /// Where one frame is in another, along the floor; empty where no transforms lead up to it.
  std::optional<Pose2D> pose(std::string_view frame, std::string_view in) const;

 private:
  struct Parent {
    std::string frame;
    Pose2D pose;  // of the child in it
  };
  std::map<std::string, Parent, std::less<>> parents_;  // by the child's name
};
/// How a lidar's pose in the base frame contradicts the profile's; empty where it does not.
std::string mount_contradiction(const Pose2D& base_from_lidar, const LidarSpec& spec);

/// Pictures from a camera's messages: of colours alone, or of colours and depths that were taken at one time.
class PictureMaker {
 public:
  /// `with_depth`: both kinds of image come.
  PictureMaker(const CameraSpec& spec, bool with_depth) : spec_(spec), with_depth_(with_depth) {}
  /// Nothing while the other image is to come. Colours are converted when the image is read.
  std::optional<ReadingOrMistake> add_color(const std::shared_ptr<const sensor_msgs::Image>& image);
  /// Of a JPEG.
  std::optional<ReadingOrMistake> add_compressed(const std::shared_ptr<const sensor_msgs::CompressedImage>& image);
  std::optional<ReadingOrMistake> add_depth(std::shared_ptr<const sensor_msgs::Image> image);

 private:
  struct Color {
    Time stamp{};
    std::function<std::vector<std::uint8_t>()> draw;  // blue, green, red
  };
  std::optional<ReadingOrMistake> match();

  CameraSpec spec_;
  bool with_depth_;
  std::optional<Color> color_;
  std::shared_ptr<const sensor_msgs::Image> depth_;
};

/// A rotation and a translation along the floor; empty where the rotation is none or a number is not finite.
std::optional<Pose2D> to_pose(const geometry_msgs::Transform& transform);
/// The covariance of (x, y, theta), row-major, of one of all six; empty where it is none.
std::optional<std::array<double, 9>> planar_covariance(const std::array<double, 36>& covariance);
/// A map whose cells lie along the axes of its frame, or what is wrong with it.
tl::expected<map::OccupancyGrid, std::string> to_grid(const nav_msgs::OccupancyGrid& message);

/// A stamp as nanoseconds.
Time to_time(const builtin_interfaces::Time& stamp);

}  // namespace threewe::ros2
