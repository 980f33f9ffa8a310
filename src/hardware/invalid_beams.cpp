#include "hardware/invalid_beams.hpp"

#include <algorithm>

#include "core/exact.hpp"

namespace threewe {
namespace {

// Nearly no scan has a run; many have an invalid beam or two.
bool may_have_run(std::span<const float> ranges, std::size_t fewest) {
  unsigned invalid = 0;  // counted without a branch
  for (const float range : ranges) invalid += static_cast<unsigned>(!(range > 0.0F));
  return invalid >= fewest;
}

}  // namespace

std::vector<InvalidBeams> invalid_beams(std::span<const float> ranges, std::size_t fewest) {
  std::vector<InvalidBeams> runs;
  const std::size_t n = ranges.size();
  if (!may_have_run(ranges, fewest)) return runs;
  const auto valid = std::ranges::find_if(ranges, [](float range) { return range > 0.0F; });
  if (valid == ranges.end()) return n < fewest ? runs : std::vector<InvalidBeams>{{0, n, 0.0F, 0.0F}};

  const auto start = static_cast<std::size_t>(valid - ranges.begin());
  InvalidBeams run{start + 1, 0, *valid, 0.0F};
  for (std::size_t k = 1; k <= n; ++k) {
    const std::size_t beam = start + k < n ? start + k : start + k - n;
    const float range = ranges[beam];
    if (range <= 0.0F) {
      ++run.count;
      continue;
    }
    run.first %= n;
    run.after = range;
    if (run.count >= fewest) runs.push_back(run);
    run = {start + k + 1, 0, range, 0.0F};
  }
  return runs;
}

double near_gap(const LidarSpec& lidar) {
  constexpr double kBeyond = 4.0;  // deviations by which a range at a gap's edge may be too long
  constexpr double kSteps =
      kBridgedBeams + 1.0;  // along a surface, from the last beam that is too short to the first that is not
  return lidar.range_min * (1.0 + kSteps * 2.0 * exact::kPi / lidar.beams) + kBeyond * lidar.sigma;
}

}  // namespace threewe
