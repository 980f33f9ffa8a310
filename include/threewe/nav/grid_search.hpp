// Shortest paths on a grid of weights.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "threewe/map/costmap.hpp"

namespace threewe::nav {

/// What a search found.
struct SearchResult {
  bool found = false;           ///< false: everything that can be reached was searched
  std::uint32_t cost = 0;       ///< of the path, see `GridSearch`
  std::vector<map::Cell> path;  ///< from the start to the target or, if not found, to the cell nearest to it
};

/// A* and Dijkstra over a costmap, 8-connected. A step costs 5 (7 diagonally) times the sum of the weights of its two
/// cells, an integer, so that ties are ties; they are broken by the order of expansion, which never varies. Buffers
/// are kept between searches.
class GridSearch {
 public:
  /// The cheapest path to `goal`.
  SearchResult to_cell(const map::Costmap& costmap, map::Cell start, map::Cell goal);
  /// The cheapest path to any cell for which `is_target(index)`. Cells for which `blocked(index)` are never entered.
  template <class IsTarget, class Blocked>
  SearchResult to_any(const map::Costmap& costmap, map::Cell start, IsTarget is_target, Blocked blocked) {
    return search(costmap, start, [](map::Cell) { return std::uint32_t{0}; }, is_target, blocked);
  }

 private:
  static constexpr std::uint32_t kUnreached = 0xFFFFFFFF;
  static constexpr std::uint32_t kStartWeight = 100;  // at most, where a search starts in a lethal cell
  static constexpr std::size_t kBuckets = 2048;       // more than any step, with its change of heuristic, can cost

  template <class Heuristic, class IsTarget, class Blocked>
  SearchResult search(const map::Costmap& costmap, map::Cell start, Heuristic heuristic, IsTarget is_target,
                      Blocked blocked);
  std::vector<map::Cell> path_to(const map::Costmap& costmap, std::uint32_t index) const;

  struct Entry {
    std::uint32_t index;
    std::uint32_t cost;
  };
  std::vector<std::uint32_t> cost_;
  std::vector<std::uint8_t> arrived_by_;               // direction of the last step, 8 at the start
  std::vector<std::vector<Entry>> buckets_{kBuckets};  // entries by cost + heuristic, modulo kBuckets
};

inline constexpr std::array<map::Cell, 8> kDirections = {
    {{1, 0}, {0, 1}, {-1, 0}, {0, -1}, {1, 1}, {-1, 1}, {-1, -1}, {1, -1}}};

template <class Heuristic, class IsTarget, class Blocked>
SearchResult GridSearch::search(const map::Costmap& costmap, map::Cell start, Heuristic heuristic, IsTarget is_target,
                                Blocked blocked) {
  SearchResult result;
  if (!costmap.contains(start)) return result;
  cost_.assign(costmap.weights().size(), kUnreached);
  arrived_by_.assign(costmap.weights().size(), 8);

  // entries wait in the bucket of their key; keys never fall, so a ring of buckets is a priority queue
  std::size_t waiting = 1;
  std::uint32_t key = heuristic(start);
  const auto first = static_cast<std::uint32_t>(costmap.index(start));
  cost_[first] = 0;
  buckets_[key % kBuckets].push_back({first, 0});
  std::uint32_t nearest = first;
  std::uint32_t nearest_distance = heuristic(start);

  const auto width = static_cast<std::uint32_t>(costmap.width());
  while (waiting > 0) {
    std::vector<Entry>& bucket = buckets_[key % kBuckets];
    if (bucket.empty()) {
      ++key;
      continue;
    }
    const Entry entry = bucket.back();
    bucket.pop_back();
    --waiting;
    if (entry.cost != cost_[entry.index]) continue;  // a cheaper way was found since

    const map::Cell here{static_cast<int>(entry.index % width), static_cast<int>(entry.index / width)};
    if (const std::uint32_t d = heuristic(here); d < nearest_distance) nearest = entry.index, nearest_distance = d;
    if (is_target(entry.index)) {
      result.found = true;
      nearest = entry.index;
      break;
    }
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
      buckets_[(cost + heuristic(there)) % kBuckets].push_back({index, cost});
      ++waiting;
    }
  }
  if (waiting > 0) {
    for (std::vector<Entry>& bucket : buckets_) bucket.clear();
  }
  result.cost = cost_[nearest];
  result.path = path_to(costmap, nearest);
  return result;
}

}  // namespace threewe::nav
