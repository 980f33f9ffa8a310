#include "slam/slam_config.hpp"

#include <string_view>

#include <fmt/format.h>

#include "core/bounds.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::slam {
namespace {

void require(bool holds, std::string_view field, std::string_view range, double value) {
  if (!holds) throw ContractError(fmt::format("{} must lie in {}, got {:g}", field, range, value));
}

}  // namespace

void check(const SlamConfig& config) {
  check_bounds("base_from_lidar", config.base_from_lidar);
  require(is_within(config.range_max, 1.0, 200.0), "range_max", "[1, 200] m", config.range_max);
  require(is_within(config.resolution, 0.02, 0.2), "resolution", "[0.02, 0.2] m", config.resolution);
  require(is_within(config.range_bias_sigma, 0.0, 0.1), "range_bias_sigma", "[0, 0.1] m", config.range_bias_sigma);
  require(is_within(config.distance_sigma, 0.0, 0.2), "distance_sigma", "[0, 0.2]", config.distance_sigma);
  require(is_within(config.position_drift, 0.0, 0.3), "position_drift", "[0, 0.3] m/sqrt(m)", config.position_drift);
  require(is_within(config.heading_drift, 0.0, 0.3), "heading_drift", "[0, 0.3] rad/sqrt(m)", config.heading_drift);
}

}  // namespace threewe::slam
