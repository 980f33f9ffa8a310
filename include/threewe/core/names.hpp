// Names that people type, and the nearest right one when they mistype.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace threewe {

/// The candidate with the smallest edit distance to `name`; empty when none is near enough to be meant.
std::string nearest_name(std::string_view name, std::span<const std::string> candidates);

/// "unknown scene 'ofice_v2'; did you mean 'office_v2'?" or, with nothing near, "...; known: a, b, c".
std::string unknown_name(std::string_view kind, std::string_view name, std::span<const std::string> candidates);

}  // namespace threewe
