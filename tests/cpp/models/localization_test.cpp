#include "threewe/models/localization.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "draw.hpp"
#include "mistakes.hpp"
#include "models/localization_error.hpp"
#include "threewe/core/assets.hpp"
#include "threewe/core/errors.hpp"

using namespace threewe;
using namespace threewe::models;

namespace {

RngKey key_of(std::uint64_t seed) { return {.seed = seed, .stream = Stream::localization}; }

// Every part on, with figures that tell them apart.
LocalizationSpec noisy() {
  LocalizationSpec spec;
  spec.map = {.turn = 0.02, .stretch = 0.01, .heading = 0.03, .length = 8.0};
  spec.local = {.position = 0.05, .length = 2.0};
  spec.noise = {.position = 0.004, .heading = 0.005};
  return spec;
}

// Drives from the origin to `goal` in `steps` corrections, and tells the error there.
Pose2D error_at(const LocalizationSpec& spec, std::uint64_t seed, Vec2 goal, int steps) {
  LocalizationState state;
  for (int i = 1; i <= steps; ++i) {
    const double share = static_cast<double>(i) / steps;
    const Pose2D truth{share * goal.x, share * goal.y, 0.3};
    correct_localization(spec, key_of(seed), static_cast<std::uint64_t>(i - 1), truth, truth, state);
  }
  const Pose2D believed = state.map_from_base;
  return {believed.x - goal.x, believed.y - goal.y, wrap_angle(believed.theta - 0.3)};
}

// Standard deviations of the error over many episodes.
struct Spread {
  double x = 0.0;
  double y = 0.0;
  double theta = 0.0;
};

Spread spread_at(const LocalizationSpec& spec, Vec2 goal, int steps) {
  constexpr int kEpisodes = 20'000;  // deviations are then within 2 % (four of their own)
  Spread squares;
  for (std::uint64_t seed = 0; seed < kEpisodes; ++seed) {
    const Pose2D error = error_at(spec, seed, goal, steps);
    squares.x += error.x * error.x;
    squares.y += error.y * error.y;
    squares.theta += error.theta * error.theta;
  }
  return {std::sqrt(squares.x / kEpisodes), std::sqrt(squares.y / kEpisodes), std::sqrt(squares.theta / kEpisodes)};
}

// The share of its variance that a process has reached after a distance.
double grown(double distance, double length) { return 1.0 - std::exp(-2.0 * distance / length); }

double squared(double x) { return x * x; }

std::string shipped_text() {
  std::ostringstream text;
  text << std::ifstream(find_asset("localization", "slam_v2")).rdbuf();
  return text.str();
}

std::string error_of(const std::string& text) {
  const std::string file = (std::filesystem::temp_directory_path() / "threewe_localization_test.yaml").string();
  std::ofstream(file) << text;
  try {
    load_localization(file);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("a perfect correction gives the truth to the bit") {
  Draw draw(1);
  LocalizationState state;
  for (std::uint64_t correction = 0; correction < 1000; ++correction) {
    const Pose2D truth = draw.pose(-20.0, 20.0);
    const Pose2D odometry = draw.pose(-20.0, 20.0);
    correct_localization({}, key_of(1), correction, truth, odometry, state);
    CHECK(localized_pose(state, odometry) == truth);
  }
}

TEST_CASE("never corrected, it is odometry") {
  Draw draw(2);
  for (int i = 0; i < 1000; ++i) {
    const Pose2D odometry = draw.pose(-20.0, 20.0);
    const Pose2D pose = localized_pose({}, odometry);
    CHECK(pose == odometry);
  }
}

TEST_CASE("between corrections it moves exactly as odometry does") {
  Draw draw(3);
  for (std::uint64_t seed = 0; seed < cases(1000); ++seed) {
    CAPTURE(seed);
    const Pose2D truth = draw.pose(-20.0, 20.0);
    const Pose2D odometry = draw.pose(-20.0, 20.0);
    const Pose2D moved = draw.pose(-1.0, 1.0);
    LocalizationState state;
    correct_localization(noisy(), key_of(seed), 0, truth, odometry, state);
    const Pose2D map_from_odom = state.map_from_base * inverse(odometry);
    const Pose2D expected = map_from_odom * (odometry * moved);
    const Pose2D pose = localized_pose(state, odometry * moved);
    CHECK(distance(pose.position(), expected.position()) < 1e-12);
    CHECK(std::fabs(wrap_angle(pose.theta - expected.theta)) < 1e-12);
  }
}

TEST_CASE("errors have the stated spread, however far, in whichever direction and in however many steps") {
  const LocalizationSpec spec = noisy();
  struct Case {
    Vec2 goal;
    int steps;
  };
  for (const auto& [goal, steps] : {Case{{0.5, 0.0}, 1}, {{6.0, 0.0}, 1}, {{6.0, 0.0}, 30}, {{-3.0, 4.0}, 5}}) {
    CAPTURE(goal.x);
    CAPTURE(steps);
    const double r = norm(goal);
    const double map = grown(r, spec.map.length);
    const double same = squared(spec.local.position) * grown(r, spec.local.length) + squared(spec.noise.position);
    const double turn = squared(spec.map.turn) * map;
    const double stretch = squared(spec.map.stretch) * map;
    const Spread found = spread_at(spec, goal, steps);
    CHECK(found.x ==
          doctest::Approx(std::sqrt(stretch * squared(goal.x) + turn * squared(goal.y) + same)).epsilon(0.02));
    CHECK(found.y ==
          doctest::Approx(std::sqrt(stretch * squared(goal.y) + turn * squared(goal.x) + same)).epsilon(0.02));
    CHECK(
        found.theta ==
        doctest::Approx(std::sqrt(turn + squared(spec.map.heading) * map + squared(spec.noise.heading))).epsilon(0.02));
  }
}

TEST_CASE("what is slow forgets itself over its length, and is normal") {
  // the heading after 8 m, and 4 m farther on
  LocalizationSpec spec;
  spec.map = {.heading = 0.03, .length = 8.0};
  constexpr int kEpisodes = 20'000;
  constexpr int kSteps = 12;
  double products = 0.0;
  std::vector<double> headings;
  for (std::uint64_t seed = 0; seed < kEpisodes; ++seed) {
    LocalizationState state;
    double before = 0.0;
    for (int i = 1; i <= kSteps; ++i) {
      correct_localization(spec, key_of(seed), static_cast<std::uint64_t>(i), {1.0 * i, 0.0, 0.0}, {}, state);
      if (i == 8) before = state.map_from_base.theta;
    }
    headings.push_back(before / (spec.map.heading * std::sqrt(grown(8.0, 8.0))));
    products += before * state.map_from_base.theta;
  }
  double squares = 0.0;
  double fourths = 0.0;
  double within = 0.0;
  for (const double heading : headings) {
    squares += squared(heading);
    fourths += squared(squared(heading));
    within += std::fabs(heading) < 1.0 ? 1.0 : 0.0;
  }
  const double variance = squared(spec.map.heading) * grown(8.0, 8.0);
  CHECK(products / kEpisodes == doctest::Approx(variance * std::exp(-4.0 / 8.0)).epsilon(0.05));
  CHECK(squares / kEpisodes == doctest::Approx(1.0).epsilon(0.03));
  CHECK(fourths / kEpisodes == doctest::Approx(3.0).epsilon(0.06));
  CHECK(within / kEpisodes == doctest::Approx(0.6827).epsilon(0.015));
}

TEST_CASE("a robot that stands keeps its error but for the scatter") {
  LocalizationSpec spec = noisy();
  LocalizationState state;
  const Pose2D truth{7.0, 0.0, 0.0};
  correct_localization(spec, key_of(5), 0, truth, {}, state);
  const LocalizationState arrived = state;
  Spread squares;
  constexpr int kCorrections = 10'000;
  for (std::uint64_t correction = 1; correction <= kCorrections; ++correction) {
    correct_localization(spec, key_of(5), correction, truth, {}, state);
    squares.x += squared(state.map_from_base.x - truth.x - truth.x * arrived.stretch - arrived.local.x);
    squares.theta += squared(state.map_from_base.theta - arrived.turn - arrived.heading);
  }
  CHECK(state.turn == arrived.turn);
  CHECK(state.local == arrived.local);
  CHECK(std::sqrt(squares.x / kCorrections) == doctest::Approx(spec.noise.position).epsilon(0.03));
  CHECK(std::sqrt(squares.theta / kCorrections) == doctest::Approx(spec.noise.heading).epsilon(0.03));
}

TEST_CASE("each part changes that one thing, and noise is a function of seed, episode, robot and correction") {
  const auto state_of = [](const LocalizationSpec& spec, const RngKey& key) {
    LocalizationState state;
    for (std::uint64_t i = 0; i < 10; ++i) {
      correct_localization(spec, key, i, {0.3 * static_cast<double>(i), 0.1, 0.2}, {}, state);
    }
    return state;
  };
  const RngKey key = key_of(9);
  const LocalizationState all = state_of(noisy(), key);
  LocalizationSpec spec = noisy();
  spec.map.turn = 0.0;
  const LocalizationState no_turn = state_of(spec, key);
  CHECK(no_turn.turn == 0.0);
  CHECK(no_turn.stretch == all.stretch);
  CHECK(no_turn.heading == all.heading);
  CHECK(no_turn.local == all.local);
  spec = noisy();
  spec.local.position = 0.0;
  const LocalizationState no_local = state_of(spec, key);
  CHECK(no_local.local == Vec2{});
  CHECK(no_local.turn == all.turn);
  CHECK(no_local.map_from_base.theta == all.map_from_base.theta);

  CHECK(state_of(noisy(), key).map_from_base == all.map_from_base);
  RngKey other = key;
  other.seed = 10;
  CHECK(state_of(noisy(), other).turn != all.turn);
  other = key;
  other.episode = 1;
  CHECK(state_of(noisy(), other).turn != all.turn);
  other = key;
  other.robot = 1;
  CHECK(state_of(noisy(), other).turn != all.turn);
}

TEST_CASE("the shipped model is that of our own SLAM") {
  CHECK(localization_names() == std::vector<std::string>{"slam_v1", "slam_v2"});
  const LocalizationSpec spec = load_localization("slam_v2");
  CHECK(spec.name == "slam_v2");
  CHECK(spec.period == 100ms);
  CHECK(spec.delay == 20ms);
  CHECK(spec.measured.hardware == "3we_standard_v2");
  CHECK(spec.measured.noise == "realistic");
  // centimetres within a room, and a fraction of a degree
  CHECK(10.0 * spec.map.turn < 0.05);
  CHECK(spec.local.position < 0.05);
  CHECK(spec.map.turn + spec.map.heading < 0.01);
}

TEST_CASE("an unknown model names the nearest, and every mistake its file, its line and what would be right") {
  try {
    load_localization("slam_v22");
    FAIL("did not throw");
  } catch (const ConfigError& error) {
    CHECK(std::string(error.what()) == "unknown localization 'slam_v22'; did you mean 'slam_v2'?");
  }
  CHECK_THROWS_AS(load_localization("no/such/file.yaml"), ConfigError);

  struct Case {
    std::string from;
    std::string to;
    std::string message;
  };
  for (const auto& [from, to, message] : {
           Case{"stretch:", "strech:", "map: missing field 'stretch'; is 'strech' meant to be it?"},
           {"period: 0.1", "period: 100", "period"},
           {"noise: {position:", "noise: {possition:", "noise: missing field 'position'"},
           {"heading: ", "heading: -", "map.heading"},
           {"local:", "locale:", "missing field 'local'"},
       }) {
    CAPTURE(from);
    std::string text = shipped_text();
    const std::size_t at = text.find(from);
    REQUIRE(at != std::string::npos);
    const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n');
    const std::string error = error_of(text.replace(at, from.size(), to));
    CHECK_MESSAGE(error.find(message) != std::string::npos, error);
    CHECK_MESSAGE(error.find(".yaml:" + std::to_string(line) + ":") != std::string::npos, error);
  }
}

TEST_CASE("localisation models with mistakes") {
  const std::string file = (std::filesystem::temp_directory_path() / "threewe_localization_mistakes.yaml").string();
  const std::string text = shipped_text();
  for (std::uint64_t seed = 0; seed < cases(500); ++seed) {
    threewe::testing::read_with_mistakes(text, seed, {file + ":"}, [&](const std::string& spoilt) {
      std::ofstream(file) << spoilt;
      load_localization(file);
    });
  }
  std::filesystem::remove(file);
}
