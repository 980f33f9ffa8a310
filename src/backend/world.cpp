#include "threewe/backend/world.hpp"

#include "threewe/core/errors.hpp"

namespace threewe::backend {

void World::reset(const ResetOptions&) { throw ContractError("this backend cannot be reset"); }

std::vector<std::byte> World::save() const { throw ContractError("this backend cannot be saved"); }

void World::restore(const std::vector<std::byte>&) { throw ContractError("this backend cannot be restored"); }

}  // namespace threewe::backend
