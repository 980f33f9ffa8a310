#include "core/rng.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <vector>

namespace threewe {
namespace {

constexpr int kSamples = 100000;

double normal_cdf(double x) { return 0.5 * std::erfc(-x / std::sqrt(2.0)); }

// The Kolmogorov-Smirnov distance of uniform values, times the root of their number: above 1.95 once in 1,000 times.
double ks_statistic(std::vector<double> values) {
  std::ranges::sort(values);
  const auto n = static_cast<double>(values.size());
  double worst = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto k = static_cast<double>(i);
    worst = std::max({worst, values[i] - k / n, (k + 1) / n - values[i]});
  }
  return worst * std::sqrt(n);
}

// Known answers for Philox4x32-10, from the kat_vectors of the Random123 distribution. The counter's four words are
// spelled by the fields of the key: sample (low 32 bits), lane and sample (high 16), episode, place.
TEST_CASE("Philox gives the published answers") {
  using Words = std::array<std::uint32_t, 4>;
  CHECK(random_bits({}, 0, 0) == Words{0x6627e8d5U, 0xe169c58dU, 0xbc57ac4cU, 0x9b00dbd8U});

  const RngKey ones{
      .seed = ~std::uint64_t{0}, .episode = ~0U, .robot = 0xfff, .sensor = 0xfff, .stream = static_cast<Stream>(0xffU)};
  CHECK(random_bits(ones, 0xffffffffffffULL, 0xffffU) == Words{0x408f276dU, 0x41c83b0eU, 0xa20bc7c6U, 0x6d5451fdU});

  // counter 243f6a88 85a308d3 13198a2e 03707344, key a4093822 299f31d0: the digits of pi
  const RngKey pi{.seed = 0x299f31d0a4093822ULL,
                  .episode = 0x13198a2eU,
                  .robot = 0x037,
                  .sensor = 0x073,
                  .stream = static_cast<Stream>(0x44U)};
  CHECK(random_bits(pi, 0x85a3243f6a88ULL, 0x08d3U) == Words{0xd16cfe09U, 0x94fdccebU, 0x5001e420U, 0x24126ea1U});
}

TEST_CASE("every part of the key matters") {
  const RngKey key{.seed = 7, .episode = 3, .robot = 1, .sensor = 2, .stream = Stream::lidar};
  std::set<std::array<std::uint32_t, 4>> seen{random_bits(key, 5, 6)};
  const auto is_new = [&](const RngKey& other, std::uint64_t sample, std::uint32_t lane) {
    return seen.insert(random_bits(other, sample, lane)).second;
  };
  RngKey other = key;
  other.seed = 8;
  CHECK(is_new(other, 5, 6));
  other.seed = 7 + (std::uint64_t{1} << 40);
  CHECK(is_new(other, 5, 6));
  other = key, other.episode = 4;
  CHECK(is_new(other, 5, 6));
  other = key, other.robot = 2;
  CHECK(is_new(other, 5, 6));
  other = key, other.sensor = 3;
  CHECK(is_new(other, 5, 6));
  other = key, other.stream = Stream::imu;
  CHECK(is_new(other, 5, 6));
  CHECK(is_new(key, 6, 6));
  CHECK(is_new(key, 5 + (std::uint64_t{1} << 32), 6));
  CHECK(is_new(key, 5, 7));
  CHECK_FALSE(is_new(key, 5, 6));
}

TEST_CASE("uniform numbers are uniform") {
  const RngKey key{.seed = 11};
  std::vector<double> values;
  double sum = 0.0;
  double squares = 0.0;
  for (std::uint64_t i = 0; i < kSamples; ++i) {
    const double u = uniform(key, i);
    REQUIRE(u >= 0.0);
    REQUIRE(u < 1.0);
    sum += u;
    squares += u * u;
    values.push_back(u);
  }
  CHECK(sum / kSamples == doctest::Approx(0.5).epsilon(0.01));
  CHECK(squares / kSamples - std::pow(sum / kSamples, 2) == doctest::Approx(1.0 / 12).epsilon(0.02));
  CHECK(ks_statistic(values) < 1.95);

  const double low = uniform(key, 3, 4, -2.0, 5.0);
  CHECK(low == -2.0 + 7.0 * uniform(key, 3, 4));
}

TEST_CASE("normal numbers are normal") {
  const RngKey key{.seed = 12, .stream = Stream::lidar};
  std::vector<double> values;
  double moment[5] = {};
  for (std::uint64_t i = 0; i < kSamples; ++i) {
    const double z = normal(key, i);
    for (int k = 1; k <= 4; ++k) moment[k] += std::pow(z, k) / kSamples;
    values.push_back(normal_cdf(z));
  }
  CHECK(std::fabs(moment[1]) < 0.015);
  CHECK(moment[2] == doctest::Approx(1.0).epsilon(0.02));
  CHECK(std::fabs(moment[3]) < 0.05);
  CHECK(moment[4] == doctest::Approx(3.0).epsilon(0.05));
  CHECK(ks_statistic(values) < 1.95);
}

TEST_CASE("streams, sensors, robots, episodes and seeds are independent of one another") {
  const RngKey key{.seed = 13, .episode = 1, .robot = 1, .sensor = 1, .stream = Stream::imu};
  std::vector<RngKey> others(5, key);
  others[0].stream = Stream::odometry;
  others[1].sensor = 2;
  others[2].robot = 2;
  others[3].episode = 2;
  others[4].seed = 14;
  for (const RngKey& other : others) {
    double correlation = 0.0;
    for (std::uint64_t i = 0; i < kSamples; ++i) correlation += normal(key, i) * normal(other, i);
    CHECK(std::fabs(correlation) / std::sqrt(kSamples) < 4.0);
  }
  // and so are neighbouring samples and lanes of one stream
  double samples = 0.0;
  double lanes = 0.0;
  for (std::uint64_t i = 0; i < kSamples; ++i) {
    samples += normal(key, i) * normal(key, i + 1);
    lanes += normal(key, i, 0) * normal(key, i, 1);
  }
  CHECK(std::fabs(samples) / std::sqrt(kSamples) < 4.0);
  CHECK(std::fabs(lanes) / std::sqrt(kSamples) < 4.0);
}

TEST_CASE("the normal quantile inverts the distribution function") {
  CHECK(normal_quantile(0.5) == 0.0);
  CHECK(normal_quantile(0.975) == doctest::Approx(1.959963984540054).epsilon(1e-15));
  CHECK(normal_quantile(1e-10) == doctest::Approx(-6.361340902404056).epsilon(1e-14));
  CHECK(normal_quantile(1e-300) == doctest::Approx(-37.04709629936121).epsilon(1e-14));
  for (double p = 0x1p-54; p < 0.5; p *= 1.37) {
    CAPTURE(p);
    CHECK(normal_cdf(normal_quantile(p)) == doctest::Approx(p).epsilon(1e-12));
  }
  for (double p = 0x1p-53; p < 0.5; p *= 2.0) {
    CAPTURE(p);
    CHECK(normal_quantile(1.0 - p) == -normal_quantile(p));
  }
  double last = -std::numeric_limits<double>::infinity();
  for (double p = 1e-4; p < 1.0; p += 1e-4) {
    const double z = normal_quantile(p);
    REQUIRE(z > last);  // also where the middle meets the tails
    last = z;
  }
}

}  // namespace
}  // namespace threewe
