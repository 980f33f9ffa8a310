#include "hardware/invalid_beams.hpp"

#include <doctest/doctest.h>

#include <vector>

using namespace threewe;

TEST_CASE("runs of invalid beams, around the seam and all around") {
  const std::vector<float> seam = {0.0F, 0.0F, 1.0F, 0.0F, 2.0F, 3.0F, 0.0F};
  const auto runs = invalid_beams(seam, 1);
  REQUIRE(runs.size() == 2);
  CHECK(runs[0].first == 3);
  CHECK(runs[0].count == 1);
  CHECK(runs[1].first == 6);
  CHECK(runs[1].count == 3);
  CHECK(runs[1].before == 3.0F);
  CHECK(runs[1].after == 1.0F);
  CHECK(invalid_beams(seam, 2).size() == 1);
  CHECK(invalid_beams(std::vector<float>(5, 0.0F), 3).front().count == 5);
  CHECK(invalid_beams(std::vector<float>(5, 1.0F), 1).empty());
}
