// The conformance checks around the embedded simulator: every broken twin of it is caught.
#include "threewe/backend/conformance.hpp"

#include <filesystem>
#include <fstream>

#include <doctest/doctest.h>

#include "backend/twins.hpp"

namespace threewe::backend {
namespace {

std::unique_ptr<World> mock(const WorldOptions& options) { return make_world("mock", options); }

/// One room without furniture: made at once, where the published scenes take a while.
std::string small_room() {
  const std::filesystem::path file = std::filesystem::temp_directory_path() / "small_room.yaml";
  std::ofstream(file) << R"(
name: small_room
description: A room of 6 x 5 m
starts:
  - [1.5, 2, 0]
rooms:
  - {name: room, min: [0, 0], max: [6, 5], floor: wood, anchor: [3, 2]}
walls:
  - {a: [0, 0], b: [6, 0]}
  - {a: [6, 0], b: [6, 5]}
  - {a: [6, 5], b: [0, 5]}
  - {a: [0, 5], b: [0, 0]}
)";
  return file.string();
}

WorldOptions in_small_room(const char* hardware) {
  WorldOptions options;
  options.scene = small_room();
  options.robots = {hardware};
  return options;
}

TEST_CASE("every check catches its broken twins of the embedded simulator") {
  for (const auto& [check, fault] : testing::twins()) {
    const WorldOptions options = in_small_room(check == "sideways_is_refused" ? "turtlebot_like" : "3we_depth_v2");
    const CheckResult honest = check_backend(mock, options, check);
    CHECK_MESSAGE(honest.passed(), check << ": " << honest.detail);
    const CheckResult broken = check_backend(testing::with_fault(mock, fault), options, check);
    CHECK_MESSAGE(broken.outcome == Outcome::failed, check << " does not catch its twin: " << broken.detail);
  }
}

}  // namespace
}  // namespace threewe::backend
