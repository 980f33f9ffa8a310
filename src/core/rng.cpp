#include "core/rng.hpp"

#include <span>

#include "core/exact.hpp"

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

// By Horner's rule, the highest power first.
double polynomial(std::span<const double> coefficients, double x) {
  double value = coefficients[0];
  for (const double next : coefficients.subspan(1)) value = value * x + next;
  return value;
}

// A ratio of two polynomials of Wichura's.
struct Ratio {
  std::array<double, 8> numerator;
  std::array<double, 8> denominator;
  double at(double x) const { return polynomial(numerator, x) / polynomial(denominator, x); }
};
constexpr Ratio kMiddle{{2509.0809287301226727, 33430.575583588128105, 67265.770927008700853, 45921.953931549871457,
                         13731.693765509461125, 1971.5909503065514427, 133.14166789178437745, 3.387132872796366608},
                        {5226.495278852545925, 28729.085735721942674, 39307.89580009271061, 21213.794301586595867,
                         5394.1960214247511077, 687.1870074920579083, 42.313330701600911252, 1.0}};
constexpr Ratio kTail{
    {7.7454501427834140764e-4, 0.0227238449892691845833, 0.24178072517745061177, 1.27045825245236838258,
     3.64784832476320460504, 5.7694972214606914055, 4.6303378461565452959, 1.42343711074968357734},
    {1.05075007164441684324e-9, 5.475938084995344946e-4, 0.0151986665636164571966, 0.14810397642748007459,
     0.68976733498510000455, 1.6763848301838038494, 2.05319162663775882187, 1.0}};
constexpr Ratio kFarTail{
    {2.01033439929228813265e-7, 2.71155556874348757815e-5, 0.0012426609473880784386, 0.026532189526576123093,
     0.29656057182850489123, 1.7848265399172913358, 5.4637849111641143699, 6.6579046435011037772},
    {2.04426310338993978564e-15, 1.4215117583164458887e-7, 1.8463183175100546818e-5, 7.868691311456132591e-4,
     0.0148753612908506148525, 0.13692988092273580531, 0.59983220655588793769, 1.0}};

std::uint64_t random_word(const RngKey& key, std::uint64_t sample, std::uint32_t lane) {
  const auto bits = random_bits(key, sample, lane);
  return std::uint64_t{bits[0]} << 32 | bits[1];
}

}  // namespace

std::array<std::uint32_t, 4> random_bits(const RngKey& key, std::uint64_t sample, std::uint32_t lane) {
  // the seed is the key; everything else is spread over the counter, each field in bits of its own:
  // sample 48, lane 16, episode 32, place 32
  const auto high = static_cast<std::uint32_t>((sample >> 32 & 0xFFFFU) << 16 | (lane & 0xFFFFU));
  return philox({static_cast<std::uint32_t>(sample), high, key.episode, key.place()},
                static_cast<std::uint32_t>(key.seed), static_cast<std::uint32_t>(key.seed >> 32));
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

  if (q <= 0.425 && q >= -0.425) {
    const double r = 0.180625 - q * q;
    return q * polynomial(kMiddle.numerator, r) / polynomial(kMiddle.denominator, r);
  }
  const double r = exact::sqrt(-exact::log(q < 0.0 ? p : 1.0 - p));
  const double value = r <= 5.0 ? kTail.at(r - 1.6) : kFarTail.at(r - 5.0);
  return q < 0.0 ? -value : value;
}

}  // namespace threewe
