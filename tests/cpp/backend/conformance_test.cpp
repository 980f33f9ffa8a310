// Each conformance check passes an honest world and catches a world that breaks what it checks.
#include "threewe/backend/conformance.hpp"

#include <algorithm>
#include <set>

#include <doctest/doctest.h>

#include "backend/toy_plugin.hpp"
#include "backend/twins.hpp"

namespace threewe::backend {
namespace {

using testing::Fault;

WorldOptions with_hardware(const std::string& name) {
  WorldOptions options;
  options.robots = {name};
  return options;
}

TEST_CASE("an honest backend passes every check") {
  for (const char* hardware : {"3we_standard_v2", "turtlebot_like"}) {
    for (const NoiseLevel noise : {NoiseLevel::realistic, NoiseLevel::ideal}) {
      WorldOptions options = with_hardware(hardware);
      options.noise = noise;
      for (const CheckResult& result : check_backend(testing::toy_world, options)) {
        CAPTURE(hardware);
        CHECK_MESSAGE(result.passed(), result.name << ": " << result.detail);
      }
    }
  }
}

TEST_CASE("every check catches its broken twins") {
  const std::string differential = "sideways_is_refused";
  for (const auto& [check, fault] : testing::twins()) {
    const WorldOptions options = with_hardware(check == differential ? "turtlebot_like" : "3we_standard_v2");
    const CheckResult honest = check_backend(testing::toy_world, options, check);
    const bool has_none =
        honest.detail.find("no truth") != std::string::npos || honest.detail.find("no camera") != std::string::npos;
    if (has_none) continue;  // the mock backend has it: see its own test
    CHECK_MESSAGE(honest.passed(), check << ": " << honest.detail);
    const CheckResult broken = check_backend(testing::with_fault(testing::toy_world, fault), options, check);
    CHECK_MESSAGE(!broken.passed(),
                  check << " does not catch its twin: " << to_string(broken.outcome) << " " << broken.detail);
  }
}

TEST_CASE("every check has a twin, and every twin a check") {
  std::set<std::string> twins;
  for (const auto& [check, fault] : testing::twins()) twins.insert(check);
  const std::vector<std::string> names = check_names();
  CHECK(twins == std::set<std::string>(names.begin(), names.end()));
  CHECK(names.size() >= 45);
  MESSAGE(names.size(), " checks, ", testing::twins().size(), " broken twins");
}

TEST_CASE("a backend that claims nothing is not asked for it") {
  const auto modest = testing::with_fault(
      testing::toy_world,
      Fault{.features = [](Features& f, bool) { f.can_reset = f.can_save = f.deterministic = false; },
            .reset = [](World&, const ResetOptions&) { throw ContractError("cannot be reset"); },
            .save = [](World&) -> std::vector<std::byte> { throw ContractError("cannot be saved"); }});
  std::size_t not_applicable = 0;
  for (const CheckResult& result : check_backend(modest)) {
    CHECK_MESSAGE(result.passed(), result.name << ": " << result.detail);
    not_applicable += result.outcome == Outcome::not_applicable ? 1 : 0;
  }
  CHECK(not_applicable >= 7);
}

TEST_CASE("a backend that cannot even be made fails every check and throws nothing") {
  const auto broken = [](const WorldOptions&) -> std::unique_ptr<World> { throw ConfigError("no such device"); };
  const std::vector<CheckResult> results = check_backend(broken);
  CHECK(results.size() == check_names().size());
  for (const CheckResult& result : results) {
    CHECK(!result.passed());
    CHECK(result.detail == "no such device");
  }
  const auto null = [](const WorldOptions&) { return std::unique_ptr<World>(); };
  CHECK(!check_backend(null, {}, "time_starts_at_zero").passed());
}

TEST_CASE("an unknown check is an error with the nearest name") {
  CHECK_THROWS_WITH_AS(check_backend(testing::toy_world, {}, "time_start_at_zero"),
                       "unknown check 'time_start_at_zero'; did you mean 'time_starts_at_zero'?", ConfigError);
}

}  // namespace
}  // namespace threewe::backend
