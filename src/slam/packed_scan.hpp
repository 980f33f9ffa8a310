// Compressed scans that are kept for long, in a quarter of the memory.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "map/log_odds_map.hpp"
#include "threewe/core/pose.hpp"

namespace threewe::slam {

/// One beam: its range as it was measured, where it came from to 0.1 mm and its direction to 0.05 mrad, 1.5 mm at 30 m.
struct PackedBeam {
  float range = 0.0F;             ///< [m]
  std::uint16_t direction = 0;    ///< [turn/65536]
  std::int16_t origin_x = 0;      ///< [0.1 mm] from where the scan's first beam came from
  std::int16_t origin_y = 0;      ///< a scan during which the robot moved by more than 3 m loses the rest
  std::uint16_t hit_or_thin = 0;  ///< 1: a hit, 2: a thin thing
  friend bool operator==(const PackedBeam&, const PackedBeam&) = default;
};

/// A scan's beams in the base frame.
struct PackedScan {
  Vec2 origin;  ///< [m] of the first beam
  std::vector<PackedBeam> beams;
  friend bool operator==(const PackedScan&, const PackedScan&) = default;
};

PackedScan packed(std::span<const map::Beam> beams);
/// The beams again, seen from another frame.
std::vector<map::Beam> unpacked(const PackedScan& scan, const Pose2D& frame_from_base);

}  // namespace threewe::slam
