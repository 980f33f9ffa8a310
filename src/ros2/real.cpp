// What is always built: where this library was compiled without Cyclone DDS's headers, the backend says so.
#include "ros2/real.hpp"

#include <fmt/format.h>

#include "ros2/serve.hpp"
#include "threewe/core/errors.hpp"
#if THREEWE_WITH_CYCLONEDDS
#include "ros2/dds/real_world.hpp"
#include "ros2/dds/server.hpp"
#endif

namespace threewe::ros2 {

#if THREEWE_WITH_CYCLONEDDS

std::unique_ptr<backend::World> make_world(const backend::WorldOptions& options) { return make_real_world(options); }

Graph discover(Duration wall) { return discover_with_cyclone(wall); }

std::unique_ptr<Server> serve(std::unique_ptr<backend::World> world, const ServeOptions& options) {
  return serve_with_cyclone(std::move(world), options);
}

#else

namespace {
[[noreturn]] void fail() {
  throw ConfigError(
      fmt::format("backend 'real': this build of threewe has none, as Cyclone DDS's headers were not there when it was "
                  "compiled: {}, "
                  "then build threewe again",
                  kInstall));
}
}  // namespace

std::unique_ptr<backend::World> make_world(const backend::WorldOptions&) { fail(); }

Graph discover(Duration) { fail(); }

std::unique_ptr<Server> serve(std::unique_ptr<backend::World>, const ServeOptions&) { fail(); }

#endif

}  // namespace threewe::ros2
