// Numbers and functions that <numbers> and <cmath> lack.
#pragma once

#include <limits>

namespace threewe {

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

constexpr double square(double x) { return x * x; }

}  // namespace threewe
