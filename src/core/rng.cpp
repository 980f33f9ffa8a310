#include "threewe/core/rng.hpp"

#include <hwy/highway.h>

#include "threewe/core/exact.hpp"
#include "threewe/core/normal-inl.hpp"

namespace threewe {
namespace {

struct WordPair {
  std::uint32_t high;
  std::uint32_t low;
};

WordPair multiply(std::uint32_t a, std::uint32_t b) {
  const std::uint64_t product = std::uint64_t{a} * b;
  return {static_cast<std::uint32_t>(product >> 32), static_cast<std::uint32_t>(product)};
}

// Ten rounds of Philox4x32 with the published multipliers and Weyl increments.
std::array<std::uint32_t, 4> philox(std::array<std::uint32_t, 4> c, std::uint32_t k0, std::uint32_t k1) {
  for (int round = 0; round < 10; ++round) {
    const WordPair p0 = multiply(0xD2511F53U, c[0]);
    const WordPair p1 = multiply(0xCD9E8D57U, c[2]);
    c = {p1.high ^ c[1] ^ k0, p1.low, p0.high ^ c[3] ^ k1, p0.low};
    k0 += 0x9E3779B9U;
    k1 += 0xBB67AE85U;
  }
  return c;
}

std::uint64_t random_word(const RngKey& key, std::uint64_t sample, std::uint32_t lane) {
  const auto bits = random_bits(key, sample, lane);
  return std::uint64_t{bits[0]} << 32 | bits[1];
}

}  // namespace

std::array<std::uint32_t, 4> random_bits(const RngKey& key, std::uint64_t sample, std::uint32_t lane) {
  // the seed is the key; everything else is spread over the counter, each field in bits of its own:
  // sample 48, lane 16, episode 32, robot 12, sensor 12, stream 8
  const auto place = static_cast<std::uint32_t>((key.robot & 0xFFFU) << 20 | (key.sensor & 0xFFFU) << 8 |
                                                (static_cast<std::uint32_t>(key.stream) & 0xFFU));
  const auto high = static_cast<std::uint32_t>((sample >> 32 & 0xFFFFU) << 16 | (lane & 0xFFFFU));
  return philox({static_cast<std::uint32_t>(sample), high, key.episode, place}, static_cast<std::uint32_t>(key.seed),
                static_cast<std::uint32_t>(key.seed >> 32));
}

double uniform(const RngKey& key, std::uint64_t sample, std::uint32_t lane) {
  return static_cast<double>(random_word(key, sample, lane) >> 11) * 0x1p-53;
}

double uniform(const RngKey& key, std::uint64_t sample, std::uint32_t lane, double low, double high) {
  return low + (high - low) * uniform(key, sample, lane);
}

double normal(const RngKey& key, std::uint64_t sample, std::uint32_t lane) {
  // the middles of 2^52 equal steps: none is rounded to 0 or 1, where the quantile is infinite
  return normal_quantile((static_cast<double>(random_word(key, sample, lane) >> 12) + 0.5) * 0x1p-52);
}

double normal_quantile(double p) {
  const double q = p - 0.5;

  // the middle 85 %
  if (q <= HWY_NAMESPACE::kNormalMiddle && q >= -HWY_NAMESPACE::kNormalMiddle) {
    return HWY_NAMESPACE::normal_middle(q);
  }

  // the tails
  double r = exact::sqrt(-exact::log(q < 0.0 ? p : 1.0 - p));
  double value = 0.0;
  if (r <= HWY_NAMESPACE::kNormalTail) {
    value = HWY_NAMESPACE::normal_tail(r);
  } else {
    r -= 5.0;
    value = (((((((2.01033439929228813265e-7 * r + 2.71155556874348757815e-5) * r + 0.0012426609473880784386) * r +
                 0.026532189526576123093) *
                    r +
                0.29656057182850489123) *
                   r +
               1.7848265399172913358) *
                  r +
              5.4637849111641143699) *
                 r +
             6.6579046435011037772) /
            (((((((2.04426310338993978564e-15 * r + 1.4215117583164458887e-7) * r + 1.8463183175100546818e-5) * r +
                 7.868691311456132591e-4) *
                    r +
                0.0148753612908506148525) *
                   r +
               0.13692988092273580531) *
                  r +
              0.59983220655588793769) *
                 r +
             1.0);
  }
  return q < 0.0 ? -value : value;
}

}  // namespace threewe
