#include "vision/convolution.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <utility>

#include "core/rng.hpp"
#include "core/targets.hpp"

using namespace threewe;
using namespace threewe::vision;

namespace {

Features random_features(std::size_t height, std::size_t width, std::size_t channels, const RngKey& key) {
  Features features;
  features.resize(height, width, channels);
  for (std::size_t y = 0; y < height; ++y) {
    for (std::size_t i = 0; i < width * channels; ++i)
      features.cell(y, 0)[i] = static_cast<std::int16_t>(4096.0 * uniform(key, y * width * channels + i));
  }
  return features;
}

Convolution random_layer(std::size_t inputs, std::size_t outputs, std::size_t size, std::size_t stride,
                         const RngKey& key) {
  Convolution layer{inputs, outputs, size, stride, {}, {}, {}};
  layer.weights.assign(size * size * inputs * layer.padded(), 0);
  layer.bias.assign(layer.padded(), 0);
  layer.shift.assign(layer.padded(), 1);
  for (std::size_t i = 0; i < layer.weights.size(); ++i)
    layer.weights[i] = static_cast<std::int16_t>(800.0 * uniform(key, i) - 400.0);
  for (std::size_t o = 0; o < outputs; ++o) {
    layer.bias[o] = static_cast<std::int32_t>(1e6 * uniform(key, o, 1) - 5e5);
    layer.shift[o] = 1 + static_cast<std::int32_t>(14.0 * uniform(key, o, 2));
  }
  return layer;
}

// One output by its definition, in 64 bits.
std::int64_t sum_of(const Convolution& layer, const Features& input, std::size_t y, std::size_t x, std::size_t o) {
  std::int64_t sum = layer.bias[o];
  const auto border = static_cast<std::int64_t>(layer.size / 2);
  for (std::size_t tap = 0; tap < layer.size * layer.size; ++tap) {
    const std::int64_t v = static_cast<std::int64_t>(y * layer.stride + tap / layer.size) - border;
    const std::int64_t u = static_cast<std::int64_t>(x * layer.stride + tap % layer.size) - border;
    if (v < 0 || u < 0 || std::cmp_greater_equal(v, input.height) || std::cmp_greater_equal(u, input.width)) continue;
    for (std::size_t i = 0; i < layer.inputs; ++i) {
      const std::size_t pair = tap * layer.inputs / 2 + i / 2;
      sum += std::int64_t{layer.weights[(pair * layer.padded() + o) * 2 + i % 2]} *
             input.cell(static_cast<std::size_t>(v), static_cast<std::size_t>(u))[i];
    }
  }
  return sum;
}

}  // namespace

TEST_CASE("a convolution is its definition, on every target") {
  for (std::uint32_t seed = 0; seed < 24; ++seed) {
    CAPTURE(seed);
    const RngKey key{seed, 7};
    const std::size_t height = 1 + static_cast<std::size_t>(12.0 * uniform(key, 0, 3));
    const std::size_t width = 1 + static_cast<std::size_t>(20.0 * uniform(key, 1, 3));
    const std::size_t inputs = 2 * (1 + static_cast<std::size_t>(10.0 * uniform(key, 2, 3)));
    const std::size_t outputs = 2 * (1 + static_cast<std::size_t>(20.0 * uniform(key, 3, 3)));
    const Convolution layer = random_layer(inputs, outputs, seed % 2 == 0 ? 3 : 1, 1 + seed / 2 % 2, key);
    const Features input = random_features(height, width, inputs, key);
    const Features add = random_features((height - 1) / layer.stride + 1, (width - 1) / layer.stride + 1, outputs, key);
    for (const std::string& target : available_targets()) {
      CAPTURE(target);
      force_target(target);
      Features output;
      convolve(layer, input, seed % 3 == 0 ? &add : nullptr, output);
      int wrong = 0;
      for (std::size_t y = 0; y < output.height; ++y) {
        for (std::size_t x = 0; x < output.width; ++x) {
          for (std::size_t o = 0; o < outputs; ++o) {
            const std::int64_t half = std::int64_t{1} << (layer.shift[o] - 1);
            std::int64_t right = (sum_of(layer, input, y, x, o) + half) >> layer.shift[o];
            if (seed % 3 == 0) right += add.cell(y, x)[o];
            if (output.cell(y, x)[o] != std::clamp<std::int64_t>(right, 0, kMostFeature)) ++wrong;
          }
        }
      }
      CHECK(wrong == 0);
    }
    force_target("");
  }
}
