#include "gazebo/readings.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include <fmt/format.h>

#include "core/exact.hpp"
#include "hardware/message_readings.hpp"

namespace threewe::gazebo {
namespace {

tl::unexpected<std::string> mistake(std::string what) { return tl::unexpected(std::move(what)); }

// Nearer than the least is -inf, farther than the most inf.
double range_of(double range, double range_min, double range_max) {
  if (std::isnan(range) || range < range_min) return 0.0;
  return std::min(range, range_max);
}

std::optional<std::string> mistake_in(const msgs::Image& image, const CameraSpec& spec, std::size_t bytes) {
  if (!std::cmp_equal(image.width, spec.width) || !std::cmp_equal(image.height, spec.height)) {
    return fmt::format("an image of {} x {}; the profile has {} x {}", image.width, image.height, spec.width,
                       spec.height);
  }
  const std::size_t row = image.width * bytes;
  if (image.step >= row && image.data.size() / image.step >= image.height) return std::nullopt;
  return fmt::format("{} bytes, of {} a row, are no image of {} x {}", image.data.size(), image.step, image.width,
                     image.height);
}

std::vector<std::uint8_t> colors_of(const msgs::Image& image) {
  const bool red_first = image.pixel_format == msgs::PixelFormat::rgb8;
  std::vector<std::uint8_t> colors;
  colors.reserve(std::size_t{3} * image.width * image.height);
  for (std::size_t row = 0; row < image.height; ++row) {
    const std::uint8_t* pixel = image.data.data() + row * image.step;
    for (std::size_t column = 0; column < image.width; ++column, pixel += 3) {
      for (const std::size_t i : {0U, 1U, 2U}) colors.push_back(pixel[red_first ? 2 - i : i]);
    }
  }
  return colors;
}

std::vector<float> depths_of(const msgs::Image& image, const DepthSpec& spec) {
  std::vector<float> depths;
  depths.reserve(std::size_t{image.width} * image.height);
  for (std::size_t row = 0; row < image.height; ++row) {
    const std::uint8_t* pixel = image.data.data() + row * image.step;
    for (std::size_t column = 0; column < image.width; ++column, pixel += sizeof(float)) {
      float depth = 0.0F;
      std::memcpy(&depth, pixel, sizeof depth);
      const bool measured = depth >= static_cast<float>(spec.range_min) && depth <= static_cast<float>(spec.range_max);
      depths.push_back(measured ? depth : 0.0F);
    }
  }
  return depths;
}

}  // namespace

ReadingOrMistake to_reading(const msgs::LaserScan& scan, const LidarSpec& spec) {
  const auto beams = static_cast<std::size_t>(spec.beams);
  if (scan.ranges.size() != beams) {
    return mistake(fmt::format("a scan of {} beams; the profile has {}", scan.ranges.size(), beams));
  }
  const double increment = 2.0 * exact::kPi / spec.beams;
  if (!(std::abs(scan.angle_step - increment) < 0.02 * increment) || !(std::abs(scan.angle_min) < exact::kPi + 1e-6)) {
    return mistake(fmt::format("a scan from {} rad by {} rad; {} beams of one turn are {} rad apart", scan.angle_min,
                               scan.angle_step, beams, increment));
  }
  LaserScan turn{.angle_min = scan.angle_min,
                 .angle_increment = increment,
                 .time_increment = 0.0,
                 .range_min = spec.range_min,
                 .range_max = spec.range_max,
                 .ranges = {}};
  turn.ranges.reserve(beams);
  for (const double range : scan.ranges) {
    turn.ranges.push_back(static_cast<float>(range_of(range, spec.range_min, spec.range_max)));
  }
  return Reading{std::move(turn), to_time(scan.header.stamp)};
}

ReadingOrMistake to_reading(const msgs::LaserScan& scan, const UltrasonicSpec& spec) {
  if (scan.ranges.empty()) return mistake("a scan without beams");
  double nearest = spec.range_max;
  for (const double range : scan.ranges) nearest = std::min(nearest, range_of(range, spec.range_min, spec.range_max));
  return Reading{RangeData{spec.field_of_view, spec.range_min, spec.range_max, nearest}, to_time(scan.header.stamp)};
}

ReadingOrMistake to_reading(const msgs::Imu& imu) {
  return imu_data_of(imu.angular_velocity, imu.linear_acceleration).map([&](const IMUData& data) {
    return Reading{data, to_time(imu.header.stamp)};
  });
}

ReadingOrMistake to_reading(const msgs::Odometry& odometry) {
  return odometry_of(odometry.pose, odometry.twist).map([&](const threewe::Odometry& data) {
    return Reading{data, to_time(odometry.header.stamp)};
  });
}

std::optional<ReadingOrMistake> PictureMaker::add_color(msgs::Image image) {
  if (image.pixel_format != msgs::PixelFormat::rgb8 && image.pixel_format != msgs::PixelFormat::bgr8) {
    return mistake(fmt::format("colours in pixel format {}; known: 3 (RGB_INT8) and 8 (BGR_INT8)",
                               static_cast<int>(image.pixel_format)));
  }
  if (auto wrong = mistake_in(image, spec_, 3)) return mistake(std::move(*wrong));
  color_ = std::make_shared<const msgs::Image>(std::move(image));
  return match();
}

std::optional<ReadingOrMistake> PictureMaker::add_depth(msgs::Image image) {
  if (image.pixel_format != msgs::PixelFormat::float32) {
    return mistake(
        fmt::format("depth in pixel format {}; known: 13 (R_FLOAT32)", static_cast<int>(image.pixel_format)));
  }
  if (auto wrong = mistake_in(image, spec_, sizeof(float))) return mistake(std::move(*wrong));
  depth_ = std::make_shared<const msgs::Image>(std::move(image));
  return match();
}

std::optional<ReadingOrMistake> PictureMaker::match() {
  if (!color_ || (spec_.depth && !depth_)) return std::nullopt;
  const Time stamp = to_time(color_->header.stamp);
  if (depth_ && to_time(depth_->header.stamp) != stamp) return std::nullopt;
  Picture picture([spec = spec_, color = std::exchange(color_, nullptr), depth = std::exchange(depth_, nullptr)] {
    RGBDImage image{spec.intrinsics(), colors_of(*color), {}};
    if (depth) image.depth = depths_of(*depth, *spec.depth);
    return image;
  });
  return Reading{std::move(picture), stamp};
}

}  // namespace threewe::gazebo
