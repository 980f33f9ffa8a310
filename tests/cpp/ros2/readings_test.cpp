// Sensor messages as readings of the contract.
#include "ros2/readings.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "core/exact.hpp"
#include "draw.hpp"
#include "hardware/sample_checks.hpp"

namespace threewe::ros2 {
namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr double kTurn = 2.0 * exact::kPi;

const RobotProfile& robot() {
  static const RobotProfile profile = load_profile("3we_standard_v2");
  return profile;
}

// Beams from one angle on, all with one range until some are changed.
sensor_msgs::LaserScan scan_of(std::size_t beams, double angle_min, double increment, float range = 3.0F) {
  sensor_msgs::LaserScan scan;
  scan.header.stamp = {100, 0};
  scan.angle_min = static_cast<float>(angle_min);
  scan.angle_increment = static_cast<float>(increment);
  scan.angle_max = static_cast<float>(angle_min + static_cast<double>(beams - 1) * increment);
  scan.range_min = 0.02F;
  scan.range_max = 12.0F;
  scan.ranges.assign(beams, range);
  return scan;
}

const LaserScan& scan_in(const ReadingOrMistake& reading) {
  REQUIRE(reading);
  return std::get<LaserScan>(reading->data);
}

// The range in the beam that points along an angle.
float range_at(const LaserScan& scan, double angle) {
  const double place = wrap_angle(angle - scan.angle_min) / scan.angle_increment;
  const auto beams = static_cast<int>(scan.ranges.size());
  return scan.ranges[static_cast<std::size_t>((static_cast<int>(std::lround(place)) + beams) % beams)];
}

// Points of 16 bytes, as drivers have them, with an intensity.
sensor_msgs::PointCloud2 cloud_of(const std::vector<std::array<float, 3>>& points, std::uint32_t rows = 1) {
  sensor_msgs::PointCloud2 cloud;
  cloud.header = {{100, 0}, "lidar"};
  cloud.height = rows;
  cloud.width = static_cast<std::uint32_t>(points.size()) / rows;
  cloud.point_step = 16;
  cloud.row_step = 16 * cloud.width;
  cloud.fields = {{"x", 0, 7, 1}, {"y", 4, 7, 1}, {"z", 8, 7, 1}, {"intensity", 12, 7, 1}};
  cloud.data.resize(16 * points.size());
  for (std::size_t i = 0; i < points.size(); ++i) std::memcpy(&cloud.data[16 * i], points[i].data(), 12);
  return cloud;
}

TEST_CASE("a scan that contradicts the profile says in what") {
  LidarSpec spec = *robot().lidar;
  sensor_msgs::LaserScan message = scan_of(360, -exact::kPi, kTurn / 360);
  message.range_max = static_cast<float>(spec.range_max);
  CHECK(contradiction(message, spec).empty());
  message.scan_time = 1.05F * static_cast<float>(to_seconds(spec.turn));
  CHECK(contradiction(message, spec).empty());
  message.scan_time = 3.0F * static_cast<float>(to_seconds(spec.turn));
  CHECK(contradiction(message, spec).starts_with("a turn takes"));
  message.scan_time = 0.0F;
  message.angle_increment *= -1.0F;
  spec.clockwise = false;
  CHECK(contradiction(message, spec) == "it turns clockwise, in the profile counter-clockwise");
  message.range_max = 3.5F;
  CHECK(contradiction(message, spec).starts_with("its ranges end at 3.5 m"));
}

TEST_CASE("a missing transform names those that are there") {
  TransformOdometry transforms("odom", "base_link");
  CHECK(transforms.missing() == "no transform odom -> base_link");
  tf2_msgs::TFMessage message;
  message.transforms.resize(2);
  message.transforms[0].header.frame_id = "map";
  message.transforms[0].child_frame_id = "odom";
  message.transforms[1].header.frame_id = "odom";
  message.transforms[1].child_frame_id = "base_footprint";
  CHECK_FALSE(transforms.is_in(message));
  CHECK(transforms.missing() == "no transform odom -> base_link; there is map -> odom, odom -> base_footprint");
  message.transforms[1].child_frame_id = "/base_link";
  CHECK(transforms.is_in(message));
}

TEST_CASE("a lidar that static transforms put elsewhere contradicts the profile") {
  tf2_msgs::TFMessage message;
  const auto add = [&](const char* parent, const char* child, double x, double theta) {
    auto& transform = message.transforms.emplace_back();
    transform.header.frame_id = parent;
    transform.child_frame_id = child;
    transform.transform.translation.x = x;
    transform.transform.rotation = {0.0, 0.0, std::sin(0.5 * theta), std::cos(0.5 * theta)};
  };
  add("/base_link", "tower", 0.1, 0.5 * exact::kPi);
  add("tower", "laser", 0.02, 0.0);
  add("here", "there", 1.0, 0.0);
  add("there", "here", -1.0, 0.0);
  StaticFrames frames;
  frames.add(message);
  CHECK_FALSE(frames.pose("camera", "base_link"));
  CHECK_FALSE(frames.pose("here", "base_link"));  // they go round in a circle
  CHECK(frames.pose("base_link", "base_link"));
  const auto mount = frames.pose("laser", "base_link");
  REQUIRE(mount);
  CHECK(mount->x == doctest::Approx(0.1));
  CHECK(mount->y == doctest::Approx(0.02));

  LidarSpec spec = *robot().lidar;
  spec.base_from_lidar = {0.1, 0.0, 0.5 * exact::kPi};
  CHECK(mount_contradiction(*mount, spec).empty());
  spec.base_from_lidar = {0.1, 0.0, 0.0};
  CHECK(mount_contradiction(*mount, spec) ==
        "by /tf_static it is at (0.100, 0.020) m, turned by 90 deg, by the profile's base_from_lidar at (0.100, 0.000) "
        "m, "
        "turned by 0 deg: there its scans are placed");
}

TEST_CASE("a cloud is cut at the lidar's height") {
  const LidarSpec& spec = *robot().lidar;
  const auto cloud = cloud_of({{2.0F, 0.0F, 0.0F},
                               {1.0F, 0.0F, 0.3F},   // above
                               {1.0F, 0.0F, -0.2F},  // the floor
                               {0.0F, 3.0F, 0.04F},
                               {0.0F, 2.5F, -0.04F},
                               {-4.0F, -0.01F, 0.0F},
                               {kNan, kNan, kNan},
                               {50.0F, 50.0F, 0.0F}},
                              2);
  const ReadingOrMistake reading = to_reading(cloud, spec, "base_link");
  const LaserScan& scan = scan_in(reading);
  CHECK(reading->stamp == 100s);
  check_data({"lidar", SensorType::lidar, 10.0}, scan, robot());
  CHECK(range_at(scan, 0.5 * scan.angle_increment) == 2.0F);
  CHECK(range_at(scan, 0.5 * exact::kPi + 0.5 * scan.angle_increment) == 2.5F);
  CHECK(range_at(scan, scan.angle_min) == doctest::Approx(4.0));
  CHECK(std::ranges::count_if(scan.ranges, [](float range) { return range != 0.0F; }) == 3);
}

TEST_CASE("a cloud is what each of its points in turn says") {
  const LidarSpec& spec = *robot().lidar;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    std::vector<std::array<float, 3>> points(400);
    for (auto& point : points) {
      for (std::size_t axis = 0; axis < 2; ++axis) point[axis] = static_cast<float>(draw(-15.0, 15.0));
      point[2] = static_cast<float>(draw(-0.2, 0.2));
    }
    const ReadingOrMistake reading = to_reading(cloud_of(points, 4), spec, "base_link");
    const LaserScan& scan = scan_in(reading);
    for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
      const double angle = scan.angle_min + static_cast<double>(i) * scan.angle_increment;
      double nearest = 0.0;
      for (const auto& point : points) {
        const auto [x, y, z] =
            std::array{static_cast<double>(point[0]), static_cast<double>(point[1]), static_cast<double>(point[2])};
        const double range = std::hypot(x, y);
        const bool within = std::abs(wrap_angle(std::atan2(y, x) - angle)) < 0.5 * scan.angle_increment;
        if (!within || std::abs(z) > 0.05 || range < spec.range_min || range >= spec.range_max) continue;
        if (nearest == 0.0 || range < nearest) nearest = range;
      }
      CHECK(static_cast<double>(scan.ranges[i]) == doctest::Approx(nearest));
    }
  }
}

TEST_CASE("a cloud that cannot be read says why") {
  const LidarSpec& spec = *robot().lidar;
  const auto error = [&](auto&& change) {
    sensor_msgs::PointCloud2 cloud = cloud_of({{1.0F, 0.0F, 0.0F}, {2.0F, 0.0F, 0.0F}});
    change(cloud);
    const ReadingOrMistake reading = to_reading(cloud, spec, "base_link");
    return reading ? "" : reading.error();
  };
  CHECK(error([](auto&) {}).empty());
  CHECK(error([](auto& cloud) { cloud.fields[2].name = "r"; }) == "points without z as float32");
  CHECK(error([](auto& cloud) { cloud.fields[0].datatype = 8; }) == "points without x as float32");
  CHECK(error([](auto& cloud) { cloud.fields[1].offset = 13; }) == "points of 16 bytes, whose y is at 13");
  CHECK(error([](auto& cloud) { cloud.width = 3; }).starts_with("32 bytes, which are no 3 x 1 points"));
  CHECK(error([](auto& cloud) { cloud.height = 0xFFFFFFFF; }).starts_with("32 bytes, which are no"));
  CHECK(error([](auto& cloud) { cloud.row_step = 0; }).starts_with("32 bytes, which are no"));
  CHECK(error([](auto& cloud) { cloud.is_bigendian = true; }) == "points that are big-endian");
  CHECK(error([](auto& cloud) { cloud.header.frame_id = "base_link"; }).find("lidar's own frame") != std::string::npos);
}

TEST_CASE("a turn of as many beams is itself") {
  sensor_msgs::LaserScan message = scan_of(360, -exact::kPi, kTurn / 360);
  for (std::size_t i = 0; i < 360; ++i) message.ranges[i] = 1.0F + 0.01F * static_cast<float>(i);
  message.time_increment = 0.1F / 360.0F;
  LidarSpec spec = *robot().lidar;
  spec.clockwise = false;
  const ReadingOrMistake reading = to_reading(message, spec);
  const LaserScan& scan = scan_in(reading);
  CHECK(scan.ranges == message.ranges);
  CHECK(scan.angle_min == doctest::Approx(-exact::kPi));
  CHECK(scan.time_increment == doctest::Approx(0.1 / 360));
  CHECK(reading->stamp == 100s);
  CHECK(std::abs(to_seconds(reading->to_measured)) < 1e-6);
  CHECK(to_seconds(reading->to_end) == doctest::Approx(0.1 * 359 / 360));
}

TEST_CASE("beams point where they did, whatever the message's count, direction and first angle") {
  for (std::uint64_t seed = 0; seed < cases(500); ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    const auto beams = static_cast<std::size_t>(draw.whole(180, 2000));
    const bool clockwise = draw.whole(0, 1) == 1;
    const double increment = (clockwise ? -1.0 : 1.0) * kTurn / static_cast<double>(beams);
    sensor_msgs::LaserScan message = scan_of(beams, draw(-3.1, 3.1), increment);
    const auto hit = static_cast<std::size_t>(draw.whole(0, static_cast<int>(beams) - 1));
    message.ranges[hit] = 1.5F;
    message.time_increment = static_cast<float>(0.1 / static_cast<double>(beams));
    LidarSpec spec = *robot().lidar;
    spec.clockwise = clockwise;

    const ReadingOrMistake reading = to_reading(message, spec);
    const LaserScan& scan = scan_in(reading);
    check_data({"lidar", SensorType::lidar, 10.0}, scan, robot());
    CHECK(std::abs(scan.angle_min) <= exact::kPi + 1e-6);
    CHECK(std::abs(std::abs(scan.time_increment) * 360 - 0.1) < 1e-4);
    CHECK((scan.time_increment < 0.0) == clockwise);
    const double angle = static_cast<double>(message.angle_min) + static_cast<double>(hit) * increment;
    for (std::size_t k = 0; k < scan.ranges.size(); ++k) {
      if (scan.ranges[k] == 3.0F) continue;
      REQUIRE(scan.ranges[k] == 1.5F);
      const double beam = scan.angle_min + static_cast<double>(k) * scan.angle_increment;
      CHECK(std::abs(wrap_angle(beam - angle)) <= 0.5 * (scan.angle_increment + std::abs(increment)) + 1e-3);
      // and was measured when the message says, within a beam
      const double said = static_cast<double>(hit) * static_cast<double>(message.time_increment);
      const double ours = to_seconds(reading->to_measured) + static_cast<double>(k) * scan.time_increment;
      const double off = std::abs(ours - said);
      CHECK(std::min(off, std::abs(off - 0.1)) <= 0.1 * (1.0 / 360 + 1.0 / static_cast<double>(beams)));
    }
    CHECK(std::ranges::count(scan.ranges, 1.5F) >= 1);
  }
}

TEST_CASE("450 points make 360 beams: the nearest return, none, or nothing valid") {
  sensor_msgs::LaserScan message = scan_of(450, 0.0, kTurn / 450, kInf);
  message.ranges[102] = 2.0F;  // on the edge of beams 81 and 82
  message.ranges[103] = 1.0F;  // in beam 82
  const ReadingOrMistake far = to_reading(message, *robot().lidar);
  CHECK(range_at(scan_in(far), 101.0 * kTurn / 450) == 2.0F);
  CHECK(range_at(scan_in(far), 103.0 * kTurn / 450) == 1.0F);
  CHECK(std::ranges::count(scan_in(far).ranges, 12.0F) >= 357);

  message.ranges.assign(450, kNan);
  const ReadingOrMistake blind = to_reading(message, *robot().lidar);
  CHECK(std::ranges::count(scan_in(blind).ranges, 0.0F) == 360);
}

TEST_CASE("what is no measurement is invalid, and what is beyond the lidar's range is no return") {
  sensor_msgs::LaserScan message = scan_of(360, -exact::kPi, kTurn / 360);
  message.ranges = {};
  message.ranges.resize(360, 3.0F);
  message.ranges[0] = kNan;
  message.ranges[1] = -kInf;
  message.ranges[2] = 0.0F;
  message.ranges[3] = 0.01F;
  message.ranges[4] = kInf;
  message.ranges[5] = 13.0F;
  message.ranges[6] = -1.0F;
  const ReadingOrMistake reading = to_reading(message, *robot().lidar);
  const auto& ranges = scan_in(reading).ranges;
  CHECK(std::vector(ranges.begin(), ranges.begin() + 8) ==
        std::vector{0.0F, 0.0F, 0.0F, 0.0F, 12.0F, 12.0F, 0.0F, 3.0F});
}

TEST_CASE("a part of a turn leaves the rest invalid") {
  const sensor_msgs::LaserScan message = scan_of(541, -0.75 * exact::kPi, 1.5 * exact::kPi / 540);
  const ReadingOrMistake reading = to_reading(message, *robot().lidar);
  CHECK(range_at(scan_in(reading), 0.0) == 3.0F);
  CHECK(range_at(scan_in(reading), 2.3) == 3.0F);
  CHECK(range_at(scan_in(reading), exact::kPi) == 0.0F);
  CHECK(std::abs(std::ranges::count(scan_in(reading).ranges, 0.0F) - 90) <= 2);
}

TEST_CASE("fewer beams than the profile's are spread over them") {
  sensor_msgs::LaserScan message = scan_of(180, -exact::kPi, kTurn / 180);
  message.ranges[90] = 1.0F;
  const ReadingOrMistake reading = to_reading(message, *robot().lidar);
  CHECK(std::ranges::count(scan_in(reading).ranges, 0.0F) == 0);
  CHECK(std::ranges::count(scan_in(reading).ranges, 1.0F) == 2);
}

TEST_CASE("beams of a clockwise device that its driver has reversed are measured from the last to the first") {
  sensor_msgs::LaserScan message = scan_of(360, -exact::kPi, kTurn / 360);
  message.time_increment = 0.1F / 360.0F;
  const ReadingOrMistake reading = to_reading(message, *robot().lidar);
  CHECK(scan_in(reading).time_increment == doctest::Approx(-0.1 / 360));
  CHECK(to_seconds(reading->to_measured) == doctest::Approx(0.1 * 359 / 360));
}

TEST_CASE("a scan that is none is refused") {
  CHECK_FALSE(to_reading(scan_of(1, 0.0, 0.1), *robot().lidar));
  CHECK_FALSE(to_reading(scan_of(360, 0.0, 0.0), *robot().lidar));
  CHECK_FALSE(to_reading(scan_of(360, 0.0, static_cast<double>(kNan)), *robot().lidar));
  CHECK_FALSE(to_reading(scan_of(3600, 0.0, 0.01), *robot().lidar));
  CHECK_FALSE(to_reading(scan_of(360, static_cast<double>(kInf), kTurn / 360), *robot().lidar));
  sensor_msgs::LaserScan message = scan_of(360, 0.0, kTurn / 360);
  message.time_increment = 1e9F;
  CHECK_FALSE(to_reading(message, *robot().lidar));
}

TEST_CASE("odometry is a pose in the plane and the velocity of the body") {
  nav_msgs::Odometry message;
  message.header.stamp = {5, 500'000'000};
  message.pose.pose.position = {1.0, 2.0, 0.1};
  message.pose.pose.orientation = {0.0, 0.0, std::sin(0.4), std::cos(0.4)};
  message.twist.twist.linear = {0.3, 0.1, 0.0};
  message.twist.twist.angular = {0.0, 0.0, -0.5};
  const ReadingOrMistake reading = to_reading(message);
  REQUIRE(reading);
  const auto& odometry = std::get<Odometry>(reading->data);
  CHECK(odometry.pose.theta == doctest::Approx(0.8));
  CHECK(odometry.pose.position() == Vec2{1.0, 2.0});
  CHECK(odometry.velocity == Velocity{0.3, 0.1, -0.5});
  CHECK(reading->stamp == 5500ms);
  message.pose.pose.orientation = {0.0, 0.0, 0.0, 0.0};
  CHECK_FALSE(to_reading(message));
  message.pose.pose.orientation = {};
  message.twist.twist.linear.x = static_cast<double>(kNan);
  CHECK_FALSE(to_reading(message));
}

TEST_CASE("transforms are odometry, too") {
  TransformOdometry transforms("odom", "base_link");
  tf2_msgs::TFMessage message;
  auto& transform = message.transforms.emplace_back();
  transform.header = {{10, 0}, "/odom"};
  transform.child_frame_id = "base_link";
  CHECK_FALSE(transforms.to_reading(message));  // no velocity yet
  transform.header.stamp = {10, 100'000'000};
  transform.transform.translation.x = 0.05;
  const auto reading = transforms.to_reading(message);
  REQUIRE(reading);
  REQUIRE(*reading);
  CHECK(std::get<Odometry>((*reading)->data).velocity.vx == doctest::Approx(0.5));
  CHECK_FALSE(transforms.to_reading(message));  // said again
  transform.child_frame_id = "camera";
  transform.header.stamp = {11, 0};
  CHECK_FALSE(transforms.to_reading(message));
}

TEST_CASE("a battery's current flows out, and its charge follows from the voltage where it is not stated") {
  sensor_msgs::BatteryState message;
  message.voltage = 7.2F;
  message.current = -1.5F;
  message.percentage = 0.25F;
  const auto state = std::get<BatteryState>(to_reading(message, *robot().battery)->data);
  CHECK(state.current == doctest::Approx(1.5));
  CHECK(state.charge == doctest::Approx(0.25));
  message.percentage = message.current = kNan;
  CHECK(std::get<BatteryState>(to_reading(message, *robot().battery)->data).charge == doctest::Approx(0.5));
  message.voltage = kNan;
  CHECK_FALSE(to_reading(message, *robot().battery));
}

TEST_CASE("ranges without a return, and without a measurement") {
  sensor_msgs::Range message;
  message.min_range = 0.02F;
  message.max_range = 4.0F;
  const auto range = [&](float value) {
    message.range = value;
    return std::get<RangeData>(to_reading(message, *robot().ultrasonics)->data).range;
  };
  CHECK(range(1.25F) == 1.25);
  CHECK(range(kInf) == 4.0);
  CHECK(range(4.5F) == 4.0);
  CHECK(range(kNan) == 0.0);
  CHECK(range(-kInf) == 0.0);
  CHECK(range(0.01F) == 0.0);
}

std::shared_ptr<sensor_msgs::Image> image_of(const CameraSpec& spec, const char* encoding, std::size_t bytes) {
  auto image = std::make_shared<sensor_msgs::Image>();
  image->header.stamp = {3, 0};
  image->width = static_cast<std::uint32_t>(spec.width);
  image->height = static_cast<std::uint32_t>(spec.height);
  image->encoding = encoding;
  image->step = static_cast<std::uint32_t>(bytes) * image->width;
  image->data.resize(std::size_t{image->step} * image->height);
  return image;
}

TEST_CASE("a red pixel is red, in every encoding of colours") {
  CameraSpec spec = *robot().camera;
  spec.width = 4;
  spec.height = 2;
  for (const auto& [encoding, bytes, red] : {std::tuple{"bgr8", 3U, 2U}, std::tuple{"rgb8", 3U, 0U},
                                             std::tuple{"bgra8", 4U, 2U}, std::tuple{"rgba8", 4U, 0U}}) {
    CAPTURE(encoding);
    auto message = image_of(spec, encoding, bytes);
    message->data[bytes + red] = 200;  // of the second pixel
    const auto reading = PictureMaker(spec, false).add_color(message);
    REQUIRE(reading);
    REQUIRE(*reading);
    const RGBDImage& image = std::get<Picture>((*reading)->data).image();
    CHECK(image.color.size() == 24);
    CHECK(image.color[3 + 2] == 200);
    CHECK(std::ranges::count(image.color, 0) == 23);
  }
}

// Of 4 x 2 pixels of (200, 30, 10), by Pillow.
std::vector<std::uint8_t> jpeg_of_red() {
  constexpr std::string_view kHex =
      "ffd8ffe000104a46494600010100000100010000ffdb0043000201010101010201010102020202020403020202020504040304060506"
      "060605060606070908060709070606080b08090a0a0a0a0a06080b0c0b0a0c090a0a0affdb004301020202020202050303050a070607"
      "0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0affc00011"
      "080002000403011100021101031101ffc40014000100000000000000000000000000000008ffc4001410010000000000000000000000"
      "0000000000ffc4001501010100000000000000000000000000000809ffc40014110100000000000000000000000000000000ffda000c"
      "03010002110311003f001d8c6ab8ffd9";
  std::vector<std::uint8_t> bytes;
  for (std::size_t i = 0; i < kHex.size(); i += 2) {
    bytes.push_back(static_cast<std::uint8_t>(std::stoi(std::string(kHex.substr(i, 2)), nullptr, 16)));
  }
  return bytes;
}

TEST_CASE("a JPEG is the picture that was compressed") {
  CameraSpec spec = *robot().camera;
  spec.width = 4;
  spec.height = 2;
  auto message = std::make_shared<sensor_msgs::CompressedImage>();
  message->header.stamp = {3, 0};
  message->data = jpeg_of_red();
  const auto reading = PictureMaker(spec, false).add_compressed(message);
  REQUIRE(reading);
  if (!*reading) {
    WARN_MESSAGE(false, reading->error());  // libjpeg-turbo is not there
    return;
  }
  CHECK((*reading)->stamp == 3s);
  const RGBDImage& image = std::get<Picture>((*reading)->data).image();
  REQUIRE(image.color.size() == 24);
  CHECK(std::abs(image.color[0] - 10) <= 3);
  CHECK(std::abs(image.color[1] - 30) <= 3);
  CHECK(std::abs(image.color[2] - 200) <= 3);

  spec.width = 5;
  CHECK_FALSE(*PictureMaker(spec, false).add_compressed(message));
  auto broken = std::make_shared<sensor_msgs::CompressedImage>(*message);
  broken->data.resize(20);
  CHECK_FALSE(*PictureMaker(spec, false).add_compressed(broken));
}

TEST_CASE("pictures with depth wait for both images") {
  CameraSpec spec = *robot().camera;
  spec.width = 2;
  spec.height = 1;
  spec.depth = DepthSpec{.range_min = 0.3, .range_max = 5.0, .sigma = 0.0};
  PictureMaker maker(spec, true);
  CHECK_FALSE(maker.add_color(image_of(spec, "bgr8", 3)));
  auto depth = image_of(spec, "16UC1", 2);
  depth->data = {0xDC, 0x05, 0x10, 0x00};  // 1,500 mm, and 16 mm, which is too near
  const auto reading = maker.add_depth(depth);
  REQUIRE(reading);
  const std::vector<float>& depths = std::get<Picture>((*reading)->data).image().depth;
  CHECK(depths.front() == doctest::Approx(1.5));
  CHECK(depths.back() == 0.0F);

  CHECK_FALSE(maker.add_color(image_of(spec, "bgr8", 3)));
  depth->header.stamp = {4, 0};
  CHECK_FALSE(maker.add_depth(depth));  // of another time
}

TEST_CASE("an image that is none is refused") {
  const CameraSpec& spec = *robot().camera;
  PictureMaker maker(spec, false);
  const auto mistake = [&](const std::shared_ptr<sensor_msgs::Image>& image) {
    const auto reading = maker.add_color(image);
    REQUIRE(reading);
    return *reading ? "" : reading->error();
  };
  auto image = image_of(spec, "bayer_rggb8", 1);
  CHECK(mistake(image).find("bayer_rggb8") != std::string::npos);
  image = image_of(spec, "rgb8", 3);
  image->width = 1280;
  CHECK(mistake(image).find("the profile has 640 x 480") != std::string::npos);
  image = image_of(spec, "rgb8", 3);
  image->data.pop_back();
  CHECK(mistake(image).find("are no image") != std::string::npos);
  image->step = 0;
  CHECK(mistake(image).find("are no image") != std::string::npos);
}

TEST_CASE("a map lies along its frame's axes, with cells as ROS has them") {
  nav_msgs::OccupancyGrid message;
  message.info.resolution = 0.05F;
  message.info.width = 3;
  message.info.height = 2;
  message.info.origin.position = {-1.0, 2.0, 0.0};
  message.data = {0, 100, -1, 50, 0, 0};
  const auto grid = to_grid(message);
  REQUIRE(grid);
  CHECK(grid->resolution == 0.05);  // what a float made of it
  CHECK(grid->origin == Vec2{-1.0, 2.0});
  CHECK(grid->width == 3);
  CHECK(grid->data == message.data);

  const auto error = [&](auto change) {
    nav_msgs::OccupancyGrid changed = message;
    change(changed);
    const auto made = to_grid(changed);
    REQUIRE_FALSE(made);
    return made.error();
  };
  CHECK(error([](auto& m) { m.info.origin.orientation = {0.0, 0.0, 0.1, 0.995}; }).starts_with("is turned by 0.2"));
  CHECK(error([](auto& m) { m.info.origin.orientation = {0.0, 0.0, 0.0, 0.0}; }) ==
        "has an origin whose orientation is no unit quaternion");
  CHECK(error([](auto& m) { m.data[3] = 101; }) == "has cells that are neither -1 nor 0 to 100");
  CHECK(error([](auto& m) { m.data.pop_back(); }) == "map: 5 cells in a grid of 3 x 2");
  CHECK(error([](auto& m) { m.data.clear(); }) == "has no cells");
  CHECK(error([](auto& m) { m.info.width = 1'000'000; }) == "is too large");
  CHECK(error([](auto& m) { m.info.resolution = kNan; }).starts_with("map: resolution must lie in"));
}

TEST_CASE("of a covariance of six that of the floor is taken") {
  std::array<double, 36> all{};
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<double>(i);
  CHECK(planar_covariance(all) == std::array<double, 9>{0, 1, 5, 6, 7, 11, 30, 31, 35});
  all[7] = -1.0;
  CHECK_FALSE(planar_covariance(all));
  all[7] = std::numeric_limits<double>::quiet_NaN();
  CHECK_FALSE(planar_covariance(all));
}

TEST_CASE("a transform is a pose along the floor") {
  geometry_msgs::Transform transform{{1.0, 2.0, 3.0}, {0.0, 0.0, std::sin(0.25), std::cos(0.25)}};
  const auto pose = to_pose(transform);
  REQUIRE(pose);
  CHECK(pose->x == 1.0);
  CHECK(pose->theta == doctest::Approx(0.5));
  transform.translation.x = std::numeric_limits<double>::infinity();
  CHECK_FALSE(to_pose(transform));
}

}  // namespace
}  // namespace threewe::ros2
