// Specifications of recorded logs.
#include "fuzz.hpp"
#include "sim/recorded_log.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace threewe;
  static const auto file = fuzz::folder() / "fuzz.yaml";
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  fuzz::write(file, text);
  fuzz::read(text, [&] { (void)sim::load_log_spec(file.string()); });
  return 0;
}
