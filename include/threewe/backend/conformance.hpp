// Conformance suite of the backend contract: checks that run against any backend, ours or a third party's.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "threewe/backend/registry.hpp"

namespace threewe::backend {

/// How a check ended. A feature that the backend does not claim makes its checks `not_applicable`.
enum class Outcome : std::uint8_t { passed, failed, not_applicable };
/// Its name.
std::string_view to_string(Outcome outcome);

/// What one check found.
struct CheckResult {
  std::string name;    ///< what was checked, such as "rates_are_as_listed"
  Outcome outcome{};   ///< passed, failed or not applicable
  std::string detail;  ///< what was wrong, or why the check does not apply; empty when passed

  /// False only for a failure.
  bool passed() const { return outcome != Outcome::failed; }
};

/// What the caller knows about the place, and no check can find out by itself.
struct Surroundings {
  /// "red" or "blue": the colour of a thing that fills the middle of the camera's image at the start. Empty where there
  /// is none: the order of an image's colours is then checked only of simulators that paint scenes as ours do.
  std::string color_ahead;
};

/// The names of all checks, in the order in which they run.
std::vector<std::string> check_names();

/// Runs every check, each on a world of its own, made by `make(options)` with other seeds where a check needs them.
///
/// A check sees what a runtime sees: the `World` and its first `RobotPort`. It drives the robot, so the start pose
/// needs 1.5 m of free floor ahead and 0.6 m to the left. Never throws: a world that cannot be made, or that throws,
/// fails.
std::vector<CheckResult> check_backend(const WorldFactory& make, const WorldOptions& options = {},
                                       const Surroundings& surroundings = {});
/// Runs one check. Throws ConfigError naming the nearest right check.
CheckResult check_backend(const WorldFactory& make, const WorldOptions& options, std::string_view check,
                          const Surroundings& surroundings = {});

}  // namespace threewe::backend
