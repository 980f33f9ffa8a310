#include "slam/params.hpp"

#include <doctest/doctest.h>

#include <set>
#include <string>
#include <variant>

#include "threewe/map/occupancy_grid.hpp"

namespace threewe::slam {
namespace {

TEST_CASE("every parameter of slam is listed once, with its meaning, and each length grows with something") {
  Params params;
  std::set<std::string> names;
  std::size_t bytes = 0;
  for (const Parameter& parameter : parameters_of(params)) {
    CAPTURE(parameter.name);
    CHECK(names.insert(parameter.name).second);
    CHECK_FALSE(parameter.meaning.empty());
    if (parameter.unit == "m") CHECK(parameter.scale != Scale::none);
    bytes += std::holds_alternative<int*>(parameter.value) ? sizeof(int) : sizeof(double);
  }
  CHECK(sizeof(Params) - bytes < 8 * sizeof(int));  // none is left out, but for what aligns them
}

TEST_CASE("maps have cells of 5 cm times a power of two") {
  CHECK(rounded_resolution(0.05) == 0.05);
  CHECK(rounded_resolution(0.025) == 0.025);
  CHECK(rounded_resolution(0.15) == 0.2);
  CHECK(rounded_resolution(0.0667) == 0.1);
  CHECK(rounded_resolution(0.0666) == 0.05);
  CHECK(rounded_resolution(1e-9) >= map::kFinestResolution);
  CHECK(rounded_resolution(1e9) <= map::kCoarsestResolution);
}

}  // namespace
}  // namespace threewe::slam
