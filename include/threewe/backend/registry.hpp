// Backend registry: factories of worlds by name.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "threewe/backend/world.hpp"

namespace threewe::backend {

/// Makes a world of a backend. Throws ConfigError for options that it cannot serve.
using WorldFactory = std::function<std::unique_ptr<World>(const WorldOptions&)>;

/// Makes a backend known. Registering a name again replaces it.
void register_backend(const std::string& name, WorldFactory factory);
/// Makes a world. Throws ConfigError naming the nearest right backend, scene or profile.
std::unique_ptr<World> make_world(std::string_view backend, const WorldOptions& options);
/// The names of all backends that are registered, in alphabetical order.
std::vector<std::string> backend_names();

}  // namespace threewe::backend
