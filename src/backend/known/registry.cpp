// Backends by name. The table stands here, above our own implementations, so that it knows them from the start and
// `backend` itself need know none.
#include "threewe/backend/registry.hpp"

#include <map>
#include <mutex>
#include <utility>

#include "backend/mock/mock_world.hpp"
#include "backend/mujoco/mujoco.hpp"
#include "core/names.hpp"
#include "gazebo/gazebo.hpp"
#include "ros2/real.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::backend {
namespace {

struct Registry {
  std::mutex mutex;
  std::map<std::string, WorldFactory, std::less<>> factories{
      {"gazebo", gazebo::make_world},
      {"mock", [](const WorldOptions& options) { return std::make_unique<mock::MockWorld>(options); }},
      {"mujoco", mujoco::make_world},
      {"real", ros2::make_world},
  };
};

Registry& registry() {
  static Registry instance;
  return instance;
}

}  // namespace

void register_backend(const std::string& name, WorldFactory factory) {
  const std::scoped_lock lock(registry().mutex);
  registry().factories.insert_or_assign(name, std::move(factory));
}

std::unique_ptr<World> make_world(std::string_view backend, const WorldOptions& options) {
  // a factory may take long, or register another backend, so that it runs without the lock
  WorldFactory factory;
  {
    const std::scoped_lock lock(registry().mutex);
    const auto found = registry().factories.find(backend);
    if (found != registry().factories.end()) factory = found->second;
  }
  if (!factory) throw ConfigError(unknown_name("backend", backend, backend_names()));
  return factory(options);
}

std::vector<std::string> backend_names() {
  const std::scoped_lock lock(registry().mutex);
  std::vector<std::string> names;
  for (const auto& [name, factory] : registry().factories) names.push_back(name);
  return names;
}

}  // namespace threewe::backend
