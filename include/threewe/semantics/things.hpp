// Entries of a robot's semantic map: the things that it has seen, and the places that have names.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "threewe/core/pose.hpp"
#include "threewe/core/time.hpp"

namespace threewe::semantics {

/// One thing that was seen, perhaps many times.
struct MappedThing {
  std::uint64_t id = 0;                ///< grows with every new one
  Vec2 position;                       ///< [m] of its centre, in `map`
  std::array<double, 3> covariance{};  ///< [m^2] of the position: xx, xy, yy
  std::vector<double> kinds;  ///< probability of each label of the detector, 0 of the background; the rest: of none
  std::array<double, 11> colors{};  ///< share of each color term, see `color`, in all that was seen of it
  int views = 0;                    ///< from different poses
  int misses = 0;                   ///< looks that should have shown it and did not, since it was seen last
  Time last_seen{};                 ///< when it was seen last
  double nearest_view = 0.0;        ///< [m] from which it was seen at the nearest

  /// The most probable kind, index into the detector's labels, see Robot::get_thing_labels.
  std::size_t kind() const;
  /// The color term that most of it has: black, white, gray, red, green, blue, yellow, orange, brown, pink, purple.
  std::size_t color() const;
};

/// Origin of a place that has its name by what stands in it.
inline constexpr std::string_view kSeen = "seen";

/// A place that has a name.
struct Place {
  std::string name;              ///< as it was given
  std::vector<Vec2> polygon;     ///< [m] in `map`; one point where the robot stood as it was named
  std::string origin = "given";  ///< "given" by users, or "seen": probably so by what stands there
};

}  // namespace threewe::semantics
