#include "slam/range_noise_estimator.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "core/exact.hpp"

namespace threewe::slam {
namespace {

constexpr double kMedian = 0.6744898;      // of a normal number's size, in deviations
constexpr std::size_t kFew = 30;           // threes tell nothing
constexpr int kBelief = 2;                 // what was expected counts as so many scans ...
constexpr int kMemory = 50;                // ... and all before as no more than so many
constexpr double kSlope = 0.5;             // tangent of the incidence: on steeper walls a beam's width shows more ...
constexpr double kDistinguishable = 0.02;  // [m] ... than its scatter, but for differences so small

// How far the middle one of three ranges is off the line through the others, in deviations of one range times the
// unit of length. Along a straight line 1 / range is a sinusoid of the direction: the sum of two neighbours' is the
// middle one's times `twice_cos`.
double distance_from_line(double before, double middle, double after, double twice_cos) {
  const double on_line = twice_cos / (1.0 / before + 1.0 / after);
  const double by_before = on_line * on_line / (twice_cos * before * before);
  const double by_after = on_line * on_line / (twice_cos * after * after);
  return std::fabs(middle - on_line) / exact::sqrt(1.0 + by_before * by_before + by_after * by_after);
}

}  // namespace

double range_noise_of(const LaserScan& scan) {
  const double twice_cos = 2.0 * exact::sincos(scan.angle_increment).cos;
  const auto is_hit = [&](double range) { return range > 0.0 && range >= scan.range_min && range < scan.range_max; };
  std::vector<double> off;
  off.reserve(scan.ranges.size());
  for (std::size_t i = 2; i < scan.ranges.size(); ++i) {
    const auto before = static_cast<double>(scan.ranges[i - 2]);
    const auto middle = static_cast<double>(scan.ranges[i - 1]);
    const auto after = static_cast<double>(scan.ranges[i]);
    if (!is_hit(before) || !is_hit(middle) || !is_hit(after)) continue;
    const double steepest = kSlope * 2.0 * middle * scan.angle_increment + kDistinguishable;
    if (std::fabs(after - before) > steepest) continue;
    off.push_back(distance_from_line(before, middle, after, twice_cos));
  }
  if (off.size() < kFew) return 0.0;
  const auto median = off.begin() + static_cast<std::ptrdiff_t>(off.size() / 2);
  std::ranges::nth_element(off, median);
  return *median / kMedian;
}

void RangeNoiseEstimator::add(const LaserScan& scan) {
  const double scatter = range_noise_of(scan);
  if (scatter == 0.0) return;
  scans_ = std::min(scans_ + 1, kMemory);
  sigma_ += (scatter - sigma_) / (kBelief + scans_);
}

}  // namespace threewe::slam
