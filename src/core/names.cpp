#include "threewe/core/names.hpp"

#include <algorithm>
#include <numeric>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace threewe {
namespace {

// The edits that make `a` into `b`, or into a beginning of `b` (`office` of `office_v2`) and one more.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t substituted = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, substituted});
    }
  }
  if (b.size() <= a.size()) return row[b.size()];
  return std::min(row[b.size()], 1 + *std::min_element(row.begin() + static_cast<std::ptrdiff_t>(a.size()), row.end()));
}

}  // namespace

std::string nearest_name(std::string_view name, std::span<const std::string> candidates) {
  std::string best;
  if (name.empty()) return best;
  std::size_t least = std::max<std::size_t>(name.size() < 3 ? 1 : 2, name.size() / 2) + 1;
  for (const std::string& candidate : candidates) {
    const std::size_t edits = edit_distance(name, candidate);
    if (edits < least) {
      least = edits;
      best = candidate;
    }
  }
  return best;
}

std::string unknown_name(std::string_view kind, std::string_view name, std::span<const std::string> candidates) {
  const std::string nearest = nearest_name(name, candidates);
  if (!nearest.empty()) return fmt::format("unknown {} '{}'; did you mean '{}'?", kind, name, nearest);
  if (candidates.empty()) return fmt::format("unknown {} '{}'; there are none", kind, name);
  return fmt::format("unknown {} '{}'; known: {}", kind, name, fmt::join(candidates, ", "));
}

}  // namespace threewe
