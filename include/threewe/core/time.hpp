// Robot time: the only clock above a backend.
#pragma once

#include <chrono>

namespace threewe {

/// Robot time since the world began, or a span of it. An integer, so that adding periods never drifts.
using Time = std::chrono::nanoseconds;
/// A length of time, in whole nanoseconds.
using Duration = std::chrono::nanoseconds;

using namespace std::chrono_literals;

/// One control period: every tick of the runtime lasts this long.
inline constexpr Duration kControlPeriod = 20ms;

/// [s] as a double.
constexpr double to_seconds(Duration d) { return static_cast<double>(d.count()) * 1e-9; }

/// The nearest whole nanosecond to `s` seconds. `s` must be finite and below 2^53 ns in magnitude.
constexpr Duration from_seconds(double s) {
  return Duration(static_cast<Duration::rep>(s * 1e9 + (s < 0 ? -0.5 : 0.5)));
}

}  // namespace threewe
