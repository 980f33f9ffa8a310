#include "safety/params.hpp"

#include <doctest/doctest.h>

#include <set>
#include <string>

#include "hardware/parameters.hpp"
#include "safety/gate.hpp"
#include "safety/unseen.hpp"
#include "threewe/core/errors.hpp"

using namespace threewe;

namespace {

RobotProfile with_autonomy(const std::string& section) {
  return parse_profile(load_profile("3we_standard_v2").yaml + "\nautonomy:\n" + section, "mine.yaml");
}

}  // namespace

TEST_CASE("every parameter of the gate has a name of its own, and a meaning") {
  safety::Params params;
  std::set<std::string> names;
  for (const Parameter& parameter : parameters_of(params)) {
    CAPTURE(parameter.name);
    CHECK(names.insert(parameter.name).second);
    CHECK_FALSE(parameter.meaning.empty());
  }
}

TEST_CASE("a profile sets the gate's parameters, and all who plan keep the same margin") {
  const RobotProfile profile =
      with_autonomy("  safety: {gate: {margin: 0.05, sensor_timeout: 0.3}, creep: {corner_speed: 0.06}}\n");
  const safety::GateModel gate = safety::make_gate_model(profile);
  CHECK(gate.margin == doctest::Approx(0.05 + profile.lidar->bias));
  CHECK(gate.margin == safety::margin_of(profile));
  CHECK(gate.sensor_timeout == 300ms);
  CHECK(gate.creep.corner_speed == 0.06);
  CHECK(safety::make_sight_model(profile, gate).memory == 300ms);
  CHECK_THROWS_WITH_AS((void)safety::make_gate_model(with_autonomy("  safety: {gate: {magin: 0.05}}\n")),
                       doctest::Contains("gate.margin"), ConfigError);
}

TEST_CASE("a robot three times as large keeps three times the margin, and touches no faster") {
  RobotProfile profile = load_profile("3we_standard_v2");
  profile.body.footprint = Footprint::rectangle(0.75, 0.66);
  profile.lidar->bias *= 3.0;
  const safety::GateModel small = safety::make_gate_model(load_profile("3we_standard_v2"));
  const safety::GateModel large = safety::make_gate_model(profile);
  CHECK(large.margin == doctest::Approx(3.0 * small.margin));
  CHECK(large.sweep_step == doctest::Approx(3.0 * small.sweep_step));
  CHECK(large.creep.margin == doctest::Approx(3.0 * small.creep.margin));
  CHECK(large.creep.corner_speed == small.creep.corner_speed);
}
