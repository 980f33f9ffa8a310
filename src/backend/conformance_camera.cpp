// The form of an image, and whether its depth is what the lidar measures.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "backend/conformance_images.hpp"
#include "hardware/sample_checks.hpp"

namespace threewe::backend::conformance {

Bench with_camera(const Context& context) {
  Bench bench = context.connected();
  applies_if(bench.has(SensorType::camera), "the robot has no camera");
  expect(bench.profile().camera.has_value(), "features() lists a camera that the profile lacks");
  return bench;
}

RGBDImage next_image(Bench& bench) {
  const Time begin = bench.now();
  while (bench.now() < begin + 2s) {
    bench.drive({}, kControlPeriod);
    const std::vector<Sample> images = bench.of(SensorType::camera);
    if (!images.empty() && images.back().measured >= begin) return std::get<Picture>(images.back().data).image();
  }
  bench.fail_without_new(SensorType::camera, begin);
}

namespace {

Bench with_depth(const Context& context) {
  Bench bench = with_camera(context);
  applies_if(bench.profile().camera->depth.has_value(), "the robot has no camera that measures depth");
  return bench;
}

std::size_t pixels_of(const CameraIntrinsics& camera) {
  return static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
}

void images_have_the_profiles_size(const Context& context) {
  Bench bench = with_camera(context);
  const CameraSpec& spec = *bench.profile().camera;
  const RGBDImage image = next_image(bench);
  expect(image.intrinsics.width == spec.width && image.intrinsics.height == spec.height,
         "an image of {} x {} pixels; the profile has {} x {}", image.intrinsics.width, image.intrinsics.height,
         spec.width, spec.height);
  expect(image.color.size() == 3 * pixels_of(image.intrinsics), "{} x {} pixels with {} colours, three for each",
         spec.width, spec.height, image.color.size());
}

void image_intrinsics_are_the_profiles(const Context& context) {
  Bench bench = with_camera(context);
  const CameraIntrinsics expected = bench.profile().camera->intrinsics();
  const CameraIntrinsics given = next_image(bench).intrinsics;
  const auto near = [&](double a, double b) { return std::abs(a - b) <= 0.05 * expected.fx; };  // as calibrated
  expect(near(given.fx, expected.fx) && near(given.fy, expected.fy) && near(given.cx, expected.cx) &&
             near(given.cy, expected.cy),
         "focal lengths ({:.1f}, {:.1f}) and centre ({:.1f}, {:.1f}); by the profile ({:.1f}, {:.1f}) and ({:.1f}, "
         "{:.1f}) pixels",
         given.fx, given.fy, given.cx, given.cy, expected.fx, expected.fy, expected.cx, expected.cy);
}

void images_follow_the_robot(const Context& context) {
  Bench bench = with_camera(context);
  const RGBDImage before = next_image(bench);
  bench.drive_and_stop({0.0, 0.0, bench.turning()}, from_seconds(0.6 / bench.turning()));
  expect(next_image(bench).color != before.color, "after a turn of 0.6 rad the image is the same to the last pixel");
}

void depth_is_there_if_promised(const Context& context) {
  Bench bench = with_camera(context);
  const RGBDImage image = next_image(bench);
  const bool promised = bench.profile().camera->depth.has_value();
  expect(image.depth.size() == (promised ? pixels_of(image.intrinsics) : 0),
         "an image with {} depths; the profile promises {}", image.depth.size(),
         promised ? "one for each pixel" : "none");
}

void depth_is_valid(const Context& context) {
  Bench bench = with_depth(context);
  const DepthSpec& spec = *bench.profile().camera->depth;
  for (const float depth : next_image(bench).depth) {
    const auto metres = static_cast<double>(depth);
    const bool within = metres >= spec.range_min - kRangeTolerance && metres <= spec.range_max + kRangeTolerance;
    expect(metres == 0.0 || within, "{} m is neither 0 (invalid) nor within {} to {} m", metres, spec.range_min,
           spec.range_max);
  }
}

/// Where the pixels of the horizon see something, in the base frame; each depth d is read as `read(d, stretch)`, where
/// the ray is `stretch` times as long as its part along the optical axis.
template <typename Read>
std::vector<Vec2> horizon(const RGBDImage& image, const Pose2D& base_from_camera, Read read) {
  const CameraIntrinsics& camera = image.intrinsics;
  const auto width = static_cast<std::size_t>(camera.width);
  const auto row = static_cast<std::size_t>(std::clamp(static_cast<int>(camera.cy), 0, camera.height - 1));
  std::vector<Vec2> points;
  for (int column = 0; column < camera.width; ++column) {
    const auto depth = static_cast<double>(image.depth.at(row * width + static_cast<std::size_t>(column)));
    if (depth == 0.0) continue;
    const double left = (camera.cx - (column + 0.5)) / camera.fx;
    const double along_the_axis = read(depth, norm({1.0, left}));
    points.push_back(base_from_camera * (along_the_axis * Vec2{1.0, left}));
  }
  return points;
}

/// The lidar sees what stands on the horizon, too: depth read as it should be must fit no worse than misread.
void depth_agrees_with_lidar(const Context& context) {
  Bench bench = with_depth(context);
  applies_if(bench.has(SensorType::lidar), "the robot has no lidar");
  const RGBDImage image = next_image(bench);
  const std::vector<Vec2> seen = hits(bench.next_scan(), bench.profile().lidar->base_from_lidar);
  const Pose2D mount = bench.profile().camera->base_from_camera;
  const auto misfit_of = [&](auto read, const Pose2D& base_from_camera) {
    const std::vector<Vec2> points = horizon(image, base_from_camera, read);
    applies_if(points.size() >= 20 && seen.size() >= 20, "too little stands on the horizon");
    return misfit(seen, points, {});
  };
  const auto as_is = [](double depth, double) { return depth; };
  const double fit = misfit_of(as_is, mount);
  const std::pair<const char*, double> others[] = {
      {"along each pixel's ray", misfit_of([](double depth, double stretch) { return depth / stretch; }, mount)},
      {"as twice as much", misfit_of([](double depth, double) { return 2.0 * depth; }, mount)},
      {"as half as much", misfit_of([](double depth, double) { return 0.5 * depth; }, mount)},
      {"from a mount with the other sign", misfit_of(as_is, {-mount.x, -mount.y, -mount.theta})},
      {"from the middle of the base", misfit_of(as_is, {})}};
  const auto& [how, other] = *std::ranges::min_element(others, {}, &std::pair<const char*, double>::second);
  expect(fit <= other + 0.01, "depth fits the scan within {:.3f} m; read {} within {:.3f} m", fit, how, other);
  expect(fit <= 0.2, "depth fits the scan within {:.3f} m only", fit);
}

constexpr Check kCameraChecks[] = {
    {"images_have_the_profiles_size", images_have_the_profiles_size},
    {"image_intrinsics_are_the_profiles", image_intrinsics_are_the_profiles},
    {"images_follow_the_robot", images_follow_the_robot},
    {"depth_is_there_if_promised", depth_is_there_if_promised},
    {"depth_is_valid", depth_is_valid},
    {"depth_agrees_with_lidar", depth_agrees_with_lidar},
};

}  // namespace

std::span<const Check> camera_checks() { return kCameraChecks; }

}  // namespace threewe::backend::conformance
