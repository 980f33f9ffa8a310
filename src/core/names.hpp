// Edit distance: the nearest right name of a mistyped one.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace threewe {

/// Whether a text can name a thing in every format that things are exported to, and be a file's name: UTF-8 of 1 to 200
/// bytes without control characters, slashes and backslashes that does not begin with a dot.
bool is_name(std::string_view text);
/// Whether a text has no control characters but tabs and line feeds.
bool is_text(std::string_view text);
/// The first `most` bytes of UTF-8 text, or fewer: no character is cut in two.
std::string_view cut_text(std::string_view text, std::size_t most);
/// "expected a name of ..., got '...'"
std::string not_a_name(std::string_view text);

/// The candidate with the smallest edit distance to `name`; empty when none is near enough to be meant.
std::string nearest_name(std::string_view name, std::span<const std::string> candidates);

/// "unknown scene 'ofice_v2'; did you mean 'office_v2'?" or, with nothing near, "...; known: a, b, c".
std::string unknown_name(std::string_view kind, std::string_view name, std::span<const std::string> candidates);

}  // namespace threewe
