// Ranges of randomisation.
#include "fuzz.hpp"
#include "threewe/models/randomization.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace threewe;
  const std::string text(reinterpret_cast<const char*>(data), size);
  fuzz::read(text, [&] {
    const models::Randomization randomization = models::parse_randomization(text, "fuzz.yaml");
    (void)models::draw_variation(randomization, 1, 2, 3);
  });
  return 0;
}
