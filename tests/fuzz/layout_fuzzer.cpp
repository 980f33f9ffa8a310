// Layouts of box detectors.
#include "fuzz.hpp"
#include "vision/box_detector.hpp"

THREEWE_FUZZER(layout)(std::string_view text) {
  using namespace threewe;
  static const auto file = fuzz::folder() / "fuzz.yaml";
  fuzz::write(file, text);
  fuzz::read(text, [&] {
    const vision::BoxLayout layout = vision::BoxLayout::load(file);
    const CameraIntrinsics camera{32, 24, 30.0, 30.0, 16.0, 12.0};
    const auto rows = [&](std::span<const std::uint8_t>, const CameraIntrinsics&) {
      vision::BoxRows row{4.0F, 4.0F, 12.0F, 12.0F};
      row.resize(4 + layout.labels.size(), 0.9F);
      return row;
    };
    (void)vision::box_detector(layout, rows).detect(std::vector<std::uint8_t>(std::size_t{3} * 32 * 24), camera);
  });
}
