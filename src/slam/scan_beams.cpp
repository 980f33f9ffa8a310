#include "slam/scan_beams.hpp"
#include "core/exact.hpp"

#include <algorithm>
#include <cmath>
#include <span>

namespace threewe::slam {
namespace {

constexpr std::size_t kBlock = 8;  // beams between poses that are computed, less than 3 ms

// Does the last beam have the first one beside it?
bool is_full_turn(const LaserScan& scan) {
  return (static_cast<double>(scan.ranges.size()) + 0.5) * scan.angle_increment > 2.0 * exact::kPi;
}

// Does beam i hit something narrow, with what is behind it visible on both sides?
bool is_thin(const LaserScan& scan, std::size_t i, bool full_turn, const Params::Beams& params) {
  const std::size_t n = scan.ranges.size();
  const auto range = static_cast<double>(scan.ranges[i]);
  const double beams = params.narrow / (range * scan.angle_increment);
  const std::size_t widest = beams < static_cast<double>(n) ? static_cast<std::size_t>(beams) + 1 : n;
  // how many beams to one side, of `room`, until one passes; 0 when something else is there, or no beam looked
  const auto edge = [&](std::size_t step, std::size_t room) -> std::size_t {
    for (std::size_t k = 1; k <= widest && k <= room; ++k) {
      const auto other = static_cast<double>(scan.ranges[(i + k * step) % n]);
      if (other > range + params.behind) return k;
      if (other < range - params.in_front) return 0;  // invalid, or in front
    }
    return 0;
  };
  const std::size_t left = edge(1, full_turn ? n - 1 : n - 1 - i);
  const std::size_t right = edge(n - 1, full_turn ? n - 1 : i);
  return left > 0 && right > 0 && left + right - 2 < widest;
}

// To which side of beam i the surface that it hits comes nearer: -1 to the beam before, 1 to the one after.
int nearer_side(const LaserScan& scan, std::size_t i, double farthest, bool full_turn, const Params::Beams& params) {
  const std::size_t n = scan.ranges.size();
  const auto range = static_cast<double>(scan.ranges[i]);
  // how much farther that of another beam is; 0 where it hits nothing, or something else
  const auto farther = [&](std::size_t other) {
    const auto there = static_cast<double>(scan.ranges[other]);
    return there > 0.0 && there < farthest && std::fabs(there - range) < params.most_spacing ? there - range : 0.0;
  };
  const double after = i + 1 < n || full_turn ? farther((i + 1) % n) : 0.0;
  const double before = i > 0 || full_turn ? farther((i + n - 1) % n) : 0.0;
  return after > before ? -1 : after < before ? 1 : 0;
}

Vec2 hit_of(const map::Beam& beam) { return beam.origin + beam.range * beam.direction; }

// Whether four beams side by side hit one flat surface.
bool lies_flat(std::span<const map::Beam, 4> beams, const Params::Beams& params) {
  for (const map::Beam& beam : beams) {
    if (!beam.hit || beam.thin) return false;
  }
  const Vec2 from = hit_of(beams[1]);
  const Vec2 way = hit_of(beams[2]) - from;
  const double length = norm(way);
  if (length == 0.0 || length > params.most_spacing) return false;
  const auto continues = [&](const map::Beam& outer, const map::Beam& inner) {
    const Vec2 off = hit_of(outer) - from;
    return std::fabs(cross(way, off)) < params.flat * length &&
           distance(hit_of(outer), hit_of(inner)) < params.most_spacing;
  };
  return continues(beams[0], beams[1]) && continues(beams[3], beams[2]);
}

}  // namespace

double point_offset(int points_per_turn, double angle_increment) {
  if (points_per_turn <= 0 || angle_increment == 0.0) return 0.0;
  const double beams = std::round(2.0 * exact::kPi / std::fabs(angle_increment));
  return std::max(0.5 - 0.5 * beams / points_per_turn, 0.0);
}

std::vector<map::Beam> beams_of(const LaserScan& scan, double range_max,
                                const std::function<Pose2D(std::size_t)>& frame_from_lidar, const Params::Beams& params,
                                double offset) {
  std::vector<map::Beam> beams;
  beams.reserve(scan.ranges.size());
  const bool full_turn = is_full_turn(scan);
  const double farthest = std::min(range_max, scan.range_max);
  Pose2D next = frame_from_lidar(0);
  Pose2D last;
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    if (i % kBlock == 0) {
      last = next;
      next = frame_from_lidar(i + kBlock);
    }
    const Pose2D here = interpolate(last, next, static_cast<double>(i % kBlock) / kBlock);

    const auto range = static_cast<double>(scan.ranges[i]);
    if (!(range >= scan.range_min) || range <= 0.0) continue;
    const bool hit = range < farthest;
    const double length = hit ? range : std::min(params.free_no_return, farthest);
    const double place = static_cast<double>(i) +
                         (hit && offset > 0.0 ? offset * nearer_side(scan, i, farthest, full_turn, params) : 0.0);
    const double angle = here.theta + scan.angle_min + place * scan.angle_increment;
    beams.push_back(
        {here.position(), rotate({1.0, 0.0}, angle), length, hit, hit && is_thin(scan, i, full_turn, params)});
  }
  return beams;
}

std::vector<map::Beam> transformed(const Pose2D& a_from_b, std::vector<map::Beam> beams_in_b) {
  const auto [sin, cos] = exact::sincos(a_from_b.theta);
  const auto turned = [s = sin, c = cos](Vec2 p) { return Vec2{c * p.x - s * p.y, s * p.x + c * p.y}; };
  for (map::Beam& beam : beams_in_b) {
    beam.origin = a_from_b.position() + turned(beam.origin);
    beam.direction = turned(beam.direction);
  }
  return beams_in_b;
}

std::vector<map::Beam> filled(const std::vector<map::Beam>& beams, double spacing, const Params::Beams& params) {
  std::vector<map::Beam> all;
  all.reserve(2 * beams.size());
  for (std::size_t i = 0; i < beams.size(); ++i) {
    all.push_back(beams[i]);
    if (i < 1 || i + 2 >= beams.size() || !lies_flat(std::span(beams).subspan(i - 1).first<4>(), params)) continue;
    const Vec2 from = hit_of(beams[i]);
    const Vec2 way = hit_of(beams[i + 1]) - from;
    const int pieces = static_cast<int>(norm(way) / spacing) + 1;
    for (int k = 1; k < pieces; ++k) {
      const Vec2 ray = from + (static_cast<double>(k) / pieces) * way - beams[i].origin;
      const double range = norm(ray);
      all.push_back({beams[i].origin, (1.0 / range) * ray, range, true, false});
    }
  }
  return all;
}

map::LogOddsMap drawn(const std::vector<std::vector<map::Beam>>& scans, const map::LogOddsMap::Settings& settings,
                      double range_bias) {
  Vec2 low;
  Vec2 high;
  for (const std::vector<map::Beam>& scan : scans) {
    for (const map::Beam& beam : scan) {
      for (const Vec2 p : {beam.origin, beam.origin + beam.range * beam.direction}) {
        low = {std::min(low.x, p.x), std::min(low.y, p.y)};
        high = {std::max(high.x, p.x), std::max(high.y, p.y)};
      }
    }
  }
  map::LogOddsMap map(settings);
  if (!scans.empty()) map.make_room(low, high);
  for (const std::vector<map::Beam>& scan : scans) map.insert(scan, range_bias);
  return map;
}

}  // namespace threewe::slam
