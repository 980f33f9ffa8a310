#include "hardware/parameters.hpp"

#include <doctest/doctest.h>

#include <string>
#include <variant>

#include "threewe/core/errors.hpp"

using namespace threewe;

namespace {

// A module's parameters, as small as they come.
struct Params {
  struct Recovery {
    double same_place = 0.5;
    Duration patience = 3s;
    int attempts = 8;
    double lateral_offset = 0.0;
  };
  Recovery recovery;
  double creep_speed = 0.04;
};

Parameters parameters_of(Params::Recovery& p) {
  return {{"same_place", &p.same_place, "m", Scale::size, "attempts nearer to each other are in one place"},
          {"patience", &p.patience, "s", Scale::travel, "without progress, before the next attempt"},
          {"attempts", &p.attempts, "", Scale::none, "in one place"},
          {"lateral_offset", &p.lateral_offset, "m", Scale::size, "to the left of the path"}};
}

Parameters parameters_of(Params& p) {
  Parameters all;
  append(all, "recovery", parameters_of(p.recovery));
  all.push_back({"creep_speed", &p.creep_speed, "m/s", Scale::speed, "through narrow passages"});
  return all;
}

RobotProfile with_autonomy(const std::string& section) {
  const std::string text = load_profile("3we_standard_v2").yaml + "\nautonomy:\n" + section;
  return parse_profile(text, "mine.yaml");
}

}  // namespace

TEST_CASE("the reference robot has every scale 1, to the bit") {
  const RobotProfile reference = load_profile("3we_standard_v2");
  const Scales scales = scales_of(reference);
  for (const Scale scale : {Scale::none, Scale::size, Scale::speed, Scale::turn_rate, Scale::travel, Scale::stopping,
                            Scale::reaction, Scale::noise, Scale::bias, Scale::scan, Scale::beam}) {
    CAPTURE(to_string(scale));
    CHECK(scales.of(scale) == 1.0);
  }
  const auto params = params_for<Params>(reference, "nav");
  CHECK(params.recovery.same_place == 0.5);
  CHECK(params.recovery.patience == 3s);
  CHECK(params.creep_speed == 0.04);
}

TEST_CASE("a robot twice as large and half as fast keeps twice the distance and has four times the patience") {
  RobotProfile profile = load_profile("3we_standard_v2");
  profile.body.footprint = Footprint::rectangle(0.5, 0.44);
  profile.operating_limits.linear = 0.25;
  const auto params = params_for<Params>(profile, "nav");
  CHECK(params.recovery.same_place == doctest::Approx(1.0));
  CHECK(params.recovery.patience == 12s);
  CHECK(params.recovery.attempts == 8);
  CHECK(params.creep_speed == doctest::Approx(0.02));
}

TEST_CASE("the size of a robot is half of its least width, wherever its base is") {
  RobotProfile profile = load_profile("3we_standard_v2");
  profile.body.footprint = Footprint({{0.4, -0.2}, {0.4, 0.02}, {-0.1, 0.02}, {-0.1, -0.2}});
  CHECK(scales_of(profile).size == doctest::Approx(1.0));
  CHECK(scales_of(load_profile("turtlebot_like")).size == doctest::Approx(0.0755 / 0.11));
}

TEST_CASE("what a robot has not is as the reference robot's") {
  CHECK(scales_of(load_profile("3we_base_v2")).noise == 1.0);
  CHECK(scales_of(load_profile("3we_base_v2")).beam == 1.0);
  CHECK(scales_of(with_noise(load_profile("3we_standard_v2"), NoiseLevel::ideal)).noise == 1.0);
  CHECK(scales_of(load_profile("turtlebot_like")).beam == doctest::Approx(360.0 / 230.0));
}

TEST_CASE("a profile overrides parameters, of one module") {
  const RobotProfile profile =
      with_autonomy("  nav: {recovery: {same_place: 0.4, patience: 1.5}, creep_speed: 0.02}\n");
  const auto params = params_for<Params>(profile, "nav");
  CHECK(params.recovery.same_place == 0.4);
  CHECK(params.recovery.patience == 1500ms);
  CHECK(params.recovery.attempts == 8);
  CHECK(params.creep_speed == 0.02);
  CHECK(params_for<Params>(profile, "slam").recovery.same_place == 0.5);
}

TEST_CASE("a wrong override names its place and what would be right") {
  const auto resolve = [](const std::string& section) { return params_for<Params>(with_autonomy(section), "nav"); };
  CHECK_THROWS_WITH_AS((void)resolve("  nav: {recovery: {same_plaec: 0.4}}\n"), doctest::Contains("mine.yaml:"),
                       ConfigError);
  CHECK_THROWS_WITH_AS((void)resolve("  nav: {recovery: {same_plaec: 0.4}}\n"),
                       doctest::Contains("did you mean 'recovery.same_place'?"), ConfigError);
  CHECK_THROWS_WITH_AS((void)resolve("  nav: {recovery: {attempts: 2.5}}\n"),
                       doctest::Contains("expected a whole number, such as 8, got 2.5"), ConfigError);
  CHECK_THROWS_WITH_AS((void)resolve("  nav: {creep_speed: 0}\n"),
                       doctest::Contains("expected a number above 0, such as 0.04, got 0"), ConfigError);
  CHECK_THROWS_WITH_AS((void)resolve("  nav: {recovery: {lateral_offset: -1}}\n"), doctest::Contains("no less than 0"),
                       ConfigError);
  CHECK_THROWS_WITH_AS((void)with_autonomy("  nva: {creep_speed: 0.1}\n"), doctest::Contains("nav"), ConfigError);
  CHECK_THROWS_WITH_AS((void)with_autonomy("  nav: {creep_speed: fast}\n"), doctest::Contains("expected a number"),
                       ConfigError);
  CHECK_THROWS_WITH_AS((void)with_autonomy("  nav: {creep_speed: 1e9}\n"), doctest::Contains("is outside"),
                       ConfigError);
}
