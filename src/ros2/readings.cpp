#include "ros2/readings.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/exact.hpp"
#include "hardware/message_readings.hpp"
#include "ros2/jpeg.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::ros2 {
namespace {

tl::unexpected<std::string> mistake(std::string what) { return tl::unexpected(std::move(what)); }

// What a message of ranges states (REP 117): NaN, -inf and less than the least are no measurement, inf and more than
// the most are no return.
float range_of(double range, double least, double most, double range_min, double range_max) {
  if (std::isnan(range) || range < least || range <= 0.0) return 0.0F;
  if (range > most || range >= range_max) return static_cast<float>(range_max);
  return range < range_min ? 0.0F : static_cast<float>(range);
}

// A frame's name without the slash that old nodes begin it with.
std::string_view plain(std::string_view frame) { return frame.starts_with('/') ? frame.substr(1) : frame; }

}  // namespace

Time to_time(const builtin_interfaces::Time& stamp) {
  return std::chrono::seconds(stamp.sec) + std::chrono::nanoseconds(stamp.nanosec);
}

ReadingOrMistake to_reading(const sensor_msgs::Imu& imu) {
  return imu_data_of(imu.angular_velocity, imu.linear_acceleration).map([&](const IMUData& data) {
    return Reading{data, to_time(imu.header.stamp), {}, {}};
  });
}

ReadingOrMistake to_reading(const nav_msgs::Odometry& odometry) {
  return odometry_of(odometry.pose.pose, odometry.twist.twist).map([&](const Odometry& data) {
    return Reading{data, to_time(odometry.header.stamp), {}, {}};
  });
}

ReadingOrMistake to_reading(const sensor_msgs::BatteryState& battery, const BatterySpec& spec) {
  const auto voltage = static_cast<double>(battery.voltage);
  if (!std::isfinite(voltage)) return mistake("the voltage is not finite");
  BatteryState data{.voltage = voltage};
  // ROS counts what flows in; where it is not measured the reading has none
  if (std::isfinite(battery.current)) data.current = -static_cast<double>(battery.current);
  data.charge = static_cast<double>(battery.percentage);
  if (!std::isfinite(battery.percentage)) {
    const double span = std::max(spec.voltage_full - spec.voltage_empty, 1e-3);
    data.charge = (voltage - spec.voltage_empty) / span;
  }
  data.charge = std::clamp(data.charge, 0.0, 1.0);
  return Reading{data, to_time(battery.header.stamp), {}, {}};
}

ReadingOrMistake to_reading(const sensor_msgs::Range& range, const UltrasonicSpec& spec) {
  const RangeData data{
      spec.field_of_view, spec.range_min, spec.range_max,
      static_cast<double>(range_of(static_cast<double>(range.range), static_cast<double>(range.min_range),
                                   static_cast<double>(range.max_range), spec.range_min, spec.range_max))};
  return Reading{data, to_time(range.header.stamp), {}, {}};
}

const geometry_msgs::TransformStamped* TransformOdometry::find(const tf2_msgs::TFMessage& message) const {
  const auto found = std::ranges::find_if(message.transforms, [&](const geometry_msgs::TransformStamped& transform) {
    return plain(transform.header.frame_id) == odom_frame_ && plain(transform.child_frame_id) == base_frame_;
  });
  return found == message.transforms.end() ? nullptr : &*found;
}

bool TransformOdometry::is_in(const tf2_msgs::TFMessage& message) {
  constexpr std::size_t kMost = 20;
  if (find(message) != nullptr) return true;
  for (const geometry_msgs::TransformStamped& other : message.transforms) {
    if (others_.size() < kMost) others_.insert(fmt::format("{} -> {}", other.header.frame_id, other.child_frame_id));
  }
  return false;
}

std::string TransformOdometry::missing() const {
  return fmt::format("no transform {} -> {}{}{}", odom_frame_, base_frame_, others_.empty() ? "" : "; there is ",
                     fmt::join(others_, ", "));
}

std::optional<ReadingOrMistake> TransformOdometry::to_reading(const tf2_msgs::TFMessage& message) {
  const geometry_msgs::TransformStamped* transform = find(message);
  if (transform == nullptr) return std::nullopt;
  const auto theta = heading_of(transform->transform.rotation);
  if (!theta) return mistake("the rotation is no unit quaternion");
  const Pose2D pose{transform->transform.translation.x, transform->transform.translation.y, *theta};
  if (!is_finite(pose)) return mistake("the translation is not finite");
  const Time stamp = to_time(transform->header.stamp);
  const auto last = std::exchange(last_, std::pair(stamp, pose));
  if (!last || stamp <= last->first) return std::nullopt;  // no velocity yet, or a transform that is said again
  const Pose2D moved = inverse(last->second) * pose;
  const double seconds = to_seconds(stamp - last->first);
  return Reading{Odometry{pose, {moved.x / seconds, moved.y / seconds, moved.theta / seconds}}, stamp, {}, {}};
}

void StaticFrames::add(const tf2_msgs::TFMessage& message) {
  constexpr std::size_t kMost = 200;
  for (const geometry_msgs::TransformStamped& transform : message.transforms) {
    const auto pose = to_pose(transform.transform);
    if (!pose || parents_.size() >= kMost) continue;
    parents_.insert_or_assign(std::string(plain(transform.child_frame_id)),
                              Parent{std::string(plain(transform.header.frame_id)), *pose});
  }
}

std::optional<Pose2D> StaticFrames::pose(std::string_view frame, std::string_view in) const {
  Pose2D pose;
  std::string_view at = plain(frame);
  for (std::size_t i = 0; at != plain(in); ++i) {
    const auto parent = parents_.find(at);
    if (parent == parents_.end() || i == parents_.size()) return std::nullopt;  // no way up, or a circle
    pose = parent->second.pose * pose;
    at = parent->second.frame;
  }
  return pose;
}

std::string mount_contradiction(const Pose2D& base_from_lidar, const LidarSpec& spec) {
  constexpr double kNear = 0.03;                // [m]
  constexpr double kAlike = exact::kPi / 60.0;  // [rad]
  const Pose2D& ours = spec.base_from_lidar;
  if (std::max(std::abs(base_from_lidar.x - ours.x), std::abs(base_from_lidar.y - ours.y)) < kNear &&
      std::abs(wrap_angle(base_from_lidar.theta - ours.theta)) < kAlike) {
    return "";
  }
  const auto words = [](const Pose2D& pose) {
    return fmt::format("({:.3f}, {:.3f}) m, turned by {:.0f} deg", pose.x, pose.y, 180.0 / exact::kPi * pose.theta);
  };
  return fmt::format("by /tf_static it is at {}, by the profile's base_from_lidar at {}: there its scans are placed",
                     words(base_from_lidar), words(ours));
}

// Scans.

namespace {

/// A turn of the contract's beams over a message's beams.
class Resampler {
 public:
  Resampler(const sensor_msgs::LaserScan& scan, const LidarSpec& spec)
      : scan_(scan),
        spec_(spec),
        beams_(static_cast<std::size_t>(spec.beams)),
        count_(scan.ranges.size()),
        increment_(static_cast<double>(scan.angle_increment)) {
    // a whole turn is one exactly, whatever a float makes of its increment
    const double turn = std::abs(increment_) * static_cast<double>(count_);
    if (std::abs(turn - kTurn) < 0.5 * std::abs(increment_)) {
      increment_ = std::copysign(kTurn / static_cast<double>(count_), increment_);
    }
    // beam 0 of the turn begins where the message's first beam does, or its last one where that goes clockwise
    const auto first = static_cast<double>(scan.angle_min);
    const double last = first + static_cast<double>(count_ - 1) * increment_;
    edge_ = std::min(first, last) - 0.5 * std::abs(increment_);
    ratio_ = kTurn / static_cast<double>(beams_) / std::abs(increment_);
  }

  LaserScan scan() const {
    LaserScan turn;
    turn.angle_increment = kTurn / static_cast<double>(beams_);
    turn.angle_min = edge_ + 0.5 * turn.angle_increment;
    constexpr double kRounding = 1e-6;  // [rad] within which a float may be beyond pi
    if (std::abs(turn.angle_min) > exact::kPi + kRounding) turn.angle_min = wrap_angle(turn.angle_min);
    turn.time_increment = (is_backward() ? -1.0 : 1.0) * ratio_ * increment_of_time();
    turn.range_min = spec_.range_min;
    turn.range_max = spec_.range_max;
    turn.ranges = ratio_ < 1.0 - 1e-6 ? spread() : nearest();
    return turn;
  }
  /// From the message's stamp to beam 0 of the turn.
  Duration to_beam_0() const {
    const double index = 0.5 * ratio_ - 0.5;  // of the message's beams, in the order in which the turn has them
    const double steps = is_backward() ? static_cast<double>(count_ - 1) - index : index;
    return from_seconds(steps * increment_of_time());
  }
  Duration to_end() const { return from_seconds(std::max(0.0, static_cast<double>(count_ - 1) * increment_of_time())); }

 private:
  static constexpr double kTurn = 2.0 * exact::kPi;

  double increment_of_time() const { return static_cast<double>(scan_.time_increment); }
  /// Whether beams were measured against the turn's order. Drivers that reverse the beams of a clockwise device to have
  /// them counter-clockwise leave the increment of time positive; the profile knows how the device turns.
  bool is_backward() const { return increment_ < 0.0 || (spec_.clockwise && increment_of_time() > 0.0); }
  float range(std::size_t i) const {
    return range_of(static_cast<double>(scan_.ranges[i]), static_cast<double>(scan_.range_min),
                    static_cast<double>(scan_.range_max), spec_.range_min, spec_.range_max);
  }
  /// The message's beam that comes `i`-th counter-clockwise.
  std::size_t in_order(std::size_t i) const { return increment_ < 0.0 ? count_ - 1 - i : i; }

  /// Of at least as many beams as the turn has: the nearest return in each; one on the edge of two counts for both.
  std::vector<float> nearest() const {
    constexpr float kNothing = std::numeric_limits<float>::infinity();
    constexpr double kOnEdge = 0.01;  // [beams], more than a float's angle may be off by
    std::vector<float> ranges(beams_, kNothing);
    for (std::size_t i = 0; i < count_; ++i) {
      const float found = range(in_order(i));
      if (found == 0.0F) continue;
      const double place = (static_cast<double>(i) + 0.5) / ratio_;
      for (const double side : {place - kOnEdge, place + kOnEdge}) {
        const auto beams = static_cast<double>(beams_);
        float& nearest = ranges[static_cast<std::size_t>(side - beams * std::floor(side / beams)) % beams_];
        nearest = std::min(nearest, found);
      }
    }
    for (float& one : ranges) one = one == kNothing ? 0.0F : one;
    return ranges;
  }
  /// Of fewer: each of the turn's beams is the message's beam that it lies in.
  std::vector<float> spread() const {
    std::vector<float> ranges(beams_, 0.0F);
    for (std::size_t k = 0; k < beams_; ++k) {
      const auto i = static_cast<std::size_t>((static_cast<double>(k) + 0.5) * ratio_);
      if (i < count_) ranges[k] = range(in_order(i));
    }
    return ranges;
  }

  const sensor_msgs::LaserScan& scan_;
  const LidarSpec& spec_;
  std::size_t beams_;
  std::size_t count_;
  double increment_;    // [rad] from the message's beam to beam; negative for one that goes clockwise
  double edge_ = 0.0;   // [rad] where the turn begins
  double ratio_ = 0.0;  // the message's beams per beam of the turn
};

}  // namespace

ReadingOrMistake to_reading(const sensor_msgs::LaserScan& scan, const LidarSpec& spec) {
  constexpr std::size_t kMostBeams = 65536;
  constexpr double kLongest = 10.0;  // [s] of one turn
  const auto increment = static_cast<double>(scan.angle_increment);
  const auto count = static_cast<double>(scan.ranges.size());
  if (scan.ranges.size() < 2 || scan.ranges.size() > kMostBeams) {
    return mistake(fmt::format("a scan of {} beams", scan.ranges.size()));
  }
  if (!std::isfinite(increment) || std::abs(increment) < 1e-6 || std::abs(increment) * count > 7.0) {
    return mistake(fmt::format("{} beams of {} rad are no turn, nor a part of one", scan.ranges.size(), increment));
  }
  if (!std::isfinite(scan.angle_min) || std::abs(static_cast<double>(scan.angle_min)) > 7.0) {
    return mistake(fmt::format("angle_min is {} rad", scan.angle_min));
  }
  const double lasts = static_cast<double>(scan.time_increment) * count;
  if (!(std::abs(lasts) < kLongest)) return mistake(fmt::format("the beams span {} s", lasts));
  const Resampler resampler(scan, spec);
  return Reading{resampler.scan(), to_time(scan.header.stamp), resampler.to_beam_0(), resampler.to_end()};
}

std::string contradiction(const sensor_msgs::LaserScan& scan, const LidarSpec& spec) {
  constexpr double kAbout = 0.1;  // share by which data sheets and drivers differ
  const auto range_max = static_cast<double>(scan.range_max);
  if (range_max < (1.0 - kAbout) * spec.range_max) {  // beyond, a beam without a return would seem free
    return fmt::format("its ranges end at {:.1f} m, those of the profile at {:.1f} m", range_max, spec.range_max);
  }
  const auto turn = static_cast<double>(scan.scan_time);
  if (turn > 0.0 && std::abs(turn - to_seconds(spec.turn)) > 2.0 * kAbout * to_seconds(spec.turn)) {
    return fmt::format("a turn takes {:.3f} s, in the profile {:.3f} s", turn, to_seconds(spec.turn));
  }
  if (scan.angle_increment < 0.0F && !spec.clockwise) return "it turns clockwise, in the profile counter-clockwise";
  return "";
}

// Clouds.

namespace {

/// Where a cloud has the coordinates of its points.
class CloudReader {
 public:
  /// Or what is wrong with the cloud.
  static tl::expected<CloudReader, std::string> of(const sensor_msgs::PointCloud2& cloud) {
    constexpr std::uint8_t kFloat32 = 7;
    if (cloud.is_bigendian) return mistake("points that are big-endian");
    CloudReader reader(cloud);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::string name(1, "xyz"[axis]);
      const auto field = std::ranges::find(cloud.fields, name, &sensor_msgs::PointField::name);
      if (field == cloud.fields.end() || field->datatype != kFloat32) {
        return mistake(fmt::format("points without {} as float32", name));
      }
      reader.offsets_[axis] = field->offset;
      if (std::uint64_t{field->offset} + sizeof(float) > cloud.point_step) {
        return mistake(fmt::format("points of {} bytes, whose {} is at {}", cloud.point_step, name, field->offset));
      }
    }
    const std::uint64_t row = std::uint64_t{cloud.width} * cloud.point_step;
    if (cloud.row_step < row || cloud.data.size() / std::max<std::size_t>(cloud.row_step, 1) < cloud.height) {
      return mistake(fmt::format("{} bytes, which are no {} x {} points of {} bytes", cloud.data.size(), cloud.width,
                                 cloud.height, cloud.point_step));
    }
    return reader;
  }
  std::array<double, 3> point(std::size_t row, std::size_t column) const {
    const std::uint8_t* begin = cloud_->data.data() + row * cloud_->row_step + column * cloud_->point_step;
    std::array<double, 3> xyz{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      float value = 0.0F;
      std::memcpy(&value, begin + offsets_[axis], sizeof value);
      xyz[axis] = static_cast<double>(value);
    }
    return xyz;
  }

 private:
  explicit CloudReader(const sensor_msgs::PointCloud2& cloud) : cloud_(&cloud) {}
  const sensor_msgs::PointCloud2* cloud_;
  std::array<std::size_t, 3> offsets_{};
};

}  // namespace

ReadingOrMistake to_reading(const sensor_msgs::PointCloud2& cloud, const LidarSpec& spec, std::string_view base_frame) {
  constexpr double kSlab = 0.05;  // [m] above and below the lidar's plane: its level ring, and none of the floor
  if (cloud.header.frame_id == base_frame) {
    return mistake(fmt::format("points in frame '{}'; those in the lidar's own frame are needed", base_frame));
  }
  const auto reader = CloudReader::of(cloud);
  if (!reader) return mistake(reader.error());
  LaserScan scan;
  scan.angle_increment = 2.0 * exact::kPi / spec.beams;
  scan.angle_min = -exact::kPi + 0.5 * scan.angle_increment;
  scan.range_min = spec.range_min;
  scan.range_max = spec.range_max;
  scan.ranges.assign(static_cast<std::size_t>(spec.beams), 0.0F);
  for (std::size_t row = 0; row < cloud.height; ++row) {
    for (std::size_t column = 0; column < cloud.width; ++column) {
      const auto [x, y, z] = reader->point(row, column);
      const double range = norm({x, y});
      const bool is_seen = std::abs(z) <= kSlab && range >= spec.range_min && range < spec.range_max;  // no nan is
      if (!is_seen) continue;
      const double place = (exact::atan2(y, x) + exact::kPi) / scan.angle_increment;
      float& nearest = scan.ranges[std::min(static_cast<std::size_t>(place), scan.ranges.size() - 1)];
      if (nearest == 0.0F || static_cast<float>(range) < nearest) nearest = static_cast<float>(range);
    }
  }
  return Reading{std::move(scan), to_time(cloud.header.stamp), {}, {}};
}

// Pictures.

namespace {

// Where blue, green and red are within a pixel of some bytes; empty for encodings that are none of colours.
struct Encoding {
  std::size_t bytes = 0;
  std::array<std::size_t, 3> bgr{};
};
std::optional<Encoding> encoding_of(std::string_view name) {
  if (name == "bgr8") return Encoding{3, {0, 1, 2}};
  if (name == "rgb8") return Encoding{3, {2, 1, 0}};
  if (name == "bgra8") return Encoding{4, {0, 1, 2}};
  if (name == "rgba8") return Encoding{4, {2, 1, 0}};
  if (name == "mono8") return Encoding{1, {0, 0, 0}};
  return std::nullopt;
}

template <typename Size>
std::optional<std::string> mistake_in(Size width, Size height, const CameraSpec& spec) {
  if (std::cmp_equal(width, spec.width) && std::cmp_equal(height, spec.height)) return std::nullopt;
  return fmt::format("an image of {} x {}; the profile has {} x {}", width, height, spec.width, spec.height);
}

std::optional<std::string> mistake_in(const sensor_msgs::Image& image, const CameraSpec& spec, std::size_t bytes) {
  if (auto wrong = mistake_in(image.width, image.height, spec)) return wrong;
  const std::size_t row = image.width * bytes;
  if (bytes > 0 && image.step >= row && image.data.size() / image.step >= image.height) return std::nullopt;
  return fmt::format("{} bytes, of {} a row, are no image of {} x {} in {}", image.data.size(), image.step, image.width,
                     image.height, image.encoding);
}

std::vector<std::uint8_t> colors_of(const sensor_msgs::Image& image, const Encoding& encoding) {
  std::vector<std::uint8_t> color;
  color.reserve(std::size_t{3} * image.width * image.height);
  for (std::size_t row = 0; row < image.height; ++row) {
    const std::uint8_t* pixel = image.data.data() + row * image.step;
    for (std::size_t column = 0; column < image.width; ++column, pixel += encoding.bytes) {
      for (const std::size_t offset : encoding.bgr) color.push_back(pixel[offset]);
    }
  }
  return color;
}

// In millimetres (REP 118) or in metres; what the camera cannot measure is invalid.
std::vector<float> depths_of(const sensor_msgs::Image& image, const DepthSpec& spec) {
  const bool millimetres = image.encoding == "16UC1";
  std::vector<float> depths;
  depths.reserve(std::size_t{image.width} * image.height);
  for (std::size_t row = 0; row < image.height; ++row) {
    const std::uint8_t* pixel = image.data.data() + row * image.step;
    for (std::size_t column = 0; column < image.width; ++column) {
      float depth = 0.0F;
      if (millimetres) {
        depth = 0.001F * static_cast<float>(pixel[2 * column] | pixel[2 * column + 1] << 8);
      } else {
        std::memcpy(&depth, pixel + 4 * column, sizeof depth);
      }
      const bool measured = depth >= static_cast<float>(spec.range_min) && depth <= static_cast<float>(spec.range_max);
      depths.push_back(measured ? depth : 0.0F);
    }
  }
  return depths;
}

}  // namespace

std::optional<ReadingOrMistake> PictureMaker::add_color(const std::shared_ptr<const sensor_msgs::Image>& image) {
  const auto encoding = encoding_of(image->encoding);
  if (!encoding) {
    return mistake(fmt::format("encoding '{}'; known: bgr8, rgb8, bgra8, rgba8, mono8", image->encoding));
  }
  if (auto wrong = mistake_in(*image, spec_, encoding->bytes)) return mistake(std::move(*wrong));
  color_ = Color{to_time(image->header.stamp), [image, encoding = *encoding] { return colors_of(*image, encoding); }};
  return match();
}

std::optional<ReadingOrMistake> PictureMaker::add_compressed(
    const std::shared_ptr<const sensor_msgs::CompressedImage>& image) {
  const auto size = jpeg_size(image->data);
  if (!size) return mistake(size.error());
  if (auto wrong = mistake_in(size->width, size->height, spec_)) return mistake(std::move(*wrong));
  color_ = Color{to_time(image->header.stamp), [image] { return decode_jpeg(image->data); }};
  return match();
}

std::optional<ReadingOrMistake> PictureMaker::add_depth(std::shared_ptr<const sensor_msgs::Image> image) {
  const std::size_t bytes = image->encoding == "16UC1" ? 2 : image->encoding == "32FC1" ? 4 : 0;
  if (bytes == 0 || image->is_bigendian != 0) {
    return mistake(fmt::format("depth in '{}'; known: 16UC1 and 32FC1, little-endian", image->encoding));
  }
  if (auto wrong = mistake_in(*image, spec_, bytes)) return mistake(std::move(*wrong));
  depth_ = std::move(image);
  return match();
}

std::optional<ReadingOrMistake> PictureMaker::match() {
  if (!color_ || (with_depth_ && !depth_)) return std::nullopt;
  if (with_depth_) {
    const Duration apart = color_->stamp - to_time(depth_->header.stamp);
    if (std::chrono::abs(apart) > spec_.period / 2) return std::nullopt;  // the other one is still to come
  }
  Color color = std::move(*std::exchange(color_, std::nullopt));
  Picture picture([spec = spec_, draw = std::move(color.draw), depth = std::exchange(depth_, nullptr)] {
    RGBDImage image{spec.intrinsics(), draw(), {}};
    if (depth) image.depth = depths_of(*depth, *spec.depth);
    return image;
  });
  return Reading{std::move(picture), color.stamp, {}, {}};
}

// What localization programs say.

std::optional<Pose2D> to_pose(const geometry_msgs::Transform& transform) {
  const auto theta = heading_of(transform.rotation);
  if (!theta) return std::nullopt;
  const Pose2D pose{transform.translation.x, transform.translation.y, *theta};
  return is_finite(pose) ? std::optional(pose) : std::nullopt;
}

std::optional<std::array<double, 9>> planar_covariance(const std::array<double, 36>& covariance) {
  constexpr std::array<std::size_t, 3> kPlanar{0, 1, 5};
  std::array<double, 9> planar{};
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column) {
      planar[3 * row + column] = covariance[6 * kPlanar[row] + kPlanar[column]];
      if (!std::isfinite(planar[3 * row + column])) return std::nullopt;
    }
    if (planar[4 * row] < 0.0) return std::nullopt;
  }
  return planar;
}

tl::expected<map::OccupancyGrid, std::string> to_grid(const nav_msgs::OccupancyGrid& message) {
  constexpr double kAlong = 1e-3;  // [rad]
  const auto& info = message.info;
  const auto turned = heading_of(info.origin.orientation);
  if (!turned) return mistake("has an origin whose orientation is no unit quaternion");
  if (std::abs(*turned) > kAlong) {
    return mistake(fmt::format("is turned by {:.3f} rad; its cells must lie along the axes of its frame", *turned));
  }
  if (!map::fits_a_grid(info.width, info.height)) return mistake("is too large");
  map::OccupancyGrid grid;
  grid.width = static_cast<int>(info.width);
  grid.height = static_cast<int>(info.height);
  // what a float made of it
  grid.resolution = std::round(1e6 * static_cast<double>(info.resolution)) / 1e6;
  grid.origin = {info.origin.position.x, info.origin.position.y};
  grid.data = message.data;
  const auto is_wrong = [](std::int8_t value) {
    return value < map::OccupancyGrid::kUnknown || value > map::OccupancyGrid::kOccupied;
  };
  if (std::ranges::any_of(grid.data, is_wrong)) return mistake("has cells that are neither -1 nor 0 to 100");
  if (grid.data.empty()) return mistake("has no cells");
  try {
    map::check_bounds(grid);
  } catch (const ContractError& error) {
    return mistake(error.what());
  }
  return grid;
}

}  // namespace threewe::ros2
