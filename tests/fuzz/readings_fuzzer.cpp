// Scans and odometry, as recordings hold them: numbers of any kind. What Slam takes it maps, the rest it refuses.
#include "fuzz.hpp"
#include "threewe/core/errors.hpp"
#include "threewe/slam/slam.hpp"

namespace {

using namespace threewe;

// Takes numbers from the bytes of an input, zeros after its end.
class Numbers {
 public:
  explicit Numbers(std::string_view bytes) : bytes_(bytes) {}
  bool empty() const { return bytes_.empty(); }
  template <typename T>
  T next() {
    T value{};
    bytes_.remove_prefix(bytes_.copy(reinterpret_cast<char*>(&value), sizeof value));
    return value;
  }
  Pose2D pose() {
    const auto x = next<double>();
    const auto y = next<double>();
    return {x, y, next<double>()};
  }

 private:
  std::string_view bytes_;
};

void map_readings(Numbers numbers) {
  slam::Slam slam({.base_from_lidar = numbers.pose(), .range_max = numbers.next<double>()});
  const std::size_t beams = numbers.next<std::uint8_t>();
  Time stamp{};
  for (int i = 0; i < 16 && !numbers.empty(); ++i) {
    stamp += Duration(numbers.next<std::uint32_t>());
    LaserScan scan;
    for (double* field :
         {&scan.angle_min, &scan.angle_increment, &scan.time_increment, &scan.range_min, &scan.range_max}) {
      *field = numbers.next<double>();
    }
    for (std::size_t k = 0; k < beams; ++k) scan.ranges.push_back(numbers.next<float>());
    slam.add(stamp, scan, numbers.pose());
  }
}

}  // namespace

THREEWE_FUZZER(readings)(std::string_view bytes) {
  fuzz::read(
      bytes,
      [&] {
        try {
          map_readings(Numbers(bytes));
        } catch (const ContractError&) {
          return;  // refused
        }
      },
      fuzz::kMapMemory);
}
