#include "threewe/backend/world.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "threewe/core/errors.hpp"

namespace threewe::backend {

bool Features::has(SensorType type) const {
  return std::ranges::any_of(sensors, [type](const SensorInfo& sensor) { return sensor.type == type; });
}

namespace {

[[noreturn]] void refuse_delegation(std::string_view option, std::string_view program) {
  throw ConfigError(
      fmt::format("{} '{}' is a program on a robot: backend 'real' reaches it, this one does not", option, program));
}

}  // namespace

ExternalLocalizer& RobotPort::delegate_localization(std::string_view program, const std::optional<Pose2D>&) {
  refuse_delegation("localization", program);
}

ExternalNavigator& RobotPort::delegate_navigation(std::string_view program) {
  refuse_delegation("navigation", program);
}

void World::reset(const ResetOptions&) { throw ContractError("this backend cannot be reset"); }

void World::teleport(std::size_t, const Pose2D&) { throw ContractError("this backend cannot teleport a robot"); }

std::vector<std::byte> World::save() const { throw ContractError("this backend cannot be saved"); }

void World::restore(const std::vector<std::byte>&) { throw ContractError("this backend cannot be restored"); }

}  // namespace threewe::backend
