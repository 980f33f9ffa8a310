#include "threewe/backend/world.hpp"

#include <algorithm>

#include "threewe/core/errors.hpp"

namespace threewe::backend {

bool Features::has(SensorType type) const {
  return std::ranges::any_of(sensors, [type](const SensorInfo& sensor) { return sensor.type == type; });
}

void World::reset(const ResetOptions&) { throw ContractError("this backend cannot be reset"); }

void World::teleport(std::size_t, const Pose2D&) { throw ContractError("this backend cannot teleport a robot"); }

std::vector<std::byte> World::save() const { throw ContractError("this backend cannot be saved"); }

void World::restore(const std::vector<std::byte>&) { throw ContractError("this backend cannot be restored"); }

}  // namespace threewe::backend
