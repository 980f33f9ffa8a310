// Robot profiles.
#include "fuzz.hpp"
#include "threewe/hardware/profile.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace threewe;
  static const auto file = fuzz::folder() / "fuzz.yaml";
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  fuzz::write(file, text);
  fuzz::read(text, [&] { (void)with_noise(load_profile(file.string()), NoiseLevel::ideal); });
  return 0;
}
