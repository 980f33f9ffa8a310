// SHA-256 (FIPS 180-4).
#pragma once

#include <string>
#include <string_view>

namespace threewe::ros2 {

/// The digest of a text, as 64 lower-case hexadecimal digits.
std::string sha256(std::string_view text);

}  // namespace threewe::ros2
