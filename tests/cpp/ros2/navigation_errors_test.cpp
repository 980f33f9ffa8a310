// Nav2's error codes.
#include "ros2/navigation_errors.hpp"

#include <doctest/doctest.h>

#include <string>

namespace threewe::ros2 {
namespace {

using Outcome = backend::ExternalNavigator::Outcome;

TEST_CASE("a code is an outcome and words, with what Nav2 says besides") {
  const NavigationError blocked = explain(105, "");
  CHECK(blocked.outcome == Outcome::blocked);
  CHECK(blocked.detail == "FAILED_TO_MAKE_PROGRESS (105): the robot does not get on");
  const NavigationError closed = explain(208, "GridBased found none");
  CHECK(closed.outcome == Outcome::no_path);
  CHECK(closed.detail == "NO_VALID_PATH (208): there is no path to the goal; \"GridBased found none\"");
}

TEST_CASE("the same failure of different servers has the same outcome") {
  for (const int code : {102, 202, 302, 702, 712, 722, 9002})
    CHECK(explain(static_cast<std::uint16_t>(code), "").outcome == Outcome::lost);
  for (const int code : {204, 206, 208, 304, 306, 308})
    CHECK(explain(static_cast<std::uint16_t>(code), "").outcome == Outcome::no_path);
  for (const int code : {104, 105, 106, 205, 703, 714, 723})
    CHECK(explain(static_cast<std::uint16_t>(code), "").outcome == Outcome::blocked);
  for (const int code : {108, 9003}) CHECK(explain(static_cast<std::uint16_t>(code), "").outcome == Outcome::timeout);
  for (const int code : {100, 200, 300, 500, 600, 9000, 9001})
    CHECK(explain(static_cast<std::uint16_t>(code), "").outcome == Outcome::fault);
}

TEST_CASE("a code that is not Nav2's is a fault with its number") {
  for (const int code : {3, 99, 109, 210, 8999, 65535}) {
    const NavigationError error = explain(static_cast<std::uint16_t>(code), "mine");
    CHECK(error.outcome == Outcome::fault);
    CHECK(error.detail == "error code " + std::to_string(code) + ", which is not one of Nav2's own; \"mine\"");
  }
}

}  // namespace
}  // namespace threewe::ros2
