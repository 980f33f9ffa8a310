// Networks of the object detector: each is read, and sees one picture.
#include "fuzz.hpp"
#include "vision/detector.hpp"

THREEWE_FUZZER(detector)(std::string_view bytes) {
  using namespace threewe;
  static const auto file = fuzz::folder() / "fuzz.safetensors";
  static const std::vector<std::uint8_t> picture(std::size_t{3} * 32 * 24, 100);
  fuzz::write(file, bytes);
  fuzz::read(bytes,
             [&] { (void)vision::Detector::load(file.string()).detect(picture, {32, 24, 30.0, 30.0, 16.0, 12.0}); });
}
