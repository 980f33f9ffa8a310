// The room of 44 boxes in which lidars are timed, ours and those of others.
#pragma once

#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "threewe/core/pose.hpp"
#include "threewe/scene/solid.hpp"

namespace threewe::benchmarks {

inline constexpr double kRangeMax = 12.0;  // [m]

// 20 x 15 m: four outer walls, eight inner ones, 32 boxes at random places away from the middle.
inline scene::Slice room() {
  struct Box {
    double x, y, half_length, half_width;
  };
  std::vector<Box> boxes = {{10, 0, 10, .1},       {10, 15, 10, .1},      {0, 7.5, .1, 7.5},   {20, 7.5, .1, 7.5},
                            {6.5, 2.25, .1, 2.25}, {6.5, 7.5, .1, 1.0},   {6.5, 13, .1, 2.0},  {13.5, 2.5, .1, 2.5},
                            {13.5, 8.5, .1, 1.5},  {13.5, 13.5, .1, 1.5}, {10, 10.5, 2.0, .1}, {10, 4.0, 2.0, .1}};
  std::uint64_t state = 12345;
  const auto random = [&] {
    state = (1103515245ULL * state + 12345) % (1ULL << 31);
    return static_cast<double>(state) / static_cast<double>(1ULL << 31);
  };
  while (boxes.size() < 44) {
    const double x = .7 + random() * 18.6;
    const double y = .7 + random() * 13.6;
    const double half_length = .15 + .35 * random();
    const double half_width = .15 + .35 * random();
    if (std::hypot(x - 10, y - 7.5) > 2.3) boxes.push_back({x, y, half_length, half_width});
  }

  scene::Slice slice;
  for (const auto& [x, y, l, w] : boxes) {
    const Vec2 corners[4] = {{x - l, y - w}, {x + l, y - w}, {x + l, y + w}, {x - l, y + w}};
    for (int i = 0; i < 4; ++i) slice.segments.push_back({corners[i], corners[(i + 1) % 4], -1});
  }
  return slice;
}

// Poses that no box covers.
inline std::vector<Pose2D> free_poses() {
  const scene::Slice slice = room();
  std::mt19937_64 bits(1);
  std::uniform_real_distribution<double> x(0.5, 19.5);
  std::uniform_real_distribution<double> y(0.5, 14.5);
  std::uniform_real_distribution<double> heading(-3.1, 3.1);
  std::vector<Pose2D> poses;
  while (poses.size() < 1024) {
    const Pose2D pose{x(bits), y(bits), heading(bits)};
    bool covered = false;
    for (std::size_t i = 0; i < slice.segments.size(); i += 4) {
      const Vec2 low = slice.segments[i].a;
      const Vec2 high = slice.segments[i + 1].b;
      covered = covered || (pose.x > low.x && pose.x < high.x && pose.y > low.y && pose.y < high.y);
    }
    if (!covered) poses.push_back(pose);
  }
  return poses;
}

}  // namespace threewe::benchmarks
