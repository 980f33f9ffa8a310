#include "threewe/hardware/limits.hpp"

#include <hwy/highway.h>

#include "threewe/hardware/limits-inl.hpp"

namespace threewe {

Velocity within_limits(const Limits& limits, Velocity v) {
  const auto [vx, vy, omega] =
      HWY_NAMESPACE::within_limits<double>(limits.linear, limits.angular, {v.vx, v.vy, v.omega});
  return {vx, vy, omega};
}

}  // namespace threewe
