#include "models/camera.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/targets.hpp"

using namespace threewe;
using namespace threewe::models;

namespace {

CameraSpec camera() { return *load_profile("3we_depth_v2").camera; }

RngKey key(std::uint64_t seed) { return {.seed = seed, .stream = Stream::camera}; }

struct Moments {
  double mean = 0.0;
  double sigma = 0.0;
};

template <class Values>
Moments moments_of(const Values& values) {
  Moments m;
  for (const double v : values) m.mean += v;
  m.mean /= static_cast<double>(values.size());
  for (const double v : values) m.sigma += (v - m.mean) * (v - m.mean);
  m.sigma = std::sqrt(m.sigma / static_cast<double>(values.size()));
  return m;
}

// The deviations that a grey image of some value gets.
std::vector<double> color_noise(const CameraSpec& spec, std::uint64_t seed, std::uint64_t image, std::size_t size) {
  std::vector<std::uint8_t> color(size, 128);
  add_color_noise(spec, key(seed), image, color);
  return {color.begin(), color.end()};
}

double correlation(const std::vector<double>& a, const std::vector<double>& b) {
  const Moments ma = moments_of(a);
  const Moments mb = moments_of(b);
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - ma.mean) * (b[i] - mb.mean);
  return sum / (static_cast<double>(a.size()) * ma.sigma * mb.sigma);
}

}  // namespace

TEST_CASE("colours scatter by as many levels as the profile says") {
  for (const double sigma : {1.0, 3.0, 10.0, 30.0}) {
    CameraSpec spec = camera();
    spec.sigma = sigma;
    const Moments m = moments_of(color_noise(spec, 1, 7, 300'000));
    CHECK(std::fabs(m.mean - 128.0) < 0.01 * sigma + 0.01);
    CHECK(m.sigma == doctest::Approx(std::sqrt(sigma * sigma + 1.0 / 12.0)).epsilon(0.01));  // of whole levels
  }
}

TEST_CASE("each colour of each image has noise of its own") {
  const CameraSpec spec = camera();
  constexpr std::size_t kSize = 300'000;
  const std::vector<double> noise = color_noise(spec, 1, 7, kSize);
  const double trifle = 4.0 / std::sqrt(static_cast<double>(kSize));
  for (const auto& [seed, image] : {std::pair{1, 8}, std::pair{2, 7}, std::pair{1, 1'000'000}}) {
    const auto other = color_noise(spec, static_cast<std::uint64_t>(seed), static_cast<std::uint64_t>(image), kSize);
    CHECK(std::fabs(correlation(noise, other)) < trifle);
  }
  for (const int apart : {1, 2, 3, 64, 128, 640 * 3}) {
    const std::vector<double> front(noise.begin(), noise.end() - apart);
    const std::vector<double> back(noise.begin() + apart, noise.end());
    CHECK(std::fabs(correlation(front, back)) < trifle);
  }
}

TEST_CASE("black stays black or above, white white or below") {
  CameraSpec spec = camera();
  spec.sigma = 40.0;
  std::vector<std::uint8_t> color(1000, 0);
  std::fill_n(color.begin(), 500, 255);
  add_color_noise(spec, key(3), 0, color);
  const std::span<const std::uint8_t> all(color);
  CHECK(std::ranges::count(all.first(500), 255) > 150);
  CHECK(std::ranges::count(all.last(500), 0) > 150);
  CHECK(*std::ranges::min_element(all.first(500)) > 100);
  CHECK(*std::ranges::max_element(all.last(500)) < 155);
}

TEST_CASE("depth scatters with the square of the depth") {
  const DepthSpec spec = *camera().depth;
  for (const double truth : {0.8, 2.0, 5.0}) {
    std::vector<float> depth(100'000, static_cast<float>(truth));
    measure_depth(spec, key(4), 2, depth);
    const Moments m = moments_of(depth);
    const double sigma = spec.sigma * truth * truth;
    CHECK(std::fabs(m.mean - truth) < 0.02 * sigma);
    CHECK(m.sigma == doctest::Approx(sigma).epsilon(0.01));
  }
}

TEST_CASE("what is out of a depth camera's range, or not there, is invalid") {
  const DepthSpec spec = *camera().depth;
  std::vector<float> depth(3000, 0.0F);
  std::fill_n(depth.begin(), 1000, static_cast<float>(spec.range_min) - 0.1F);
  std::fill_n(depth.begin() + 1000, 1000, static_cast<float>(spec.range_max) + 1.5F);
  measure_depth(spec, key(5), 0, depth);
  CHECK(std::ranges::count(depth, 0.0F) == 3000);
  std::ranges::fill(depth, static_cast<float>(spec.range_max));
  measure_depth(spec, key(5), 0, depth);
  for (const float d : depth) CHECK((d == 0.0F || (d > 7.0F && d <= static_cast<float>(spec.range_max))));
}

TEST_CASE("an ideal camera tells what there is") {
  const CameraSpec spec = *with_noise(load_profile("3we_depth_v2"), NoiseLevel::ideal).camera;
  const auto noise = color_noise(spec, 1, 0, 1000);
  CHECK(std::ranges::count(noise, 128.0) == 1000);
  std::vector<float> depth(777, 3.21F);
  measure_depth(*spec.depth, key(1), 0, depth);
  CHECK(std::ranges::count(depth, 3.21F) == 777);
}

TEST_CASE("noise has the same bits on every target, and whatever the image's size") {
  const CameraSpec spec = camera();
  std::vector<double> longest;
  std::vector<float> farthest;
  for (const std::string& target : available_targets()) {
    force_target(target);
    for (const std::size_t size : {std::size_t{1}, std::size_t{63}, std::size_t{128}, std::size_t{1000}}) {
      const auto noise = color_noise(spec, 9, 3, size);
      std::vector<float> depth(size, 2.5F);
      measure_depth(*spec.depth, key(9), 3, depth);
      if (longest.empty()) {
        longest = color_noise(spec, 9, 3, 1000);
        farthest.assign(1000, 2.5F);
        measure_depth(*spec.depth, key(9), 3, farthest);
      }
      CHECK(std::equal(noise.begin(), noise.end(), longest.begin()));
      CHECK(std::equal(depth.begin(), depth.end(), farthest.begin()));
    }
  }
  force_target("");
}

TEST_CASE("colour gains: light times exposure, and a normal draw for each channel of each episode") {
  Variation variation;
  CHECK(color_gains(variation, key(3)) == std::array{1.0, 1.0, 1.0});
  variation.light = 0.8;
  variation.exposure = 1.5;
  CHECK(color_gains(variation, key(3)) == std::array{0.8 * 1.5, 0.8 * 1.5, 0.8 * 1.5});

  variation.color_jitter = 0.05;
  std::array<std::vector<double>, 3> gains;
  for (std::uint32_t episode = 0; episode < 20'000; ++episode) {
    RngKey of_episode = key(3);
    of_episode.episode = episode;
    const auto drawn = color_gains(variation, of_episode);
    CHECK(drawn == color_gains(variation, of_episode));
    for (std::size_t i = 0; i < 3; ++i) gains[i].push_back(drawn[i] / (0.8 * 1.5));
  }
  for (const auto& channel : gains) {
    const Moments m = moments_of(channel);
    CHECK(std::fabs(m.mean - 1.0) < 0.002);
    CHECK(m.sigma == doctest::Approx(0.05).epsilon(0.02));
  }
  CHECK(std::fabs(correlation(gains[0], gains[1])) < 0.03);
  CHECK(std::fabs(correlation(gains[1], gains[2])) < 0.03);

  variation.color_jitter = 100.0;  // never dark beyond black
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    for (const double gain : color_gains(variation, key(seed))) CHECK(gain >= 0.0);
  }
}

TEST_CASE("a camera varies from its profile by what is said, and is the profile's otherwise") {
  const CameraSpec spec = camera();
  const CameraSpec same = varied(spec, {});
  CHECK(same.base_from_camera == spec.base_from_camera);
  CHECK(same.mount_height == spec.mount_height);
  CHECK(same.sigma == spec.sigma);
  CHECK(same.depth->sigma == spec.depth->sigma);

  Variation variation;
  variation.camera_offset = {0.01, 0.02, 0.03};
  variation.camera_height = -0.05;
  variation.camera_noise = 2.0;
  const CameraSpec other = varied(spec, variation);
  CHECK(other.base_from_camera.x == spec.base_from_camera.x + 0.01);
  CHECK(other.base_from_camera.y == spec.base_from_camera.y + 0.02);
  CHECK(other.base_from_camera.theta == spec.base_from_camera.theta + 0.03);
  CHECK(other.mount_height == spec.mount_height - 0.05);
  CHECK(other.sigma == 2.0 * spec.sigma);
  CHECK(other.depth->sigma == 2.0 * spec.depth->sigma);
  CHECK(other.depth->range_max == spec.depth->range_max);
}
