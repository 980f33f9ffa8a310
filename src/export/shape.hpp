// Exported shapes: simple bodies with a colour.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "export/transform.hpp"

namespace threewe::exports {

/// Red, green and blue, each 0 to 1.
struct Color {
  double red = 0.0;
  double green = 0.0;
  double blue = 0.0;
  friend bool operator==(const Color&, const Color&) = default;
};

/// The colour of a material, of an object or of a floor, as scenes name it; that of plastic for any other name.
Color color_of(std::string_view material);

/// A simple body in the frame of what it belongs to.
struct Shape {
  enum class Kind : std::uint8_t { box, cylinder, sphere, ellipsoid };
  std::string name{};
  Kind kind{};
  Transform pose{};  ///< of its middle; a cylinder's axis is its z axis
  Vec3 size{};       ///< [m] edges of a box; radius, radius and length of a cylinder; semi-axes of the others
  Color color{};
  bool visible = true;
  bool collides = true;
};

}  // namespace threewe::exports
