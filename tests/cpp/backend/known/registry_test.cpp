#include "threewe/backend/registry.hpp"

#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "threewe/core/errors.hpp"

using namespace threewe;
using namespace threewe::backend;

namespace {

template <typename Action>
std::string error_of(const Action& action) {
  try {
    action();
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("backends by name") {
  CHECK(backend_names() == std::vector<std::string>{"gazebo", "mock", "mujoco", "real"});
  CHECK(error_of([] { make_world("mokc", {}); }).find("did you mean 'mock'") != std::string::npos);
  register_backend("twin", [](const WorldOptions& options) { return make_world("mock", options); });
  CHECK(backend_names().size() == 5);
  CHECK(make_world("twin", {})->robot_count() == 1);
}
