// The localizer's parameters by robot profile.
#include <doctest/doctest.h>

#include <string>

#include "hardware/parameters.hpp"
#include "nav/autonomy.hpp"
#include "threewe/core/errors.hpp"
#include "threewe/hardware/profile.hpp"

namespace threewe::slam {
namespace {

RobotProfile with_autonomy(const std::string& section) {
  return parse_profile(load_profile("3we_standard_v2").yaml + "\nautonomy: " + section + "\n", "mine.yaml");
}

TEST_CASE("the reference robot has the defaults of slam, to the bit") {
  Params defaults;
  Params reference = *params_for(load_profile("3we_standard_v2"));
  const Parameters expected = parameters_of(defaults);
  const Parameters fields = parameters_of(reference);
  REQUIRE(fields.size() == expected.size());
  for (std::size_t i = 0; i < fields.size(); ++i) {
    CAPTURE(fields[i].name);
    CHECK(fields[i].number() == expected[i].number());
  }
}

TEST_CASE("the robots of the catalogue keep maps of 5 cm, one three times as large has coarser ones") {
  for (const char* name : {"turtlebot_like", "3we_base_v2", "3we_depth_v2"}) {
    CAPTURE(name);
    CHECK(make_localizer(load_profile(name))->map().resolution == 0.05);
  }
  RobotProfile large = load_profile("3we_standard_v2");
  large.body.footprint = Footprint::rectangle(0.75, 0.66);
  CHECK(make_localizer(large)->map().resolution == 0.2);
}

TEST_CASE("a profile overrides the resolution, and the robot's map has it") {
  CHECK(make_localizer(with_autonomy("{slam: {map_resolution: 0.1}}"))->map().resolution == 0.1);
  CHECK_THROWS_AS(make_localizer(with_autonomy("{slam: {map_resolutoin: 0.1}}")), ConfigError);
}

}  // namespace
}  // namespace threewe::slam
