// A sample of the allocations that the recorder makes fails; `./dev verify recorder` lets all of them fail.
#include "record/allocation_trials.hpp"

#include <doctest/doctest.h>

using namespace threewe;
using namespace threewe::record;

TEST_CASE("an allocation that fails once is an error, and finished episodes stay readable") {
  constexpr long kSample = 100;
  const auto world = trials::make_world();
  const auto warnings = set_warning_handler([](std::string_view) {});
  long count = 0;
  CHECK(trials::allocation_trial(*world, -1, count).empty());
  REQUIRE(count > kSample);
  for (long fails = 0; fails < count; fails += count / kSample) {
    long ignored = 0;
    const std::string wrong = trials::allocation_trial(*world, fails, ignored);
    CHECK_MESSAGE(wrong.empty(), "allocation ", fails, ": ", wrong);
  }
  (void)set_warning_handler(warnings);
}
