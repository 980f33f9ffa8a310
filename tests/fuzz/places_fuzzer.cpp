// Files of places.
#include "fuzz.hpp"
#include "semantics/places.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace threewe;
  const std::string text(reinterpret_cast<const char*>(data), size);
  fuzz::read(text, [&] {
    const auto places = semantics::parse_places(text, "fuzz.yaml", nullptr);
    (void)semantics::parse_places(semantics::to_yaml(places), "written.yaml", nullptr);  // can be read again
  });
  return 0;
}
