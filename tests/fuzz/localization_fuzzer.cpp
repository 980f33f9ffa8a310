// Models of localization errors.
#include "fuzz.hpp"
#include "threewe/models/localization.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace threewe;
  static const auto file = fuzz::folder() / "fuzz.yaml";
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  fuzz::write(file, text);
  fuzz::read(text, [&] { (void)models::load_localization(file.string()); });
  return 0;
}
