// Runs of a scan's invalid beams.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

namespace threewe::safety {

/// Invalid beams side by side, around the whole turn if need be, and the valid ones at both ends.
struct InvalidBeams {
  std::size_t first = 0;
  std::size_t count = 0;
  float before = 0.0F;  ///< [m] the range of the beam before the first; 0 where no beam is valid
  float after = 0.0F;   ///< [m] of that after the last
};

/// All runs of at least `fewest` invalid beams in a full turn.
inline std::vector<InvalidBeams> invalid_beams(std::span<const float> ranges, std::size_t fewest) {
  std::vector<InvalidBeams> runs;
  const std::size_t n = ranges.size();
  const auto valid = std::ranges::find_if(ranges, [](float range) { return range > 0.0F; });
  if (valid == ranges.end()) return n < fewest ? runs : std::vector<InvalidBeams>{{0, n, 0.0F, 0.0F}};

  const auto start = static_cast<std::size_t>(valid - ranges.begin());
  InvalidBeams run{start + 1, 0, *valid, 0.0F};
  for (std::size_t k = 1; k <= n; ++k) {
    const float range = ranges[(start + k) % n];
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

}  // namespace threewe::safety
