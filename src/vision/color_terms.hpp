// Basic color terms (Berlin and Kay 1969) of pixels.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

namespace threewe::vision {

/// In the order of their numbers.
inline constexpr std::array<std::string_view, 11> kColorTerms = {"black",  "white",  "gray",  "red",  "green", "blue",
                                                                 "yellow", "orange", "brown", "pink", "purple"};

/// The number of the term for a pixel's color, blue, green and red of 255: by hue, saturation and value.
std::uint8_t color_term(std::uint8_t blue, std::uint8_t green, std::uint8_t red);

}  // namespace threewe::vision
