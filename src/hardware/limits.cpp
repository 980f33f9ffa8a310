#include "threewe/hardware/limits.hpp"

#include <algorithm>

#include <hwy/highway.h>

#include "threewe/hardware/limits-inl.hpp"

namespace threewe {

Velocity within_limits(const Limits& limits, Velocity v) {
  const auto [vx, vy, omega] =
      HWY_NAMESPACE::within_limits<double>(limits.linear, limits.angular, {v.vx, v.vy, v.omega});
  return {vx, vy, omega};
}

Velocity scaled_to(const Limits& limits, const Velocity& shares) {
  const auto scaled = [](double share, double limit) { return std::clamp(share, -1.0, 1.0) * limit; };
  return {scaled(shares.vx, limits.linear), scaled(shares.vy, limits.linear), scaled(shares.omega, limits.angular)};
}

}  // namespace threewe
