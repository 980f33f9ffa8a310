// Robot profiles.
#include "fuzz.hpp"
#include "threewe/hardware/profile.hpp"

THREEWE_FUZZER(profile)(std::string_view text) {
  using namespace threewe;
  static const auto file = fuzz::folder() / "fuzz.yaml";
  fuzz::write(file, text);
  fuzz::read(text, [&] { (void)with_noise(load_profile(file.string()), NoiseLevel::ideal); });
}
