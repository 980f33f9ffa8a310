#include "map/change_log.hpp"

#include <algorithm>

namespace threewe::map {

Region united(const Region& a, const Region& b) {
  if (a.empty()) return b;
  if (b.empty()) return a;
  return {{std::min(a.low.x, b.low.x), std::min(a.low.y, b.low.y)},
          {std::max(a.high.x, b.high.x), std::max(a.high.y, b.high.y)}};
}

void ChangeLog::note(std::uint64_t version, const Region& changed) {
  newest_ = version;
  changed_[version % kKept] = changed;
}

std::optional<Region> ChangeLog::since(std::uint64_t version) const {
  if (version > newest_ || newest_ - version > kKept) return {};
  Region all;
  for (std::uint64_t v = version + 1; v <= newest_; ++v) all = united(all, changed_[v % kKept]);
  return all;
}

}  // namespace threewe::map
