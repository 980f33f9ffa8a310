// Convolutional network in integer arithmetic: its outputs have the same bits on every machine.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "vision/convolution.hpp"
#include "vision/tensor_file.hpp"

namespace threewe::vision {

/// Pixels, blue, green and red of every 2 x 2 in a row, are the first layer's input.
inline constexpr std::size_t kPixelChannels = 12;

/// Const once read.
class IntegerNetwork {
 public:
  IntegerNetwork() = default;
  /// Layers as the file's metadata list them under "layers", a JSON array of {name, kind, input, ...}: kind
  /// "convolution" with {outputs, size, stride} and an optional "add", the layer whose output is added; "merge" with
  /// "add", which is added to the input, each of whose cells is repeated 2 x 2; and at the end "head" with {outputs}.
  /// Throws ConfigError where that makes no sense, and for weights whose sums could overflow.
  explicit IntegerNetwork(const TensorFile& file);

  std::size_t outputs() const { return layers_.empty() ? 0 : layers_.back().convolution.outputs; }
  /// Binary places of output `i`.
  int places(std::size_t i) const { return 8 + layers_.back().convolution.shift[i]; }
  /// The head's sums, (height / 8, width / 8, outputs padded to 16), of a picture (height, width, 3). Height and width
  /// are multiples of 8.
  std::vector<std::int32_t> run(std::span<const std::uint8_t> picture, std::size_t height, std::size_t width) const;
  /// From one cell's outputs to the next one's.
  std::size_t padded_outputs() const { return layers_.back().convolution.padded(); }

 private:
  enum class Kind : std::uint8_t { convolution, merge, head };
  struct Layer {
    Kind kind{};
    std::size_t input = 0;  // 0 for pixels, else one more than a layer's index
    std::optional<std::size_t> add;
    Convolution convolution;  // of a merge: its channels alone
  };
  std::vector<Layer> layers_;
};

}  // namespace threewe::vision
