#include "gazebo/readings.hpp"

#include <cmath>
#include <cstring>
#include <limits>

#include <doctest/doctest.h>

#include "core/exact.hpp"

using namespace threewe;
using namespace threewe::gazebo;

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

msgs::LaserScan four_beams() {
  msgs::LaserScan scan;
  scan.header.stamp = {.sec = 1, .nsec = 500'000'000};
  scan.angle_min = -exact::kPi;
  scan.angle_step = 0.5 * exact::kPi;
  scan.ranges = {kInfinity, -kInfinity, 1.5, std::nan("")};
  return scan;
}

LidarSpec spec_of_four() {
  LidarSpec spec;
  spec.beams = 4;
  spec.range_min = 0.1;
  spec.range_max = 8.0;
  return spec;
}

}  // namespace

TEST_CASE("a scan has no return where Gazebo says inf, and nothing valid where it says -inf or nan") {
  const auto reading = to_reading(four_beams(), spec_of_four());
  REQUIRE(reading);
  CHECK(reading->stamp == 1500ms);
  const auto& scan = std::get<LaserScan>(reading->data);
  CHECK(scan.ranges == std::vector{8.0F, 0.0F, 1.5F, 0.0F});
  CHECK(scan.time_increment == 0.0);
}

TEST_CASE("a scan of other beams is refused with both numbers") {
  LidarSpec spec = spec_of_four();
  spec.beams = 5;
  const auto reading = to_reading(four_beams(), spec);
  REQUIRE(!reading);
  CHECK(reading.error() == "a scan of 4 beams; the profile has 5");
  msgs::LaserScan half = four_beams();
  half.angle_step = 0.25 * exact::kPi;
  CHECK(!to_reading(half, spec_of_four()));
}

TEST_CASE("an ultrasonic sensor measures the nearest of its beams") {
  UltrasonicSpec spec;
  spec.range_min = 0.02;
  spec.range_max = 4.0;
  msgs::LaserScan scan;
  scan.ranges = {2.0, 0.7, kInfinity};
  CHECK(std::get<RangeData>(to_reading(scan, spec)->data).range == 0.7);
  scan.ranges = {kInfinity, kInfinity};
  CHECK(std::get<RangeData>(to_reading(scan, spec)->data).range == 4.0);
  scan.ranges = {1.0, -kInfinity};
  CHECK(std::get<RangeData>(to_reading(scan, spec)->data).range == 0.0);
  scan.ranges.clear();
  CHECK(!to_reading(scan, spec));
}

TEST_CASE("a pose without a rotation is refused") {
  CHECK(!to_reading(msgs::Odometry{}));
  msgs::Odometry odometry;
  odometry.pose.orientation = {0.0, 0.0, 1.0, 0.0};
  const auto reading = to_reading(odometry);
  REQUIRE(reading);
  CHECK(std::get<Odometry>(reading->data).pose.theta == doctest::Approx(exact::kPi));
}

TEST_CASE("a picture is made of a colour and a depth image of one time") {
  CameraSpec spec;
  spec.width = 2;
  spec.height = 1;
  spec.horizontal_fov = 1.0;
  spec.depth = DepthSpec{.range_min = 0.3, .range_max = 5.0, .sigma = 0.0};
  msgs::Image color;
  color.width = 2;
  color.height = 1;
  color.step = 6;
  color.data = {1, 2, 3, 4, 5, 6};
  color.pixel_format = msgs::PixelFormat::rgb8;
  msgs::Image depth = color;
  depth.step = 8;
  depth.data.resize(8);
  const float meters[] = {2.0F, std::numeric_limits<float>::infinity()};
  std::memcpy(depth.data.data(), meters, sizeof meters);
  depth.pixel_format = msgs::PixelFormat::float32;

  PictureMaker maker(spec);
  msgs::Image late = depth;
  late.header.stamp.sec = 1;
  CHECK(!maker.add_depth(late));
  CHECK(!maker.add_color(color));
  const auto picture = maker.add_depth(depth);
  REQUIRE(picture);
  REQUIRE(*picture);
  const RGBDImage& image = std::get<Picture>((*picture)->data).image();
  CHECK(image.color == std::vector<std::uint8_t>{3, 2, 1, 6, 5, 4});
  CHECK(image.depth == std::vector{2.0F, 0.0F});

  color.data.pop_back();
  CHECK(!*maker.add_color(color));
  color.pixel_format = msgs::PixelFormat::float32;
  CHECK(!*maker.add_color(color));
}
