// Networks of the object detector: each is read, and sees one picture.
#include "fuzz.hpp"
#include "vision/detector.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace threewe;
  static const auto file = fuzz::folder() / "fuzz.safetensors";
  static const std::vector<std::uint8_t> picture(std::size_t{3} * 32 * 24, 100);
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  fuzz::write(file, bytes);
  fuzz::read(bytes,
             [&] { (void)vision::Detector::load(file.string()).detect(picture, {32, 24, 30.0, 30.0, 16.0, 12.0}); });
  return 0;
}
