// Dijkstra search over a costmap, for the nearest of many targets.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "map/costmap.hpp"

namespace threewe::nav {

/// What a search found.
struct SearchResult {
  bool found = false;           ///< false: everything that can be reached was searched
  std::uint32_t cost = 0;       ///< of the path, see `GridSearch`
  std::vector<map::Cell> path;  ///< from the start to the target, both included
};

/// Dijkstra's search over a costmap, 8-connected, for the nearest of many targets; `TileGraph` is for one that may be
/// far away. A step costs 5 (7 diagonally) times the sum of the weights of its two cells, an integer, so that ties are
/// ties; they are broken by the order of expansion, which never varies. Buffers are kept between searches.
class GridSearch {
 public:
  /// The cheapest path to any cell for which `is_target(index)`. Cells for which `blocked(index)` are never entered.
  template <class IsTarget, class Blocked>
  SearchResult to_any(const map::Costmap& costmap, map::Cell start, IsTarget is_target, Blocked blocked) {
    const auto bonus = [&](std::uint32_t index) { return is_target(index) ? std::optional(0) : std::nullopt; };
    return to_best(costmap, start, bonus, 0, blocked);
  }
  /// The cheapest path to the cell for which its cost less `bonus(index)` is least, among those that have a bonus: a
  /// cost, at most `most`, that may be negative. The nearest of equals. `bonus` is asked once for each cell, in the
  /// order of the costs.
  template <class Bonus, class Blocked>
  SearchResult to_best(const map::Costmap& costmap, map::Cell start, Bonus bonus, int most, Blocked blocked);

 private:
  static constexpr std::uint32_t kUnreached = 0xFFFFFFFF;
  static constexpr std::uint32_t kStartWeight = 100;  // at most, where a search starts in a lethal cell
  static constexpr std::size_t kBuckets = 2048;       // more than any step can cost

  std::vector<map::Cell> path_to(const map::Costmap& costmap, std::uint32_t index) const;

  struct Entry {
    std::uint32_t index;
    std::uint32_t cost;
  };
  std::vector<std::uint32_t> cost_;
  std::vector<std::uint8_t> arrived_by_;               // direction of the last step, 8 at the start
  std::vector<std::vector<Entry>> buckets_{kBuckets};  // entries by cost, modulo kBuckets
};

inline constexpr std::array<map::Cell, 8> kDirections = {
    {{1, 0}, {0, 1}, {-1, 0}, {0, -1}, {1, 1}, {-1, 1}, {-1, -1}, {1, -1}}};

template <class Bonus, class Blocked>
SearchResult GridSearch::to_best(const map::Costmap& costmap, map::Cell start, Bonus bonus, int most, Blocked blocked) {
  SearchResult result;
  std::uint32_t best = 0;       // cell
  std::int64_t best_value = 0;  // its cost less its bonus
  if (!costmap.contains(start)) return result;
  cost_.assign(costmap.weights().size(), kUnreached);
  arrived_by_.assign(costmap.weights().size(), 8);

  // entries wait in the bucket of their cost; costs never fall, so a ring of buckets is a priority queue
  std::size_t waiting = 1;
  std::uint32_t now = 0;
  const auto first = static_cast<std::uint32_t>(costmap.index(start));
  cost_[first] = 0;
  buckets_[0].push_back({first, 0});

  const auto width = static_cast<std::uint32_t>(costmap.width());
  while (waiting > 0) {
    std::vector<Entry>& bucket = buckets_[now % kBuckets];
    if (bucket.empty()) {
      ++now;
      continue;
    }
    const Entry entry = bucket.back();
    bucket.pop_back();
    --waiting;
    if (entry.cost != cost_[entry.index]) continue;                            // a cheaper way was found since
    if (result.found && std::int64_t{entry.cost} - most >= best_value) break;  // nothing better can come
    if (const std::optional<int> worth = bonus(entry.index)) {
      const std::int64_t value = std::int64_t{entry.cost} - *worth;
      if (!result.found || value < best_value) best = entry.index, best_value = value, result = {true, entry.cost, {}};
    }
    const map::Cell here{static_cast<int>(entry.index % width), static_cast<int>(entry.index / width)};
    const std::uint32_t here_weight = costmap.weights()[entry.index];
    for (std::size_t i = 0; i < kDirections.size(); ++i) {
      const map::Cell there{here.x + kDirections[i].x, here.y + kDirections[i].y};
      if (!costmap.contains(there)) continue;
      const auto index = static_cast<std::uint32_t>(costmap.index(there));
      const std::uint32_t weight = costmap.weights()[index];
      if (weight == map::Costmap::kLethal || blocked(index)) continue;
      const std::uint32_t cost = entry.cost + (i < 4 ? 5U : 7U) * (std::min(here_weight, kStartWeight) + weight);
      if (cost >= cost_[index]) continue;
      cost_[index] = cost;
      arrived_by_[index] = static_cast<std::uint8_t>(i);
      buckets_[cost % kBuckets].push_back({index, cost});
      ++waiting;
    }
  }
  for (std::vector<Entry>& bucket : buckets_) bucket.clear();
  if (result.found) result.path = path_to(costmap, best);
  return result;
}

}  // namespace threewe::nav
