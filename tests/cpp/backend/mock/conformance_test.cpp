// The conformance checks around the embedded simulator: every broken twin of it is caught.
#include "threewe/backend/conformance.hpp"

#include <doctest/doctest.h>

#include "backend/small_room.hpp"
#include "backend/twins.hpp"

namespace threewe::backend {
namespace {

std::unique_ptr<World> mock(const WorldOptions& options) { return make_world("mock", options); }

TEST_CASE("every check catches its broken twins of the embedded simulator") {
  for (const auto& [check, fault] : testing::twins()) {
    const WorldOptions options =
        testing::in_small_room(check == "sideways_is_refused" ? "turtlebot_like" : "3we_depth_v2");
    const CheckResult honest = check_backend(mock, options, check);
    CHECK_MESSAGE(honest.passed(), check << ": " << honest.detail);
    const CheckResult broken = check_backend(testing::with_fault(mock, fault), options, check);
    CHECK_MESSAGE(broken.outcome == Outcome::failed, check << " does not catch its twin: " << broken.detail);
  }
}

}  // namespace
}  // namespace threewe::backend
