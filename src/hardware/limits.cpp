#include "threewe/hardware/limits.hpp"

#include <algorithm>
#include <cmath>

namespace threewe {
namespace {

constexpr double kRounding = 1.0 + 1e-12;  // what scaling may add
constexpr double kHuge = 1e100;            // no limit is near, and its square is finite

}  // namespace

Velocity within_limits(const Limits& limits, Velocity v) {
  const auto shorten = [&v](double from, double to) {
    if (from <= to * kRounding) return;
    v.vx *= to / from;
    v.vy *= to / from;
  };
  shorten(std::max(std::abs(v.vx), std::abs(v.vy)), kHuge);
  shorten(exact::hypot(v.vx, v.vy), limits.linear);
  v.omega = std::clamp(v.omega, -limits.angular, limits.angular);
  return v;
}

}  // namespace threewe
