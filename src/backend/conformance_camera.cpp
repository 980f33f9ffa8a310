// The form of an image, and whether it shows what is there.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <utility>

#include "backend/conformance_bench.hpp"
#include "threewe/backend/sample_checks.hpp"
#include "threewe/scene/truth_view.hpp"

namespace threewe::backend::conformance {

namespace {

Bench with_camera(const Context& context) {
  Bench bench = context.connected();
  applies_if(bench.has(SensorType::camera), "the robot has no camera");
  expect(bench.profile().camera.has_value(), "features() lists a camera that the profile lacks");
  return bench;
}

Bench with_depth(const Context& context) {
  Bench bench = with_camera(context);
  applies_if(bench.profile().camera->depth.has_value(), "the robot has no camera that measures depth");
  return bench;
}

/// An image that was taken from now on.
RGBDImage next_image(Bench& bench) {
  const Time begin = bench.now();
  while (bench.now() < begin + 2s) {
    bench.drive({}, kControlPeriod);
    const std::vector<Sample> images = bench.of(SensorType::camera);
    if (!images.empty() && images.back().measured >= begin) return std::get<Picture>(images.back().data).image();
  }
  throw Failure("no image arrived within 2 s");
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

/// How an image may be misread: where the colour that belongs to a pixel is found.
struct Misreading {
  const char* what = "";
  bool swapped = false;      ///< red for blue
  bool mirrored = false;     ///< left for right
  bool upside_down = false;  ///< top for bottom
};

/// The mean difference [levels of 255] between a misread image and what is there.
double difference(const RGBDImage& image, const RGBDImage& truth, const Misreading& how) {
  const auto width = static_cast<std::size_t>(truth.intrinsics.width);
  const auto height = static_cast<std::size_t>(truth.intrinsics.height);
  long sum = 0;
  for (std::size_t y = 0; y < height; ++y) {
    for (std::size_t x = 0; x < width; ++x) {
      const std::size_t row = how.upside_down ? height - 1 - y : y;
      const std::size_t column = how.mirrored ? width - 1 - x : x;
      for (std::size_t c = 0; c < 3; ++c) {
        const std::size_t channel = how.swapped ? 2 - c : c;
        sum += std::abs(image.color[3 * (row * width + column) + channel] - truth.color[3 * (y * width + x) + c]);
      }
    }
  }
  return static_cast<double>(sum) / static_cast<double>(truth.color.size());
}

/// An image, and what a perfect camera at the same place would show.
std::pair<RGBDImage, RGBDImage> image_and_truth(Bench& bench) {
  applies_if(bench.port().truth() != nullptr, "the world is not simulated: it has no truth");
  const CameraSpec& spec = *bench.profile().camera;
  RGBDImage image = next_image(bench);
  const Pose2D eye = bench.port().truth()->true_pose() * spec.base_from_camera;
  RGBDImage truth = bench.port().truth()->look(spec.intrinsics(), eye, spec.mount_height, false).image;
  expect(image.color.size() == truth.color.size(), "the image has {} colours, and not {}", image.color.size(),
         truth.color.size());
  return {std::move(image), std::move(truth)};
}

void images_show_what_is_there(const Context& context) {
  Bench bench = with_camera(context);
  const auto [image, truth] = image_and_truth(bench);
  const double fit = difference(image, truth, {});
  for (const Misreading& how :
       {Misreading{.what = "left for right", .mirrored = true}, {.what = "upside down", .upside_down = true}}) {
    const double other = difference(image, truth, how);
    expect(fit <= other + 1.0, "the image is off by {:.1f} levels of 255 from what is there; read {} by {:.1f}", fit,
           how.what, other);
  }
  expect(fit <= 20.0, "the image is off by {:.1f} levels of 255 from what is there", fit);
}

void images_are_blue_green_red(const Context& context) {
  Bench bench = with_camera(context);
  const auto [image, truth] = image_and_truth(bench);
  const Misreading swapped{.what = "red for blue", .swapped = true};
  applies_if(difference(truth, truth, swapped) >= 2.0, "too little colour in sight to tell red from blue");
  const double fit = difference(image, truth, {});
  const double other = difference(image, truth, swapped);
  expect(fit < other, "the image is off by {:.1f} levels of 255 from what is there; read red for blue by {:.1f}", fit,
         other);
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
  const auto misfit_of = [&](auto read) {
    const std::vector<Vec2> points = horizon(image, bench.profile().camera->base_from_camera, read);
    applies_if(points.size() >= 20 && seen.size() >= 20, "too little stands on the horizon");
    return misfit(seen, points, {});
  };
  const double fit = misfit_of([](double depth, double) { return depth; });
  const std::pair<const char*, double> others[] = {
      {"along each pixel's ray", misfit_of([](double depth, double stretch) { return depth / stretch; })},
      {"as twice as much", misfit_of([](double depth, double) { return 2.0 * depth; })},
      {"as half as much", misfit_of([](double depth, double) { return 0.5 * depth; })}};
  for (const auto& [how, other] : others) {
    expect(fit <= other + 0.01, "depth fits the scan within {:.3f} m; read {} within {:.3f} m", fit, how, other);
  }
  expect(fit <= 0.2, "depth fits the scan within {:.3f} m only", fit);
}

constexpr Check kChecks[] = {
    {"images_have_the_profiles_size", images_have_the_profiles_size},
    {"image_intrinsics_are_the_profiles", image_intrinsics_are_the_profiles},
    {"images_follow_the_robot", images_follow_the_robot},
    {"images_show_what_is_there", images_show_what_is_there},
    {"images_are_blue_green_red", images_are_blue_green_red},
    {"depth_is_there_if_promised", depth_is_there_if_promised},
    {"depth_is_valid", depth_is_valid},
    {"depth_agrees_with_lidar", depth_agrees_with_lidar},
};

}  // namespace

std::span<const Check> camera_checks() { return kChecks; }

}  // namespace threewe::backend::conformance
