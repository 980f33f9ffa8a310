// Convolution of 16-bit features with 16-bit weights in 32-bit sums: exact, hence the same bits on every machine.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace threewe::vision {

/// Features are 8.8 fixed-point numbers without sign, below 16.
inline constexpr std::int32_t kMostFeature = 4095;
/// Output channels are padded to a multiple of this.
inline constexpr std::size_t kChannelBlock = 16;

/// (height, width, channels) features within a border of one zero cell on each side.
struct Features {
  std::size_t height = 0;
  std::size_t width = 0;
  std::size_t channels = 0;  ///< even
  std::vector<std::int16_t> values;

  void resize(std::size_t new_height, std::size_t new_width, std::size_t new_channels);
  std::size_t row() const { return (width + 2) * channels; }  ///< values from one row to the next
  std::int16_t* cell(std::size_t y, std::size_t x) { return values.data() + (y + 1) * row() + (x + 1) * channels; }
  const std::int16_t* cell(std::size_t y, std::size_t x) const {
    return values.data() + (y + 1) * row() + (x + 1) * channels;
  }
};

/// Weights of one layer. Sums of channel c have 8 + shift[c] binary places.
struct Convolution {
  std::size_t inputs = 0;             ///< channels, even
  std::size_t outputs = 0;            ///< channels
  std::size_t size = 0;               ///< 1 or 3 cells
  std::size_t stride = 0;             ///< 1 or 2 cells
  std::vector<std::int16_t> weights;  ///< (size * size, inputs / 2, padded outputs, 2)
  std::vector<std::int32_t> bias;     ///< (padded outputs,)
  std::vector<std::int32_t> shift;    ///< (padded outputs,)

  std::size_t padded() const { return (outputs + kChannelBlock - 1) / kChannelBlock * kChannelBlock; }
};

/// The layer's output with ReLU: (sum + bias) >> shift, rounded, within 0 to `kMostFeature`. `add`, where given, has
/// the output's shape and is added before.
void convolve(const Convolution& layer, const Features& input, const Features* add, Features& output);
/// The layer's sums themselves, of size 1: (height, width, padded outputs).
void convolve_to_sums(const Convolution& layer, const Features& input, std::vector<std::int32_t>& sums);

}  // namespace threewe::vision
