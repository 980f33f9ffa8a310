#include "map/blind_surface.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/exact.hpp"

namespace threewe::map {
namespace {

constexpr double kBlindRim = 0.06;  // [m] beyond the blind disc, within which a surface that leads into it is seen
constexpr double kLeast = 0.06;     // [m] between hits, less is no hole
constexpr double kSpacing = 0.015;  // [m] between the points
constexpr double kSeen = 0.05;      // [m] of the line on either side that may lie outside of the blind disc

struct Hit {
  double bearing = 0.0;
  Vec2 from_lidar;
};

bool is_at_rim(Vec2 from_lidar, double range_min) { return norm(from_lidar) < range_min + kBlindRim; }

// All of them, by bearing; none where nothing is near.
std::vector<Hit> round_about(std::span<const Vec2> hits, Vec2 lidar, double range_min) {
  std::vector<Hit> round;
  if (std::ranges::none_of(hits, [&](Vec2 hit) { return is_at_rim(hit - lidar, range_min); })) return round;
  for (const Vec2 hit : hits) round.push_back({exact::atan2(hit.y - lidar.y, hit.x - lidar.x), hit - lidar});
  std::ranges::sort(round, {}, &Hit::bearing);
  return round;
}

// The points of a line within the blind disc; none where it leads where the lidar would have seen it.
std::vector<Vec2> within(double range_min, Vec2 a, Vec2 b) {
  std::vector<Vec2> points;
  const double length = distance(a, b);
  const int parts = static_cast<int>(length / kSpacing);
  for (int i = 1; i < parts; ++i) {
    const double share = static_cast<double>(i) / parts;
    const Vec2 p = a + share * (b - a);
    if (norm(p) < range_min) {
      points.push_back(p);
    } else if (length * std::min(share, 1.0 - share) > kSeen) {
      return {};
    }
  }
  return points;
}

}  // namespace

std::vector<Vec2> blind_surface(std::span<const Vec2> hits, Vec2 lidar, double range_min) {
  const std::vector<Hit> round = round_about(hits, lidar, range_min);
  std::vector<Vec2> surface;
  for (std::size_t i = 0; i < round.size(); ++i) {
    const Hit& a = round[i];
    const Hit& b = round[(i + 1) % round.size()];  // no beam has met anything behind what is between
    if (!is_at_rim(a.from_lidar, range_min) || !is_at_rim(b.from_lidar, range_min)) continue;
    // counter-clockwise from a to b, less than half a turn
    if (cross(a.from_lidar, b.from_lidar) <= 0.0 || distance(a.from_lidar, b.from_lidar) < kLeast) continue;
    for (const Vec2 p : within(range_min, a.from_lidar, b.from_lidar)) surface.push_back(lidar + p);
  }
  return surface;
}

}  // namespace threewe::map
