#include "threewe/backend/conformance.hpp"

#include <algorithm>

#include "backend/conformance_bench.hpp"
#include "core/names.hpp"

namespace threewe::backend {

namespace {

using namespace conformance;

std::vector<Check> all_checks() {
  std::vector<Check> all;
  for (const auto& table : {connection_checks(), time_checks(), sample_checks(), delay_checks(), lidar_checks(),
                            mount_checks(), ultrasonic_checks(), camera_checks(), scenery_checks(), motion_checks(),
                            command_checks(), repeat_checks(), truth_checks(), place_checks()}) {
    all.insert(all.end(), table.begin(), table.end());
  }
  return all;
}

CheckResult run(const Check& check, const Context& context) {
  try {
    check.run(context);
    return {check.name, Outcome::passed, ""};
  } catch (const NotApplicable& reason) {
    return {check.name, Outcome::not_applicable, reason.what()};
  } catch (const std::exception& error) {
    return {check.name, Outcome::failed, error.what()};
  }
}

void check(const Surroundings& surroundings) {
  const std::string& color = surroundings.color_ahead;
  if (color.empty() || color == "red" || color == "blue") return;
  throw ConfigError(
      fmt::format("color_ahead is '{}'; it must be 'red' or 'blue', or empty where none is known", color));
}

}  // namespace

std::string_view to_string(Outcome outcome) {
  switch (outcome) {
    case Outcome::passed: return "passed";
    case Outcome::failed: return "failed";
    case Outcome::not_applicable: return "not applicable";
  }
  return "";
}

std::vector<std::string> check_names() {
  std::vector<std::string> names;
  for (const Check& check : all_checks()) names.emplace_back(check.name);
  return names;
}

std::vector<CheckResult> check_backend(const WorldFactory& make, const WorldOptions& options,
                                       const Surroundings& surroundings) {
  check(surroundings);
  std::vector<CheckResult> results;
  for (const Check& check : all_checks()) results.push_back(run(check, {make, options, surroundings}));
  return results;
}

CheckResult check_backend(const WorldFactory& make, const WorldOptions& options, std::string_view check,
                          const Surroundings& surroundings) {
  backend::check(surroundings);
  const std::vector<Check> all = all_checks();
  const auto found = std::find_if(all.begin(), all.end(), [check](const Check& c) { return c.name == check; });
  if (found == all.end()) throw ConfigError(unknown_name("check", check, check_names()));
  return run(*found, {make, options, surroundings});
}

}  // namespace threewe::backend
