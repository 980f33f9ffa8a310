// Drawn rooms, and robots that drive through them with the scanners and odometers of old robots.
#pragma once

#include <cmath>
#include <vector>

#include "core/exact.hpp"
#include "draw.hpp"
#include "slam/tiny_world.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/core/samples.hpp"

namespace threewe::testing {

/// How a lidar looks around.
struct Fan {
  int beams = 180;
  double angle_min = -0.5 * exact::kPi;
  double increment = exact::kPi / 180.0;
  double sigma = 0.01;
};

inline LaserScan look(const std::vector<TinyWall>& walls, const Pose2D& lidar, const Fan& fan, Draw& draw) {
  LaserScan scan{fan.angle_min, fan.increment, 0.0, 0.0, 80.0, {}};
  for (int i = 0; i < fan.beams; ++i) {
    const double range = tiny_range(walls, lidar.position(), lidar.theta + fan.angle_min + i * fan.increment, 80.0);
    const double noise = draw(-1.7, 1.7) * fan.sigma;  // of the deviation sigma
    scan.ranges.push_back(static_cast<float>(range < 80.0 ? range + noise : 80.0));
  }
  return scan;
}

/// Rooms beside a hall, with things in them.
inline std::vector<TinyWall> building(Draw& draw) {
  std::vector<TinyWall> walls;
  add_box(walls, {-2, -6}, {14, 6});
  for (double x : {2.0, 6.0, 10.0}) {
    walls.push_back({{x, 2}, {x, 6}});
    walls.push_back({{x + 1, -6}, {x + 1, -3.2}});
  }
  for (double x : {-2.0, 2.0, 6.0, 10.0}) walls.push_back({{x + 1.0, 2}, {x + 3.4, 2}});
  for (int i = 0; i < 6; ++i) {
    const Vec2 corner{-1.0 + 2.5 * i, i % 2 == 0 ? 4.2 : -5.0};
    add_box(walls, corner, corner + Vec2{draw(0.3, 0.9), draw(0.3, 0.9)});
  }
  return walls;
}

/// A robot on an oval course, whose odometry is wrong in scale and heading; a scan every `stride` metres.
struct Tour {
  std::vector<Pose2D> truth;
  std::vector<Pose2D> odometry;
};
inline Tour tour(Draw& draw, double metres, double stride = 0.5) {
  const double scale = draw(0.98, 1.02);
  const double veer = draw(-0.04, 0.04);                  // [rad/m]
  const double wobble = 0.1 * exact::sqrt(3.0 * stride);  // [rad], uniform: 0.1 rad/sqrt(m)
  Tour t{{{0, 0, 0}}, {{draw(-5, 5), draw(-5, 5), draw(-3, 3)}}};
  for (int i = 1; i * stride < metres; ++i) {
    const bool ahead = std::fmod((i - 1) * stride, 14.0) < 10.0;  // then round, on half a circle of 4 m
    const double turn = ahead ? 0.0 : -exact::kPi / 4.0 * stride;
    t.truth.push_back(integrate(t.truth.back(), {stride, 0.0, turn}, 1.0));
    const double believed = turn + veer * stride + draw(-wobble, wobble);
    t.odometry.push_back(integrate(t.odometry.back(), {stride * scale, 0.0, believed}, 1.0));
  }
  return t;
}

}  // namespace threewe::testing
