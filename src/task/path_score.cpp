#include "task/path_score.hpp"
#include "core/exact.hpp"

#include <algorithm>
#include <cassert>

namespace threewe::task {
namespace {

// One more point of the robot's: one more row of the table of dynamic programming.
void add_row(PathScore& score, const std::vector<Vec2>& reference, Vec2 robot) {
  double before = score.cost[0];  // of one point less of both
  score.cost[0] += distance(robot, reference[0]);
  for (std::size_t i = 1; i < reference.size(); ++i) {
    const double cheapest = std::min({before, score.cost[i], score.cost[i - 1]});
    before = score.cost[i];
    score.cost[i] = cheapest + distance(robot, reference[i]);
  }
  score.last = robot;
}

}  // namespace

std::vector<Vec2> points_along(const std::vector<Vec2>& corners, double spacing) {
  std::vector<Vec2> points = {corners.front()};
  double left = spacing;  // to the next point
  for (std::size_t i = 1; i < corners.size(); ++i) {
    const double length = distance(corners[i - 1], corners[i]);
    while (left < length) {
      points.push_back(corners[i - 1] + (left / length) * (corners[i] - corners[i - 1]));
      left += spacing;
    }
    left -= length;
  }
  if (points.back() != corners.back()) points.push_back(corners.back());
  return points;
}

PathScore begin_score(const std::vector<Vec2>& reference, Vec2 start) {
  assert(!reference.empty() && reference.size() <= kMostPathPoints);
  PathScore score;
  double sum = 0.0;
  for (std::size_t i = 0; i < reference.size(); ++i) score.cost.at(i) = sum += distance(start, reference[i]);
  score.robot = start;
  score.last = start;
  return score;
}

void advance(PathScore& score, const std::vector<Vec2>& reference, Vec2 robot) {
  const double length = distance(score.robot, robot);
  while (score.next < length) {
    add_row(score, reference, score.robot + (score.next / length) * (robot - score.robot));
    score.next += kPathSpacing;
  }
  score.next -= length;
  score.robot = robot;
}

double ndtw(PathScore score, const std::vector<Vec2>& reference) {
  if (score.robot != score.last) add_row(score, reference, score.robot);
  const auto points = static_cast<double>(reference.size());
  return exact::exp(-score.cost[reference.size() - 1] / (points * kPathThreshold));
}

}  // namespace threewe::task
