#include "vision/integer_network.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "threewe/core/errors.hpp"

namespace threewe::vision {
namespace {

using nlohmann::json;

constexpr std::size_t kMostLayers = 200;
constexpr std::size_t kMostChannels = 1024;
constexpr std::int32_t kMostShift = 15;
constexpr std::size_t kMostCoarse = 5;  // times that features may be halved

// Reads one convolution and arranges its weights for the kernel. Throws ConfigError where a sum could overflow.
Convolution read_convolution(const TensorFile& file, const std::string& name, std::size_t inputs, std::size_t outputs,
                             std::size_t size, std::size_t stride) {
  Convolution layer{inputs, outputs, size, stride, {}, {}, {}};
  const auto& weights = file.array(name + ".weight", {outputs, size, size, inputs});
  const auto& bias = file.array(name + ".bias", {outputs});
  const auto& shift = file.array(name + ".shift", {outputs});
  const std::size_t taps = size * size;
  layer.weights.assign(taps * inputs * layer.padded(), 0);
  layer.bias.assign(layer.padded(), 0);
  layer.shift.assign(layer.padded(), 1);
  for (std::size_t o = 0; o < outputs; ++o) {
    if (shift[o] < 1 || shift[o] > kMostShift)
      file.fail(fmt::format("'{}.shift' must be 1 to {}, not {}", name, kMostShift, shift[o]));
    std::int64_t most = std::abs(static_cast<std::int64_t>(bias[o]));
    for (std::size_t k = 0; k < taps * inputs; ++k) {
      const std::int32_t weight = weights[o * taps * inputs + k];
      if (weight != static_cast<std::int16_t>(weight)) file.fail(fmt::format("'{}.weight' is beyond 16 bits", name));
      most += std::abs(static_cast<std::int64_t>(weight)) * kMostFeature;
      const std::size_t tap = k / inputs;
      const std::size_t i = k % inputs;
      layer.weights[((tap * inputs / 2 + i / 2) * layer.padded() + o) * 2 + i % 2] = static_cast<std::int16_t>(weight);
    }
    if (most > std::numeric_limits<std::int32_t>::max())
      file.fail(fmt::format("'{}' could overflow in channel {}: its weights are too large", name, o));
    layer.bias[o] = bias[o];
    layer.shift[o] = shift[o];
  }
  return layer;
}

void fold_pixels(std::span<const std::uint8_t> picture, std::size_t height, std::size_t width, Features& into) {
  into.resize(height / 2, width / 2, kPixelChannels);
  for (std::size_t y = 0; y < into.height; ++y) {
    for (std::size_t x = 0; x < into.width; ++x) {
      std::int16_t* to = into.cell(y, x);
      for (std::size_t i = 0; i < 4; ++i) {
        const std::uint8_t* from = picture.data() + ((2 * y + i / 2) * width + 2 * x + i % 2) * 3;
        to = std::copy_n(from, 3, to);
      }
    }
  }
}

void merge(const Features& coarse, const Features& fine, Features& into) {
  into.resize(fine.height, fine.width, fine.channels);
  for (std::size_t y = 0; y < fine.height; ++y) {
    for (std::size_t x = 0; x < fine.width; ++x) {
      const std::int16_t* a = coarse.cell(y / 2, x / 2);
      const std::int16_t* b = fine.cell(y, x);
      std::int16_t* to = into.cell(y, x);
      for (std::size_t c = 0; c < fine.channels; ++c)
        to[c] = static_cast<std::int16_t>(std::min(a[c] + b[c], kMostFeature));
    }
  }
}

}  // namespace

IntegerNetwork::IntegerNetwork(const TensorFile& file) {
  struct Shape {
    std::string name;
    std::size_t channels;
    std::size_t coarse;  // how often it has been halved
  };
  std::vector<Shape> known{{"pixels", kPixelChannels, 1}};
  const auto find = [&](const json& name) {
    const auto found = std::ranges::find(known, name.get<std::string>(), &Shape::name);
    if (found == known.end()) file.fail(fmt::format("no layer '{}' comes before it is used", name.get<std::string>()));
    return static_cast<std::size_t>(found - known.begin());
  };
  const auto number = [&](const json& layer, const char* key, std::size_t low, std::size_t high) {
    const auto value = layer.at(key).get<std::int64_t>();
    if (std::cmp_less(value, low) || std::cmp_greater(value, high))
      file.fail(fmt::format("{} must be {} to {}, not {}", key, low, high, value));
    return static_cast<std::size_t>(value);
  };
  try {
    const json layers = json::parse(file.text("layers"));
    if (!layers.is_array() || layers.empty() || layers.size() > kMostLayers)
      file.fail(fmt::format("'layers' must be a list of 1 to {}", kMostLayers));
    for (const json& entry : layers) {
      if (!layers_.empty() && layers_.back().kind == Kind::head) file.fail("nothing may follow the head");
      const auto name = entry.at("name").get<std::string>();
      const auto kind = entry.at("kind").get<std::string>();
      Layer layer;
      layer.input = find(entry.at("input"));
      const Shape input = known[layer.input];
      Shape output{name, 0, input.coarse};
      if (entry.contains("add")) layer.add = find(entry.at("add"));
      if (kind == "merge") {
        layer.kind = Kind::merge;
        if (!layer.add || known[*layer.add].coarse + 1 != input.coarse || known[*layer.add].channels != input.channels)
          file.fail(fmt::format("'{}' must add a layer of twice the size and as many channels", name));
        output = {name, input.channels, input.coarse - 1};
      } else if (kind == "convolution" || kind == "head") {
        const bool head = kind == "head";
        layer.kind = head ? Kind::head : Kind::convolution;
        const std::size_t outputs = number(entry, "outputs", 1, kMostChannels);
        const std::size_t size = head ? 1 : number(entry, "size", 1, 3);
        const std::size_t stride = head ? 1 : number(entry, "stride", 1, 2);
        if (size == 2 || (!head && outputs % 2 != 0))
          file.fail(fmt::format("'{}' must be of size 1 or 3, with an even number of outputs", name));
        layer.convolution = read_convolution(file, name, input.channels, outputs, size, stride);
        output = {name, outputs, input.coarse + stride - 1};
        if (output.coarse > kMostCoarse) file.fail(fmt::format("'{}' is too coarse", name));
        if (layer.add && (head || known[*layer.add].coarse != output.coarse || known[*layer.add].channels != outputs))
          file.fail(fmt::format("'{}' must add a layer of its own shape", name));
      } else {
        file.fail(fmt::format("'{}' must be of kind convolution, merge or head, not {}", name, kind));
      }
      layers_.push_back(std::move(layer));
      known.push_back(std::move(output));
    }
  } catch (const json::exception& error) {
    file.fail(fmt::format("its layers cannot be read: {}", error.what()));
  }
  if (layers_.back().kind != Kind::head || known.back().coarse != 3)
    file.fail("its last layer must be a head on 1/8 of the picture's size");
}

std::vector<std::int32_t> IntegerNetwork::run(std::span<const std::uint8_t> picture, std::size_t height,
                                              std::size_t width) const {
  std::vector<Features> features(layers_.size());
  std::vector<std::int32_t> sums;
  fold_pixels(picture, height, width, features[0]);
  for (std::size_t i = 0; i < layers_.size(); ++i) {
    const Layer& layer = layers_[i];
    const Features& input = features[layer.input];
    const Features* add = layer.add ? &features[*layer.add] : nullptr;
    if (layer.kind == Kind::merge) {
      merge(input, features[layer.add.value()], features[i + 1]);
    } else if (layer.kind == Kind::convolution) {
      convolve(layer.convolution, input, add, features[i + 1]);
    } else {
      convolve_to_sums(layer.convolution, input, sums);
    }
  }
  return sums;
}

}  // namespace threewe::vision
