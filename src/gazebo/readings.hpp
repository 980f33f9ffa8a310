// Conversions of Gazebo's sensor messages to readings of the contract.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include <tl/expected.hpp>

#include "gazebo/messages.hpp"
#include "threewe/core/samples.hpp"
#include "threewe/hardware/profile.hpp"

namespace threewe::gazebo {

/// What one message says, by the simulated clock.
struct Reading {
  SampleData data;
  Time stamp{};
};
/// Or what is wrong with it.
using ReadingOrMistake = tl::expected<Reading, std::string>;

/// All beams of one time, as they come: inf is no return, what is nearer than the least is invalid.
ReadingOrMistake to_reading(const msgs::LaserScan& scan, const LidarSpec& spec);
/// The nearest of the beams in the cone of an ultrasonic sensor.
ReadingOrMistake to_reading(const msgs::LaserScan& scan, const UltrasonicSpec& spec);
ReadingOrMistake to_reading(const msgs::Imu& imu);
ReadingOrMistake to_reading(const msgs::Odometry& odometry);

/// Pictures from a camera's messages: of colours alone, or of colours and depths of one time.
class PictureMaker {
 public:
  explicit PictureMaker(const CameraSpec& spec) : spec_(spec) {}
  /// Nothing while the other image of that time is to come. Colours are converted when the picture is looked at.
  std::optional<ReadingOrMistake> add_color(msgs::Image image);
  std::optional<ReadingOrMistake> add_depth(msgs::Image image);

 private:
  std::optional<ReadingOrMistake> match();

  CameraSpec spec_;
  std::shared_ptr<const msgs::Image> color_;
  std::shared_ptr<const msgs::Image> depth_;
};

}  // namespace threewe::gazebo
