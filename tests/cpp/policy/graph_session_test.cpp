#include "policy/graph_session.hpp"

#include <doctest/doctest.h>

#include "draw.hpp"
#include "threewe/core/errors.hpp"

using namespace threewe;
using policy::GraphSession, policy::PictureInput;

// The definition: the mean of a square of pixels, over 255.
TEST_CASE("a network gets the mean of the pixels that each of its own stands for") {
  for (std::uint64_t seed = 0; seed < cases(300); ++seed) {
    CAPTURE(seed);
    Draw random(seed);
    const auto draw = [&random](int most) { return static_cast<std::size_t>(random.whole(1, most)); };
    PictureInput picture{{}, draw(6), draw(6), draw(4), random.whole(0, 1) == 1};
    const std::size_t n = picture.factor;
    picture.bgr.resize(3 * n * n * picture.height * picture.width);
    for (std::uint8_t& each : picture.bgr) each = static_cast<std::uint8_t>(random.whole(0, 255));
    const std::vector<float> found = policy::network_input(picture);
    REQUIRE(found.size() == 3 * picture.height * picture.width);
    for (std::size_t channel = 0; channel < 3; ++channel) {
      for (std::size_t y = 0; y < picture.height; ++y) {
        for (std::size_t x = 0; x < picture.width; ++x) {
          double sum = 0.0;
          for (std::size_t row = 0; row < n; ++row) {
            for (std::size_t column = 0; column < n; ++column) {
              const std::size_t pixel = (n * y + row) * n * picture.width + n * x + column;
              sum += picture.bgr[3 * pixel + (picture.rgb ? 2 - channel : channel)];
            }
          }
          const double expected = sum / static_cast<double>(n * n) / 255.0;
          CHECK(found[(channel * picture.height + y) * picture.width + x] == doctest::Approx(expected).epsilon(1e-6));
        }
      }
    }
  }
}

TEST_CASE("pictures of another size, and libraries that are none, are refused") {
  CHECK_THROWS_WITH_AS(policy::network_input({std::vector<std::uint8_t>(11), 2, 2, 1, true}),
                       "a picture of 1 times 2 x 2 pixels has 12 bytes, got 11", ContractError);
  CHECK_THROWS_AS(GraphSession("/nowhere/libonnxruntime.so", {}, {}, {"action", {1}}), ConfigError);
  CHECK_THROWS_AS(GraphSession("libm.so.6", {}, {}, {"action", {1}}), ConfigError);
}
