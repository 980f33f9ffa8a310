#include "perception/bearing_bin.hpp"
#include "core/exact.hpp"

#include <array>
#include <cmath>

namespace threewe::perception {
namespace {

constexpr double kPerBin = 2.0 * exact::kPi / static_cast<double>(kBearingBins);

// Where bins begin, as directions; the first one again at the end.
const std::array<Vec2, kBearingBins + 1> kBorders = [] {
  std::array<Vec2, kBearingBins + 1> borders;
  for (std::size_t i = 0; i < borders.size(); ++i) {
    borders[i] = rotate({1.0, 0.0}, -exact::kPi + static_cast<double>(i) * kPerBin);
  }
  return borders;
}();

std::size_t bin_by_angle(Vec2 d) {
  const double share = (exact::atan2(d.y, d.x) + exact::kPi) / (2.0 * exact::kPi);
  return static_cast<std::size_t>(std::floor(share * static_cast<double>(kBearingBins))) % kBearingBins;
}

}  // namespace

std::size_t bearing_bin(Vec2 d, std::size_t near) {
  constexpr int kMost = 6;            // bins away from `near`: farther ones are found sooner by their angle
  constexpr double kDoubtful = 1e-9;  // [rad] next to a border, rounding decides
  const double doubtful = kDoubtful * (std::fabs(d.x) + std::fabs(d.y));
  std::size_t bin = near;
  double past = cross(kBorders[bin], d);
  if (past > doubtful) {
    for (int i = 0; i < kMost && past > doubtful; ++i, bin = (bin + 1) % kBearingBins) {
      past = cross(kBorders[bin + 1], d);
      if (past < -doubtful) return bin;
    }
  } else {
    for (int i = 0; i < kMost && past < -doubtful; ++i) {
      bin = (bin + kBearingBins - 1) % kBearingBins;
      past = cross(kBorders[bin], d);
      if (past > doubtful) return bin;
    }
  }
  return bin_by_angle(d);
}

}  // namespace threewe::perception
