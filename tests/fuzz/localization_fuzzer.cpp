// Models of localization errors.
#include "fuzz.hpp"
#include "threewe/models/localization.hpp"

THREEWE_FUZZER(localization)(std::string_view text) {
  using namespace threewe;
  static const auto file = fuzz::folder() / "fuzz.yaml";
  fuzz::write(file, text);
  fuzz::read(text, [&] { (void)models::load_localization(file.string()); });
}
