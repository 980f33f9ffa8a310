#include "vision/color_terms.hpp"

#include <algorithm>

namespace threewe::vision {
namespace {

enum Term : std::uint8_t { black, white, gray, red, green, blue, yellow, orange, brown, pink, purple };

// The hue in 1/6 of 256: 0 red, 256 yellow, 512 green, 768 cyan, 1024 blue, 1280 magenta.
int hue_of(int b, int g, int r, int low, int high) {
  const int range = high - low;
  if (high == r) return (256 * (g - b) / range + 1536) % 1536;
  if (high == g) return 512 + 256 * (b - r) / range;
  return 1024 + 256 * (r - g) / range;
}

}  // namespace

std::uint8_t color_term(std::uint8_t blue_, std::uint8_t green_, std::uint8_t red_) {
  const int b = blue_;
  const int g = green_;
  const int r = red_;
  const int high = std::max({b, g, r});
  const int low = std::min({b, g, r});
  if (high < 48) return black;
  const int saturation = 255 * (high - low) / high;
  if (saturation < 44) return high < 72 ? black : high > 196 ? white : gray;
  const int hue = hue_of(b, g, r, low, high);
  if (hue < 70 || hue >= 1450) {
    if (high > 180 && saturation < 130) return pink;
    return high < 120 && saturation < 150 && hue < 70 ? brown : red;
  }
  if (hue < 200) {
    // dark or dull oranges are called brown
    if (high > 190 && saturation > 140) return orange;
    return high > 214 && saturation < 90 ? (saturation < 60 ? white : yellow) : brown;
  }
  if (hue < 300) return high < 130 ? (hue < 256 ? brown : green) : yellow;
  if (hue < 700) return green;
  if (hue < 1100) return blue;
  if (hue < 1290) return purple;
  return high > 170 ? pink : purple;
}

}  // namespace threewe::vision
