// Ranges of randomisation.
#include "fuzz.hpp"
#include "threewe/models/randomization.hpp"

THREEWE_FUZZER(randomization)(std::string_view input) {
  using namespace threewe;
  const std::string text(input);
  fuzz::read(text, [&] {
    const models::Randomization randomization = models::parse_randomization(text, "fuzz.yaml");
    (void)models::draw_variation(randomization, 1, 2, 3);
  });
}
