// A walk through the streets of a square city, measured with noise, and what a pose graph is told of it.
#pragma once

#include <cmath>
#include <cstdint>
#include <map>
#include <tuple>
#include <utility>
#include <vector>

#include "core/exact.hpp"
#include "core/rng.hpp"
#include "draw.hpp"
#include "slam/pose_graph.hpp"

namespace threewe::slam::testing {

struct Manhattan {
  std::vector<Pose2D> truth;
  std::vector<Constraint> constraints;  // by their later node: first its odometry, then its closures
  std::vector<bool> wrong;              // of each constraint
};

/// How the city is walked and measured.
struct Walk {
  int nodes = 3500;
  double wrong_share = 0.0;  ///< of all closures
  double sigma = 0.03;       ///< [m] of an odometry step of 1 m, along and across
  double turn_sigma = 0.01;  ///< [rad]
};

inline double gauss(Draw& draw) { return normal_quantile(draw(1e-12, 1.0)); }

inline Constraint measured(Draw& draw, const std::vector<Pose2D>& truth, int from, int to, double sigma,
                           double turn_sigma) {
  Constraint c{from, to, inverse(truth[static_cast<std::size_t>(from)]) * truth[static_cast<std::size_t>(to)]};
  c.from_from_to.x += sigma * gauss(draw);
  c.from_from_to.y += sigma * gauss(draw);
  c.from_from_to.theta = wrap_angle(c.from_from_to.theta + turn_sigma * gauss(draw));
  c.information = Eigen::Vector3d(1 / (sigma * sigma), 1 / (sigma * sigma), 1 / (turn_sigma * turn_sigma)).asDiagonal();
  return c;
}

/// Steps of 1 m, a right angle now and then; places are known again from at most 1.5 m. A wrong closure says that two
/// places drawn at random lie within such a distance.
inline Manhattan draw_manhattan(std::uint64_t seed, const Walk& walk) {
  constexpr double kClosureSigma = 0.03;
  constexpr double kClosureTurn = 0.01;
  constexpr int kBlock = 60;  // [m] the city is so wide: who would leave it turns round
  Draw draw(seed);
  Manhattan m;
  std::map<std::pair<int, int>, std::vector<int>> visited;
  int x = 0, y = 0, heading = 0;
  for (int i = 0; i < walk.nodes; ++i) {
    m.truth.push_back({static_cast<double>(x), static_cast<double>(y), wrap_angle(heading * exact::kPi / 2)});
    if (i > 0) {
      m.constraints.push_back(measured(draw, m.truth, i - 1, i, walk.sigma, walk.turn_sigma));
      m.wrong.push_back(false);
    }
    // closures, one in four: to what was passed near here long ago
    for (int dx = -1; dx <= 1; ++dx) {
      for (int dy = -1; dy <= 1; ++dy) {
        for (const int old : visited[{x + dx, y + dy}]) {
          if (i - old < 30 || draw(0, 1) > 0.25) continue;
          m.constraints.push_back(measured(draw, m.truth, old, i, kClosureSigma, kClosureTurn));
          m.constraints.back().doubtful = true;
          m.wrong.push_back(false);
          if (draw(0, 1) * (1.0 - walk.wrong_share) >= walk.wrong_share) continue;
          Constraint wrong = m.constraints.back();
          wrong.from = draw.whole(0, i - 1);
          wrong.from_from_to = {draw(-1.5, 1.5), draw(-1.5, 1.5), draw(-3.14, 3.14)};
          m.constraints.push_back(wrong);
          m.wrong.push_back(true);
        }
      }
    }
    visited[{x, y}].push_back(i);
    const auto outside = [](int v) { return v < 0 || v > kBlock; };
    const auto step = [&](int h) { return std::pair{x + (h == 0) - (h == 2), y + (h == 1) - (h == 3)}; };
    if (draw(0, 1) < 0.1) heading = (heading + (draw(0, 1) < 0.5 ? 1 : 3)) % 4;
    while (outside(step(heading).first) || outside(step(heading).second)) heading = (heading + 1) % 4;
    std::tie(x, y) = step(heading);
  }
  return m;
}

}  // namespace threewe::slam::testing
