#include "core/names.hpp"

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

// What no XML document holds: control characters but tabs and line feeds, and U+FFFE and U+FFFF.
bool has_control_characters(std::string_view text, std::string_view allowed) {
  const bool control = std::ranges::any_of(text, [&](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return (byte < 0x20 || byte == 0x7F) && allowed.find(c) == std::string_view::npos;
  });
  return control || text.find("\xEF\xBF\xBE") != std::string_view::npos ||
         text.find("\xEF\xBF\xBF") != std::string_view::npos;
}

}  // namespace

bool is_text(std::string_view text) { return !has_control_characters(text, "\t\n"); }

bool is_name(std::string_view text) {
  constexpr std::size_t kLongest = 200;  // [bytes] file systems take 255, with a suffix
  return !text.empty() && text.size() <= kLongest && text.front() != '.' && !has_control_characters(text, "") &&
         text.find_first_of("/\\") == std::string_view::npos;
}

std::string_view cut_text(std::string_view text, std::size_t most) {
  if (text.size() <= most) return text;
  const auto continues = [&](std::size_t at) { return (static_cast<unsigned char>(text[at]) & 0xC0U) == 0x80U; };
  while (most > 0 && continues(most)) --most;
  return text.substr(0, most);
}

std::string not_a_name(std::string_view text) {
  std::string shown(cut_text(text, 40));
  std::ranges::replace_if(shown, [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; }, '?');
  return fmt::format(
      "expected a name of at most 200 bytes, without control characters and slashes, that does not begin with a dot, "
      "got '{}'",
      shown);
}

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
