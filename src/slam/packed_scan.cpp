#include "slam/packed_scan.hpp"
#include "core/exact.hpp"

#include <algorithm>
#include <cmath>

namespace threewe::slam {
namespace {

constexpr double kOriginStep = 1e-4;                             // [m]
constexpr double kDirectionStep = 2.0 * exact::kPi / (1 << 16);  // [rad]
constexpr std::uint16_t kHit = 1;
constexpr std::uint16_t kThin = 2;

std::int16_t steps(double metres) {
  return static_cast<std::int16_t>(std::clamp(std::floor(metres / kOriginStep + 0.5), -32767.0, 32767.0));
}

}  // namespace

PackedScan packed(std::span<const map::Beam> beams) {
  PackedScan scan;
  if (beams.empty()) return scan;
  scan.origin = beams.front().origin;
  scan.beams.reserve(beams.size());
  for (const map::Beam& beam : beams) {
    const double turns = std::floor(exact::atan2(beam.direction.y, beam.direction.x) / kDirectionStep + 0.5);
    const Vec2 origin = beam.origin - scan.origin;
    const int kind = (beam.hit ? kHit : 0) | (beam.thin ? kThin : 0);
    scan.beams.push_back({static_cast<float>(beam.range), static_cast<std::uint16_t>(static_cast<int>(turns) & 0xFFFF),
                          steps(origin.x), steps(origin.y), static_cast<std::uint16_t>(kind)});
  }
  return scan;
}

std::vector<map::Beam> unpacked(const PackedScan& scan, const Pose2D& frame_from_base) {
  const auto [sin, cos] = exact::sincos(frame_from_base.theta);
  const auto turned = [s = sin, c = cos](Vec2 p) { return Vec2{c * p.x - s * p.y, s * p.x + c * p.y}; };
  std::vector<map::Beam> beams;
  beams.reserve(scan.beams.size());
  for (const PackedBeam& beam : scan.beams) {
    const Vec2 origin = scan.origin + kOriginStep * Vec2{double(beam.origin_x), double(beam.origin_y)};
    const auto [s, c] = exact::sincos(beam.direction * kDirectionStep + frame_from_base.theta);
    beams.push_back({frame_from_base.position() + turned(origin),
                     {c, s},
                     static_cast<double>(beam.range),
                     (beam.hit_or_thin & kHit) != 0,
                     (beam.hit_or_thin & kThin) != 0});
  }
  return beams;
}

}  // namespace threewe::slam
