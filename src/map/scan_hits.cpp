#include "map/scan_hits.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iterator>

#include "core/exact.hpp"

namespace threewe::map {
namespace {

constexpr double kOverlap = 0.125;     // share of a neighbourhood by which it reaches over to the other side
constexpr double kLeastSpread = 0.15;  // of it, along the line, standard deviation; less shows no direction
constexpr double kStraight = 0.75;     // the standard deviation across the line, as a share of that along it, at most
constexpr int kFewest = 6;             // hits that make a line
constexpr double kGrazing = 0.3;       // sine of the angle between ray and surface
constexpr double kDiagonal = 0.70710678118654752;
constexpr double kAlong = 0.5;  // cosine at most between a side and the normal of its line: what lies to the side
                                // of a wall is chosen by its scatter
constexpr std::array<Vec2, 9> kSides = {{{0.0, 0.0},  // all around
                                         {1.0, 0.0},
                                         {kDiagonal, kDiagonal},
                                         {0.0, 1.0},
                                         {-kDiagonal, kDiagonal},
                                         {-1.0, 0.0},
                                         {-kDiagonal, -kDiagonal},
                                         {0.0, -1.0},
                                         {kDiagonal, -kDiagonal}}};

// The sums behind a line through points.
struct Sums {
  int count = 0;
  Vec2 sum;
  double xx = 0.0;
  double xy = 0.0;
  double yy = 0.0;

  void add(Vec2 d) {
    ++count;
    sum = sum + d;
    xx += d.x * d.x, xy += d.x * d.y, yy += d.y * d.y;
  }
};

// The line with the least squares of distances, and the variances across and along it.
struct Line {
  Vec2 mean;
  Vec2 normal;
  double across = 0.0;
  double along = 0.0;
};

Line line_through(const Sums& s) {
  const double n = s.count;
  const Vec2 mean = (1.0 / n) * s.sum;
  const double xx = s.xx / n - mean.x * mean.x;
  const double xy = s.xy / n - mean.x * mean.y;
  const double yy = s.yy / n - mean.y * mean.y;
  const double angle = 0.5 * exact::atan2(2.0 * xy, xx - yy);  // of the longer axis
  const auto [sine, cosine] = exact::sincos(angle);
  const double half = 0.5 * (xx + yy);
  const double root = exact::hypot(0.5 * (xx - yy), xy);
  return {mean, {-sine, cosine}, std::max(half - root, 0.0), half + root};
}

bool is_straight(const Line& line, double least_spread) {
  return line.along >= least_spread * least_spread && line.across <= kStraight * kStraight * line.along;
}

// From the middle of a neighbourhood to its line: along the ray, which errs in its length alone, unless they hardly
// cross.
Vec2 onto(const Line& line, Vec2 ray) {
  const double off = dot(line.mean, line.normal);
  const double range = norm(ray);
  const double crossing = range > 0.0 ? dot(ray, line.normal) / range : 0.0;
  if (std::abs(crossing) < kGrazing) return off * line.normal;
  return (off / (crossing * range)) * ray;
}

}  // namespace

std::vector<Vec2> smoothed(std::span<const Vec2> hits, Vec2 lidar, double neighbourhood) {
  const double overlap = kOverlap * neighbourhood;
  const double least_spread = kLeastSpread * neighbourhood;
  std::vector<Vec2> moved;
  moved.reserve(hits.size());
  for (const Vec2 hit : hits) {
    std::array<Sums, kSides.size()> around;
    for (const Vec2 other : hits) {
      const Vec2 d = other - hit;
      if (dot(d, d) > neighbourhood * neighbourhood) continue;
      for (std::size_t side = 0; side < kSides.size(); ++side) {
        if (dot(d, kSides[side]) >= -overlap) around[side].add(d);
      }
    }
    Line best{{}, {}, neighbourhood * neighbourhood, 0.0};
    for (std::size_t side = 0; side < kSides.size(); ++side) {
      if (around[side].count < kFewest) continue;
      const Line line = line_through(around[side]);
      if (line.across >= best.across || !is_straight(line, least_spread) ||
          std::abs(dot(line.normal, kSides[side])) > kAlong)
        continue;
      best = line;
    }
    moved.push_back(hit + onto(best, hit - lidar));
  }
  return moved;
}

std::vector<Vec2> smoothed_near(Vec2 point, double reach, std::span<const Vec2> hits, Vec2 lidar,
                                double neighbourhood) {
  std::vector<Vec2> near;
  std::ranges::copy_if(hits, std::back_inserter(near), [&](Vec2 hit) { return distance(hit, point) < reach; });
  return smoothed(near, lidar, neighbourhood);
}

}  // namespace threewe::map
