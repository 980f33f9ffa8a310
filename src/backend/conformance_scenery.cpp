// Whether images show what stands around the robot, the right way round and in the right colours. Renderers differ in
// colours, light and texture: outlines and depth are what all of them share.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <utility>
#include <vector>

#include "backend/conformance_images.hpp"
#include "threewe/scene/truth_view.hpp"

namespace threewe::backend::conformance {

namespace {

/// A small image of one number for each pixel, row by row.
struct Small {
  std::size_t width = 0;
  std::size_t height = 0;
  std::vector<double> values;

  double at(std::size_t x, std::size_t y) const { return values[y * width + x]; }
};

constexpr std::size_t kBlock = 4;  // pixels a side that become one: texture and noise cancel, outlines stay

template <typename Value>
Small shrunk(const CameraIntrinsics& camera, Value value) {
  Small small{static_cast<std::size_t>(camera.width) / kBlock, static_cast<std::size_t>(camera.height) / kBlock, {}};
  for (std::size_t y = 0; y < small.height; ++y) {
    for (std::size_t x = 0; x < small.width; ++x) {
      double sum = 0.0;
      for (std::size_t i = 0; i < kBlock * kBlock; ++i) {
        sum += value((y * kBlock + i / kBlock) * static_cast<std::size_t>(camera.width) + x * kBlock + i % kBlock);
      }
      small.values.push_back(sum / static_cast<double>(kBlock * kBlock));
    }
  }
  return small;
}

Small brightness(const RGBDImage& image) {
  return shrunk(image.intrinsics, [&image](std::size_t i) {
    return (image.color[3 * i] + image.color[3 * i + 1] + image.color[3 * i + 2]) / 3.0;
  });
}

/// Red less blue [levels of 255].
Small redness(const RGBDImage& image) {
  return shrunk(image.intrinsics,
                [&image](std::size_t i) { return static_cast<double>(image.color[3 * i + 2] - image.color[3 * i]); });
}

/// How much each pixel differs from those around it.
Small edges(const Small& image) {
  Small found{image.width, image.height, std::vector<double>(image.values.size())};
  for (std::size_t y = 1; y + 1 < image.height; ++y) {
    for (std::size_t x = 1; x + 1 < image.width; ++x) {
      found.values[y * image.width + x] = std::max(std::abs(image.at(x + 1, y) - image.at(x - 1, y)),
                                                   std::abs(image.at(x, y + 1) - image.at(x, y - 1)));
    }
  }
  return found;
}

/// Where one thing ends and another begins in what is truly there.
std::vector<bool> outlines(const SemanticImage& truth) {
  const auto width = static_cast<std::size_t>(truth.image.intrinsics.width);
  const std::size_t columns = width / kBlock;
  const std::size_t rows = static_cast<std::size_t>(truth.image.intrinsics.height) / kBlock;
  const auto id = [&](std::size_t x, std::size_t y) {
    return truth.ids[(y * kBlock + kBlock / 2) * width + x * kBlock + kBlock / 2];
  };
  std::vector<bool> found(columns * rows);
  for (std::size_t y = 1; y + 1 < rows; ++y) {
    for (std::size_t x = 1; x + 1 < columns; ++x) {
      found[y * columns + x] = id(x - 1, y) != id(x + 1, y) || id(x, y - 1) != id(x, y + 1);
    }
  }
  return found;
}

/// How an image may be misread: where what belongs to a pixel is found.
struct Reading {
  const char* what = "";
  bool mirrored = false;     ///< left for right
  bool upside_down = false;  ///< top for bottom
};
constexpr Reading kAsIs{};
constexpr Reading kMisread[] = {
    {"left for right", true, false}, {"upside down", false, true}, {"turned round", true, true}};

/// Images from several headings and what is truly there to be seen.
struct View {
  RGBDImage image;
  SemanticImage truth;
};

std::vector<View> look_around(Bench& bench) {
  constexpr int kHeadings = 3;
  const scene::TruthView* truth = bench.truth();
  if (truth == nullptr) throw NotApplicable("the world is not simulated: it has no truth");
  const CameraSpec& spec = *bench.profile().camera;
  std::vector<View> views;
  for (int i = 0; i < kHeadings; ++i) {
    if (i > 0) bench.drive_and_stop({0.0, 0.0, bench.turning()}, from_seconds(0.6 / bench.turning()));
    RGBDImage image = next_image(bench);
    SemanticImage there =
        truth->look(spec.intrinsics(), truth->true_pose() * spec.base_from_camera, spec.mount_height, false);
    expect(image.color.size() == there.image.color.size(), "an image with {} colours, and not {}", image.color.size(),
           there.image.color.size());
    views.push_back({std::move(image), std::move(there)});
  }
  return views;
}

/// How much more an image changes at the outlines of what is there than elsewhere: 1 for an image of something else.
double contrast_at_outlines(const std::vector<View>& views, const Reading& how) {
  double at_outlines = 0.0;
  double all = 0.0;
  double outlined = 0.0;
  double pixels = 0.0;
  for (const View& view : views) {
    const Small changes = edges(brightness(view.image));
    const std::vector<bool> outline = outlines(view.truth);
    for (std::size_t y = 0; y < changes.height; ++y) {
      for (std::size_t x = 0; x < changes.width; ++x) {
        const double change =
            changes.at(how.mirrored ? changes.width - 1 - x : x, how.upside_down ? changes.height - 1 - y : y);
        all += change;
        pixels += 1.0;
        if (!outline[y * changes.width + x]) continue;
        at_outlines += change;
        outlined += 1.0;
      }
    }
  }
  if (outlined == 0.0) throw NotApplicable("nothing stands out in sight of the camera");
  return all == 0.0 ? 0.0 : (at_outlines / outlined) / (all / pixels);
}

void images_show_what_is_there(const Context& context) {
  constexpr double kLeast = 1.3;
  Bench bench = with_camera(context);
  const std::vector<View> views = look_around(bench);
  const double fit = contrast_at_outlines(views, kAsIs);
  for (const Reading& how : kMisread) {
    const double other = contrast_at_outlines(views, how);
    expect(other <= 1.1 * fit || other < kLeast,
           "images change {:.1f} times as much at the outlines of what is there as elsewhere; read {} {:.1f} times",
           fit, how.what, other);
  }
  expect(fit >= kLeast,
         "images change {:.1f} times as much at the outlines of what is there as elsewhere, which is no more than by "
         "chance: do they show the scene, from the true pose, at the mount's height?",
         fit);
}

/// The share of pixels whose depth is the true one, of those that have both.
double share_of_true_depth(const std::vector<View>& views, const Reading& how) {
  double right = 0.0;
  double all = 0.0;
  for (const View& view : views) {
    const auto width = static_cast<std::size_t>(view.image.intrinsics.width);
    const auto height = static_cast<std::size_t>(view.image.intrinsics.height);
    if (view.image.depth.size() != width * height) throw NotApplicable("images without depth");
    for (std::size_t y = 0; y < height; y += kBlock) {
      for (std::size_t x = 0; x < width; x += kBlock) {
        const std::size_t row = how.upside_down ? height - 1 - y : y;
        const std::size_t column = how.mirrored ? width - 1 - x : x;
        const auto depth = static_cast<double>(view.image.depth[row * width + column]);
        const auto expected = static_cast<double>(view.truth.image.depth[y * width + x]);
        if (depth == 0.0 || expected == 0.0) continue;
        all += 1.0;
        right += std::abs(depth - expected) < 0.05 + 0.05 * expected ? 1.0 : 0.0;
      }
    }
  }
  if (all == 0.0) throw NotApplicable("nothing within the reach of the depth camera");
  return right / all;
}

void depth_shows_what_is_there(const Context& context) {
  constexpr double kLeast = 0.3;  // a simulator may lack furniture, or have more of it
  Bench bench = with_camera(context);
  applies_if(bench.profile().camera->depth.has_value(), "the robot has no camera that measures depth");
  const std::vector<View> views = look_around(bench);
  const double fit = share_of_true_depth(views, kAsIs);
  for (const Reading& how : kMisread) {
    const double other = share_of_true_depth(views, how);
    expect(other <= fit + 0.1, "{:.0f} % of the depths are those of what is there; read {} {:.0f} %", 100.0 * fit,
           how.what, 100.0 * other);
  }
  expect(fit >= kLeast,
         "{:.0f} % of the depths are those of what is there: are they along the optical axis, in metres, from the "
         "mount's height and the true pose?",
         100.0 * fit);
}

/// How badly `after` fits `before` whose columns have moved to the right by `shift`.
double misfit_shifted(const Small& before, const Small& after, int shift) {
  double sum = 0.0;
  double count = 0.0;
  for (std::size_t y = 0; y < before.height; ++y) {
    for (std::size_t x = 0; x < before.width; ++x) {
      const auto to = static_cast<std::ptrdiff_t>(x) + shift;
      if (to < 0 || std::cmp_greater_equal(to, after.width)) continue;
      sum += std::abs(before.at(x, y) - after.at(static_cast<std::size_t>(to), y));
      count += 1.0;
    }
  }
  return sum / count;
}

/// What is seen moves to the right as the robot turns left.
void images_turn_with_the_robot(const Context& context) {
  constexpr double kTurn = 0.15;  // [rad]
  Bench bench = with_camera(context);
  double right = 0.0;
  double left = 0.0;
  for (int i = 0; i < 3; ++i) {
    const Small before = brightness(next_image(bench));
    const double heading = bench.odometry().pose.theta;
    bench.drive_and_stop({0.0, 0.0, bench.turning()}, from_seconds(kTurn / bench.turning()));
    const double turned = wrap_angle(bench.odometry().pose.theta - heading);
    const RGBDImage image = next_image(bench);
    const Small after = brightness(image);
    const double expected = image.intrinsics.fx * turned / kBlock;
    const auto least = [&](double direction) {  // around what a perfect camera and odometry would show
      double best = misfit_shifted(before, after, static_cast<int>(std::lround(direction * expected)));
      for (int percent = 60; percent <= 140; percent += 5) {
        const auto shift = static_cast<int>(std::lround(direction * 0.01 * percent * expected));
        best = std::min(best, misfit_shifted(before, after, shift));
      }
      return best;
    };
    right += least(1.0) / 3.0;
    left += least(-1.0) / 3.0;
  }
  expect(right <= 1.15 * left + 0.5,
         "as the robot turns left, what images show moves to the left: shifted so they differ by {:.1f} levels of 255, "
         "by {:.1f} shifted to the right. Are columns in reverse, or is the image upside down?",
         left, right);
}

/// By the thing in the middle of the image whose colour the caller states.
void expect_color_ahead(Bench& bench, const std::string& color) {
  constexpr double kColored = 20.0;  // [levels of 255] that red and blue must differ
  const Small found = redness(next_image(bench));
  double sum = 0.0;
  double count = 0.0;
  for (std::size_t y = found.height / 3; y < 2 * found.height / 3; ++y) {
    for (std::size_t x = found.width / 3; x < 2 * found.width / 3; ++x, count += 1.0) sum += found.at(x, y);
  }
  const double red = (color == "red" ? 1.0 : -1.0) * sum / count;
  expect(red > -kColored,
         "what is ahead is {}, but has {:.0f} levels of 255 more of the other colour: channel 0 must be "
         "blue, 2 red",
         color, -red);
  expect(red > kColored,
         "the middle of the image is neither red nor blue (they differ by {:.0f} levels of 255): color_"
         "ahead says that it is {}",
         std::abs(red), color);
}

/// Only a renderer with the scene's own colours can be compared with the truth; of others the caller must state one.
void images_are_blue_green_red(const Context& context) {
  Bench bench = with_camera(context);
  if (!context.surroundings.color_ahead.empty()) return expect_color_ahead(bench, context.surroundings.color_ahead);
  constexpr const char* kState =
      "no colour ahead of the robot is known: put something red or blue there, and state it (color_ahead)";
  applies_if(bench.truth() != nullptr, kState);
  double colored = 0.0;
  double as_is = 0.0;
  double swapped = 0.0;
  for (const View& view : look_around(bench)) {
    const Small seen = redness(view.image);
    const Small there = redness(view.truth.image);
    for (std::size_t i = 0; i < seen.values.size(); ++i) {
      colored += std::abs(there.values[i]);
      as_is += std::abs(seen.values[i] - there.values[i]);
      swapped += std::abs(-seen.values[i] - there.values[i]);
    }
  }
  expect(swapped > 0.25 * colored || as_is < swapped,
         "images have the scene's colours with red and blue exchanged: channel 0 must be blue, 2 red");
  applies_if(as_is <= 0.5 * colored, kState);
}

constexpr Check kSceneryChecks[] = {
    {"images_turn_with_the_robot", images_turn_with_the_robot},
    {"images_show_what_is_there", images_show_what_is_there},
    {"images_are_blue_green_red", images_are_blue_green_red},
    {"depth_shows_what_is_there", depth_shows_what_is_there},
};

}  // namespace

std::span<const Check> scenery_checks() { return kSceneryChecks; }

}  // namespace threewe::backend::conformance
