// Vector functions on every target of this machine, forced in turn: the same bits on all, near the truth on each.
#include "core/targets.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "core/exact.hpp"
#include "threewe/core/errors.hpp"
#include "threewe/core/pose.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/targets_test.cpp"
#include "core/highway-inl.hpp"
//
#include "core/exact-inl.hpp"
#include "core/pose-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace threewe::HWY_NAMESPACE {

// `count` is a multiple of 16.
void angles(const float* y, const float* x, std::size_t count, float* out) {
  namespace hn = hwy::HWY_NAMESPACE;
  const hn::CappedTag<float, 16> d;
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    hn::StoreU(exact::HWY_NAMESPACE::atan2(d, hn::LoadU(d, y + i), hn::LoadU(d, x + i)), d, out + i);
  }
}

// Sines and cosines of `count` angles, a multiple of 8, and where an arc along each leads.
void arcs(const double* angles, std::size_t count, double* out) {
  namespace hn = hwy::HWY_NAMESPACE;
  const hn::CappedTag<double, 8> d;
  using V = hn::Vec<decltype(d)>;
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    const V angle = hn::LoadU(d, angles + i);
    const auto [s, c] = exact::HWY_NAMESPACE::sincos(angle);
    const V one = hn::Set(d, 1.0);
    const Pose2DOf<V> end = integrate<V>({one, one, angle}, {one, one, angle}, hn::Set(d, 0.01));
    hn::StoreU(s, d, out + i);
    hn::StoreU(c, d, out + count + i);
    hn::StoreU(end.x, d, out + 2 * count + i);
    hn::StoreU(end.y, d, out + 3 * count + i);
    hn::StoreU(end.theta, d, out + 4 * count + i);
  }
}

}  // namespace threewe::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace threewe {
HWY_EXPORT(angles);
HWY_EXPORT(arcs);

namespace {

// Runs `action` on each available target and requires the same bits every time.
template <class Action>
std::vector<float> on_all_targets(const Action& action) {
  const std::vector<float> expected = action();
  for (const std::string& target : available_targets()) {
    force_target(target);
    REQUIRE(active_target() == target);
    const std::vector<float> result = action();
    CAPTURE(target);
    REQUIRE(result.size() == expected.size());
    for (std::size_t i = 0; i < result.size(); ++i) {
      CAPTURE(i);
      REQUIRE(std::bit_cast<std::uint32_t>(result[i]) == std::bit_cast<std::uint32_t>(expected[i]));
    }
    force_target("");
  }
  if (available_targets().size() < 2) MESSAGE("not shown: this machine has one target only");
  return expected;
}

TEST_CASE("a vector of doubles has the sines, cosines and arcs that numbers have, to the bit") {
  std::mt19937_64 random(7);
  const auto draw = [&](double size) { return size * (2.0 * (static_cast<double>(random() >> 11) * 0x1p-53) - 1.0); };
  std::vector<double> angles{0.0, -0.0};
  for (int i = 0; i < 20'000; ++i) {
    for (const double size : {1e-5, 0.03, 0.8, 4.0, 100.0, 1e5, 9e8}) angles.push_back(draw(size));
    // around the borders of octants
    const double border = std::round(draw(40.0)) * exact::kPi / 4;
    for (const double side : {border, std::nextafter(border, 1e9), std::nextafter(border, -1e9)}) {
      angles.push_back(side);
    }
  }
  while (angles.size() % 8 != 0) angles.push_back(0.0);

  const auto bits = [](double x) { return std::bit_cast<std::uint64_t>(x); };
  std::vector<double> out(5 * angles.size());
  for (const std::string& target : available_targets()) {
    CAPTURE(target);
    force_target(target);
    HWY_DYNAMIC_DISPATCH(arcs)(angles.data(), angles.size(), out.data());
    for (std::size_t i = 0; i < angles.size(); ++i) {
      CAPTURE(angles[i]);
      const auto [s, c] = exact::sincos(angles[i]);
      const Pose2D end = threewe::integrate({1.0, 1.0, angles[i]}, {1.0, 1.0, angles[i]}, 0.01);
      REQUIRE(bits(out[i]) == bits(s));
      REQUIRE(bits(out[angles.size() + i]) == bits(c));
      REQUIRE(bits(out[2 * angles.size() + i]) == bits(end.x));
      REQUIRE(bits(out[3 * angles.size() + i]) == bits(end.y));
      REQUIRE(bits(out[4 * angles.size() + i]) == bits(end.theta));
    }
  }
  force_target("");
}

TEST_CASE("targets can be listed and forced by name") {
  const auto available = available_targets();
  const auto compiled = compiled_targets();
  REQUIRE_FALSE(available.empty());
  CHECK(compiled.back() == "SCALAR");
  for (const std::string& target : available) CHECK(std::ranges::count(compiled, target) == 1);
  CHECK(active_target() == available.front());
  force_target("SCALAR");
  CHECK(active_target() == "SCALAR");
  CHECK(available_targets() == available);
  CHECK_THROWS_WITH_AS(force_target("SCALER"), "unknown target 'SCALER'; did you mean 'SCALAR'?", ConfigError);
  CHECK(active_target() == "SCALAR");
  force_target("");
  CHECK(active_target() == available.front());
}

TEST_CASE("sums in one fixed order") {
  std::mt19937_64 bits(1);
  std::uniform_real_distribution<float> draw(-1.0F, 1.0F);
  std::vector<float> values(1000);
  for (float& value : values) value = draw(bits) * std::exp(10.0F * draw(bits));  // an order would show
  const auto sums = on_all_targets([&] {
    std::vector<float> results;
    for (std::size_t n = 0; n <= values.size(); ++n) results.push_back(exact::sum(std::span(values).first(n)));
    return results;
  });
  CHECK(sums[0] == 0.0F);
  CHECK(sums[1] == values[0]);
  for (std::size_t n = 0; n <= values.size(); ++n) {
    double truth = 0.0;
    double magnitude = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      truth += static_cast<double>(values[i]);
      magnitude += std::fabs(static_cast<double>(values[i]));
    }
    REQUIRE(std::fabs(static_cast<double>(sums[n]) - truth) <= 1e-5 * magnitude);
  }
  std::vector<float> backwards(values.rbegin(), values.rend());
  CHECK(exact::sum(backwards) != exact::sum(values));  // else the order could not have shown
}

TEST_CASE("angles of vectors are within 4e-7 of the truth, in order, and finite at the origin") {
  std::mt19937_64 bits(2);
  std::uniform_real_distribution<float> draw(-1.0F, 1.0F);
  std::vector<float> y;
  std::vector<float> x;
  for (const float vertical : {0.0F, -0.0F, 1.0F, -1.0F}) {
    for (const float horizontal : {0.0F, -0.0F, 1.0F, -1.0F}) y.push_back(vertical), x.push_back(horizontal);
  }
  while (y.size() < 32768) {
    y.push_back(draw(bits) * std::exp(8.0F * draw(bits)));
    x.push_back(draw(bits) * std::exp(8.0F * draw(bits)));
  }
  const auto results = on_all_targets([&] {
    std::vector<float> out(y.size());
    HWY_DYNAMIC_DISPATCH(angles)(y.data(), x.data(), y.size(), out.data());
    return out;
  });
  double worst = 0.0;
  for (std::size_t i = 0; i < y.size(); ++i) {
    REQUIRE(std::isfinite(results[i]));
    if (x[i] == 0.0F && y[i] == 0.0F) continue;
    CAPTURE(y[i]);
    CAPTURE(x[i]);
    const double truth = std::atan2(static_cast<double>(y[i]), static_cast<double>(x[i]));
    const double error = std::fabs(static_cast<double>(results[i]) - truth);
    worst = std::max(worst, std::min(error, std::fabs(error - 2 * exact::kPi)));
    REQUIRE(worst <= 4e-7);
  }
  MESSAGE("worst error ", worst, " rad");
}

}  // namespace
}  // namespace threewe
#endif
