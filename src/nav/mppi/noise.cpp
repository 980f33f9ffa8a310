#include "nav/mppi/noise.hpp"

#include "core/exact.hpp"
#include "core/rng.hpp"

namespace threewe::nav::mppi {
namespace {

// An autoregressive sequence of the first order for each lane.
std::vector<float> draw_pool() {
  constexpr double kAlike = 0.9;  // correlation of neighbours: half a second at steps of 50 ms
  const double fresh = exact::sqrt(1.0 - kAlike * kAlike);
  const RngKey key{.sensor = 1, .stream = Stream::sampler};
  std::vector<float> pool((kNoiseRows + kSteps) * kBlock);
  for (std::size_t lane = 0; lane < kBlock; ++lane) {
    double value = 0.0;
    for (std::size_t row = 0; row < kNoiseRows + kSteps; ++row) {
      const double drawn = normal(key, row, static_cast<std::uint32_t>(lane));
      value = row == 0 ? drawn : kAlike * value + fresh * drawn;
      pool[row * kBlock + lane] = static_cast<float>(value);
    }
  }
  return pool;
}

}  // namespace

const std::vector<float>& noise_pool() {
  static const std::vector<float> pool = draw_pool();
  return pool;
}

std::vector<Block> draw_blocks(int samples, std::uint32_t means, const std::array<float, 3>& deviation,
                               std::uint64_t seed, std::uint64_t tick) {
  constexpr std::size_t kOthers = 8;
  constexpr float kSmall = 0.1F;
  const RngKey key{.seed = seed, .sensor = 2, .stream = Stream::sampler};
  std::vector<Block> blocks((static_cast<std::size_t>(samples) + kBlock - 1) / kBlock);
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    Block& block = blocks[i];
    const auto words = random_bits(key, tick, static_cast<std::uint32_t>(i));
    const std::size_t other = i / kOthers;
    if (i % kOthers == kOthers - 1 && means > 0) block.mean = 1 + static_cast<std::uint32_t>(other % means);
    for (std::size_t c = 0; c < 3; ++c) {
      const float sign = (words[3] >> c & 1U) != 0 ? -1.0F : 1.0F;
      block.row[c] = words[c] % kNoiseRows;
      block.scale[c] = sign * deviation[c] * (i == 0 ? kSmall : 1.0F);
    }
  }
  return blocks;
}

}  // namespace threewe::nav::mppi
