// Specifications of recorded logs.
#include "fuzz.hpp"
#include "sim/recorded_log.hpp"

THREEWE_FUZZER(log)(std::string_view text) {
  using namespace threewe;
  static const auto file = fuzz::folder() / "fuzz.yaml";
  fuzz::write(file, text);
  fuzz::read(text, [&] { (void)sim::load_log_spec(file.string()); });
}
