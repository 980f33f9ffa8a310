// Files of places.
#include "fuzz.hpp"
#include "semantics/places.hpp"

THREEWE_FUZZER(places)(std::string_view input) {
  using namespace threewe;
  const std::string text(input);
  fuzz::read(text, [&] {
    const auto places = semantics::parse_places(text, "fuzz.yaml", nullptr);
    (void)semantics::parse_places(semantics::to_yaml(places), "written.yaml", nullptr);  // can be read again
  });
}
