// Eight cells and one vector of output channels at a time; two input channels are multiplied and added by one
// instruction. The sums are integers, so that no order of them changes a bit.
#include "vision/convolution.hpp"

#include <algorithm>
#include <array>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "vision/convolution.cpp"
#include "core/highway-inl.hpp"

#ifndef THREEWE_VISION_CONVOLUTION_ONCE
#define THREEWE_VISION_CONVOLUTION_ONCE
namespace threewe::vision {

inline constexpr std::size_t kCells = 8;  // at a time

// The sums of up to kCells neighbouring cells, all of their channels.
struct SumsOf {
  const Convolution* layer;
  std::size_t row;                                // values from one input row to the next
  std::array<const std::int16_t*, kCells> cells;  // the first input cell of each
  std::int32_t* sums;                             // (kCells, padded outputs)
};

}  // namespace threewe::vision
#endif

HWY_BEFORE_NAMESPACE();
namespace threewe::vision::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR

void add_up(const SumsOf& work) {
  const Convolution& layer = *work.layer;
  const std::size_t padded = layer.padded();
  for (std::size_t cell = 0; cell < kCells; ++cell) {
    std::int32_t* sums = work.sums + cell * padded;
    std::copy(layer.bias.begin(), layer.bias.end(), sums);
    const std::int16_t* weights = layer.weights.data();
    for (std::size_t tap = 0; tap < layer.size * layer.size; ++tap) {
      const std::int16_t* from = work.cells[cell] + tap / layer.size * work.row + tap % layer.size * layer.inputs;
      for (std::size_t i = 0; i < layer.inputs; i += 2) {
        for (std::size_t o = 0; o < padded; ++o, weights += 2)
          sums[o] += from[i] * weights[0] + from[i + 1] * weights[1];
      }
    }
  }
}

#else

void add_up(const SumsOf& work) {
  const Convolution& layer = *work.layer;
  const hn::CappedTag<std::int32_t, kChannelBlock> sums_tag;
  const hn::Repartition<std::int16_t, decltype(sums_tag)> tag;
  const std::size_t lanes = hn::Lanes(sums_tag);
  const std::size_t padded = layer.padded();
  for (std::size_t block = 0; block < padded; block += lanes) {
    const auto bias = hn::LoadU(sums_tag, layer.bias.data() + block);
    auto a = bias, b = bias, c = bias, d = bias, e = bias, f = bias, g = bias, h = bias;
    const std::int16_t* weights = layer.weights.data() + 2 * block;
    for (std::size_t tap = 0; tap < layer.size * layer.size; ++tap) {
      const std::size_t begin = tap / layer.size * work.row + tap % layer.size * layer.inputs;
      for (std::size_t i = begin; i < begin + layer.inputs; i += 2, weights += 2 * padded) {
        const auto weight = hn::LoadU(tag, weights);
        const auto add = [&](auto& sum, std::size_t cell) {
          std::int32_t pair;
          __builtin_memcpy(&pair, work.cells[cell] + i, sizeof(pair));
          auto upper = hn::Zero(sums_tag);
          const auto products = hn::ReorderWidenMulAccumulate(sums_tag, hn::BitCast(tag, hn::Set(sums_tag, pair)),
                                                              weight, hn::Zero(sums_tag), upper);
          sum = hn::Add(sum, hn::RearrangeToOddPlusEven(products, upper));
        };
        add(a, 0), add(b, 1), add(c, 2), add(d, 3), add(e, 4), add(f, 5), add(g, 6), add(h, 7);
      }
    }
    std::int32_t* to = work.sums + block;
    for (const auto* sum : {&a, &b, &c, &d, &e, &f, &g, &h}) {
      hn::StoreU(*sum, sums_tag, to);
      to += padded;
    }
  }
}

#endif

}  // namespace threewe::vision::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace threewe::vision {

HWY_EXPORT(add_up);

namespace {

// Calls `take(y, x, sums)` for every output cell.
template <class Take>
void for_each_cell(const Convolution& layer, const Features& input, std::size_t height, std::size_t width,
                   const Take& take) {
  const std::size_t padded = layer.padded();
  std::vector<std::int32_t> sums(kCells * padded);
  const std::size_t border = layer.size / 2;
  for (std::size_t y = 0; y < height; ++y) {
    for (std::size_t x = 0; x < width; x += kCells) {
      SumsOf work{&layer, input.row(), {}, sums.data()};
      for (std::size_t i = 0; i < kCells; ++i) {
        const std::size_t column = std::min(x + i, width - 1) * layer.stride;
        work.cells[i] = input.values.data() + (y * layer.stride + 1 - border) * input.row() +
                        (column + 1 - border) * input.channels;
      }
      HWY_DYNAMIC_DISPATCH(add_up)(work);
      for (std::size_t i = 0; i < std::min(kCells, width - x); ++i) take(y, x + i, sums.data() + i * padded);
    }
  }
}

}  // namespace

void Features::resize(std::size_t new_height, std::size_t new_width, std::size_t new_channels) {
  height = new_height;
  width = new_width;
  channels = new_channels;
  values.assign((height + 2) * row(), 0);
}

void convolve(const Convolution& layer, const Features& input, const Features* add, Features& output) {
  const std::size_t height = (input.height - 1) / layer.stride + 1;
  const std::size_t width = (input.width - 1) / layer.stride + 1;
  output.resize(height, width, layer.outputs);
  for_each_cell(layer, input, height, width, [&](std::size_t y, std::size_t x, const std::int32_t* sums) {
    std::int16_t* to = output.cell(y, x);
    const std::int16_t* more = add != nullptr ? add->cell(y, x) : nullptr;
    for (std::size_t c = 0; c < layer.outputs; ++c) {
      const std::int32_t shift = layer.shift[c];
      const std::int32_t rounded = ((sums[c] >> (shift - 1)) + 1) >> 1;
      const std::int32_t sum = rounded + (more != nullptr ? more[c] : 0);
      to[c] = static_cast<std::int16_t>(std::clamp(sum, 0, kMostFeature));
    }
  });
}

void convolve_to_sums(const Convolution& layer, const Features& input, std::vector<std::int32_t>& sums) {
  const std::size_t padded = layer.padded();
  sums.resize(input.height * input.width * padded);
  for_each_cell(layer, input, input.height, input.width, [&](std::size_t y, std::size_t x, const std::int32_t* from) {
    std::copy_n(from, padded, sums.data() + (y * input.width + x) * padded);
  });
}

}  // namespace threewe::vision
#endif
