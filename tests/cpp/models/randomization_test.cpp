// What domain randomisation draws: the right distributions, at the right events, and nothing else.
#include "threewe/models/randomization.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <set>
#include <sstream>
#include <vector>

#include "draw.hpp"
#include "mistakes.hpp"
#include "threewe/core/assets.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::models {
namespace {

Randomization parsed(const std::string& text) { return parse_randomization(text, "test"); }

std::size_t place_of(const std::string& name) {
  const auto& names = knob_names();
  return static_cast<std::size_t>(std::ranges::find(names, name) - names.begin());
}

std::vector<double> drawn(const std::string& distribution, const std::string& name, std::uint32_t count) {
  const Randomization randomization = parsed("reset: {" + name + ": " + distribution + "}");
  std::vector<double> values;
  for (std::uint32_t episode = 0; episode < count; ++episode) {
    values.push_back(knob(draw_variation(randomization, 5, episode, 0), place_of(name)));
  }
  std::ranges::sort(values);
  return values;
}

// The largest difference between the sorted values' distribution and another (Kolmogorov and Smirnov).
template <typename Cumulative>
double distance_to(const std::vector<double>& values, Cumulative cumulative) {
  double worst = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double share = (static_cast<double>(i) + 0.5) / static_cast<double>(values.size());
    worst = std::max(worst, std::fabs(share - cumulative(values[i])));
  }
  return worst;
}

TEST_CASE("each distribution is what it is called") {
  constexpr std::uint32_t kCount = 20'000;
  constexpr double kBound = 1.95 / 141.4;  // passed by one set of true draws in a thousand
  CHECK(distance_to(drawn("[0.9, 1.1]", "mass", kCount), [](double x) { return (x - 0.9) / 0.2; }) < kBound);
  CHECK(distance_to(drawn("{uniform: [0.9, 1.1]}", "mass", kCount), [](double x) { return (x - 0.9) / 0.2; }) < kBound);
  CHECK(distance_to(drawn("{log_uniform: [0.5, 2.0]}", "lidar_noise", kCount),
                    [](double x) { return std::log(x / 0.5) / std::log(4.0); }) < kBound);
  CHECK(distance_to(drawn("{normal: [1.0, 0.1]}", "friction", kCount),
                    [](double x) { return 0.5 * std::erfc((1.0 - x) / 0.1 / std::sqrt(2.0)); }) < kBound);
  const std::vector<double> whole = drawn("{integer: [0, 3]}", "texture", kCount);
  for (const double value : {0.0, 1.0, 2.0, 3.0}) {
    CHECK(std::ranges::count(whole, value) == doctest::Approx(kCount / 4).epsilon(0.05));
  }
  CHECK(drawn("1.05", "mass", 3) == std::vector<double>(3, 1.05));
}

TEST_CASE("one knob changes itself and nothing else, and knobs are independent of each other") {
  for (std::size_t place = 0; place < knob_names().size(); ++place) {
    const std::string& name = knob_names()[place];
    CAPTURE(name);
    Randomization alone;
    alone.reset.push_back({place, {Distribution::Kind::uniform, 0.3, 0.4}});
    Variation changed = draw_variation(alone, 1, 2, 0);
    CHECK(knob(changed, place) >= 0.3);
    knob(changed, place) = knob(Variation{}, place);
    CHECK(changed == Variation{});
  }
  const Randomization both = parsed("reset: {mass: [0.9, 1.1], friction: [0.9, 1.1]}");
  const Randomization one = parsed("reset: {mass: [0.9, 1.1]}");
  double correlation = 0.0;
  for (std::uint32_t i = 0; i < 10'000; ++i) {
    const Variation v = draw_variation(both, 3, i, 0);
    CHECK(v.mass == draw_variation(one, 3, i, 0).mass);
    correlation += (v.mass - 1.0) * (v.friction - 1.0) / (0.01 / 3.0) / 10'000;
  }
  CHECK(std::fabs(correlation) < 0.04);
}

TEST_CASE("events come when they should") {
  const Randomization all = parsed(
      "startup: {mass: [0.9, 1.1]}\nreset: {motor_lag: [0.9, 1.1]}\ninterval: {every: [1.0, 3.0], friction: [0.9, "
      "1.1]}");
  std::set<double> masses;
  std::set<double> lags;
  std::set<double> frictions;
  std::set<Duration> lengths;
  for (std::uint32_t episode = 0; episode < 50; ++episode) {
    for (std::uint64_t draw = 0; draw < 4; ++draw) {
      const Variation v = draw_variation(all, 9, episode, 0, draw);
      masses.insert(v.mass);
      lags.insert(v.motor_lag);
      frictions.insert(v.friction);
      const Duration length = draw_interval(all, 9, episode, draw);
      CHECK(length % kControlPeriod == Duration::zero());
      CHECK(length >= 980ms);
      CHECK(length <= 3s);
      lengths.insert(length);
    }
  }
  CHECK(masses.size() == 1);
  CHECK(lags.size() == 50);
  CHECK(frictions.size() == 1 + 50 * 3);  // as the profile says until the first interval is over
  CHECK(lengths.size() > 50);
  CHECK(draw_variation(all, 9, 0, 1).mass != draw_variation(all, 9, 0, 0).mass);
  CHECK(draw_interval(Randomization{}, 9, 0, 0) == Duration::zero());
}

TEST_CASE("those that come with the library load, and keep to the ranges they promise") {
  CHECK(randomization_names() == std::vector<std::string>{"hard", "mild", "none", "paper"});
  CHECK(draw_variation(load_randomization("none"), 1, 2, 3) == Variation{});
  const Randomization paper = load_randomization("paper");
  for (std::uint32_t episode = 0; episode < 1'000; ++episode) {
    const Variation v = draw_variation(paper, 1, episode, 0);
    CHECK(std::fabs(v.mass - 1.0) <= 0.1);
    CHECK(std::fabs(v.friction - 1.0) <= 0.2);
    CHECK(std::fabs(v.light - 1.0) <= 0.5);
  }
}

TEST_CASE("randomisations with mistakes") {
  for (const std::string& name : randomization_names()) {
    std::ifstream file(find_asset("randomization", name));
    std::stringstream text;
    text << file.rdbuf();
    for (std::uint64_t seed = 0; seed < cases(200); ++seed) {
      threewe::testing::read_with_mistakes(text.str(), seed, {"spoilt:"}, [](const std::string& spoilt) {
        const Randomization read = parse_randomization(spoilt, "spoilt");
        (void)draw_variation(read, 1, 2, 0, 3);
      });
    }
  }
}

}  // namespace
}  // namespace threewe::models
