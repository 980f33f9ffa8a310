#include "models/ultrasonic.hpp"

#include <algorithm>

namespace threewe::models {

double measure_range(const UltrasonicSpec& spec, const RngKey& key, std::uint64_t ping, double echo) {
  if (echo >= spec.range_max) return spec.range_max;
  const double range = spec.sigma > 0.0 ? echo + spec.sigma * normal(key, ping) : echo;
  return range < spec.range_min ? 0.0 : std::min(range, spec.range_max);
}

RangeData range_data(const UltrasonicSpec& spec, double range) {
  return {spec.field_of_view, spec.range_min, spec.range_max, range};
}

}  // namespace threewe::models
