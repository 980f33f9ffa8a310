// Parameters of the navigator: all of them listed, and those of other robots than the reference robot.
#include "nav/params.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstddef>
#include <set>
#include <string>
#include <string_view>
#include <variant>

#include "hardware/parameters.hpp"
#include "nav/path_navigator.hpp"
#include "scaled.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::nav {
namespace {

// What any field can be made of: an aggregate has as many fields as it takes of these.
struct Anything {
  template <class T>
  operator T() const;  // NOLINT(misc-explicit-constructor)
};
template <class T, class... Fields>
constexpr std::size_t field_count() {
  if constexpr (requires { T{Fields{}..., Anything{}}; }) {
    return field_count<T, Fields..., Anything>();
  } else {
    return sizeof...(Fields);
  }
}

template <class Part>
void check_all_listed() {
  Part part;
  std::set<const void*> places;
  for (const Parameter& parameter : parameters_of(part)) {
    std::visit([&](const auto* value) { places.insert(value); }, parameter.value);
    CHECK_MESSAGE(!parameter.meaning.empty(), parameter.name);
  }
  CHECK(places.size() == parameters_of(part).size());
  CHECK(places.size() == field_count<Part>());
}

TEST_CASE("every field of every part is listed once") {
  check_all_listed<Params::Creep>();
  check_all_listed<Params::Clearance>();
  check_all_listed<Params::Route>();
  check_all_listed<Params::Frontier>();
  check_all_listed<Params::Bottleneck>();
  check_all_listed<Params::Progress>();
  check_all_listed<Params::Motion>();
  check_all_listed<Params::Follower>();
  check_all_listed<Params::Recovery>();
  check_all_listed<Params::NarrowPassage>();
  check_all_listed<Params::Arcs>();
  check_all_listed<Params::Mppi::Weights>();

  Params::Mppi mppi;
  CHECK(parameters_of(mppi).size() == field_count<Params::Mppi>() - 1 + field_count<Params::Mppi::Weights>());
  Params params;
  std::set<std::string> parts;
  std::set<std::string> names;
  for (const Parameter& parameter : parameters_of(params)) {
    parts.insert(parameter.name.substr(0, parameter.name.find('.')));
    names.insert(parameter.name);
  }
  CHECK(parts.size() == field_count<Params>());
  CHECK(names.size() == parameters_of(params).size());
}

TEST_CASE("the reference robot's are the defaults, to the bit") {
  auto params = params_for<Params>(load_profile("3we_standard_v2"), "nav");
  Params defaults;
  const Parameters of_robot = parameters_of(params);
  const Parameters expected = parameters_of(defaults);
  for (std::size_t i = 0; i < expected.size(); ++i) {
    CAPTURE(expected[i].name);
    CHECK(of_robot[i].number() == expected[i].number());
  }
}

// Lengths that people or their buildings have, whatever the robot is like.
bool is_given(std::string_view name) {
  return name == "motion.person_radius" || name == "mppi.people_reach" || name == "mppi.people_blur";
}

TEST_CASE("of a robot three times, or half, as large and fast, lengths and speeds are so too, and nothing else is") {
  for (const double by : {0.5, 3.0}) {
    auto params = params_for<Params>(testing::scaled(load_profile("3we_standard_v2"), by), "nav");
    Params defaults;
    const Parameters of_robot = parameters_of(params);
    const Parameters expected = parameters_of(defaults);
    for (std::size_t i = 0; i < expected.size(); ++i) {
      CAPTURE(expected[i].name);
      CAPTURE(by);
      const bool grows = expected[i].unit.starts_with('m') && !is_given(expected[i].name);
      CHECK(of_robot[i].number() == doctest::Approx((grows ? by : 1.0) * expected[i].number()).epsilon(1e-9));
    }
  }
}

TEST_CASE("a profile overrides what it names, and is told what is nearest to what it cannot mean") {
  RobotProfile profile = load_profile("3we_standard_v2");
  profile.autonomy = {{"nav", "recovery.same_place", 0.25, "robot.yaml:9: same_place"}};
  CHECK(params_for<Params>(profile, "nav").recovery.same_place == 0.25);

  profile.autonomy = {{"nav", "creep.sped", 0.1, "robot.yaml:9: sped"}};
  CHECK_THROWS_WITH_AS(PathNavigator{profile}, doctest::Contains("'creep.speed'"), ConfigError);
}

}  // namespace
}  // namespace threewe::nav
