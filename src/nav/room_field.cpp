#include "nav/room_field.hpp"
#include "core/exact.hpp"
#include "core/numbers.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <queue>
#include <utility>

namespace threewe::nav {
namespace {

double room_at(Vec2 place, std::span<const Vec2> hits, double most) {
  double least = most * most;
  for (const Vec2 p : hits) least = std::min(least, dot(p - place, p - place));
  return exact::sqrt(least);
}

}  // namespace

RoomField::RoomField(std::span<const Vec2> hits, double cell, double least, double wanted, double reach)
    : cell_(cell), half_(static_cast<int>(std::ceil(reach / cell_))), least_(least) {
  const int side = 2 * half_ + 1;
  const int cells = side * side;
  way_.assign(static_cast<std::size_t>(cells), kInfinity);
  std::vector<std::size_t> wide;
  std::vector<std::size_t> edge;
  for (std::size_t i = 0; i < way_.size(); ++i) {
    room_.push_back(room_at(center(i), hits, wanted));
    if (room_.back() >= wanted) wide.push_back(i);
    if (room_.back() >= least && norm(center(i)) >= reach - cell_) edge.push_back(i);
  }
  spread(wide);
  if (!std::isfinite(way_from({}))) spread(edge);
}

double RoomField::way_from(Vec2 place) const { return way_[cell_at(place)]; }

std::size_t RoomField::cell_at(Vec2 place) const {
  const auto along = [&](double v) { return std::clamp(static_cast<int>(std::floor(v / cell_ + 0.5)), -half_, half_); };
  const int number = (along(place.y) + half_) * (2 * half_ + 1) + along(place.x) + half_;
  return static_cast<std::size_t>(number);
}

Vec2 RoomField::center(std::size_t cell) const {
  const int side = 2 * half_ + 1;
  const int row = static_cast<int>(cell) / side;
  const int column = static_cast<int>(cell) % side;
  return {cell_ * (column - half_), cell_ * (row - half_)};
}

// Dijkstra's algorithm from all ends at once; the robot's own cell counts as free, it stands there.
void RoomField::spread(const std::vector<std::size_t>& ends) {
  using Entry = std::pair<double, std::size_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  for (const std::size_t i : ends) way_[i] = 0.0, open.emplace(0.0, i);
  const int side = 2 * half_ + 1;
  while (!open.empty()) {
    const auto [way, at] = open.top();
    open.pop();
    if (way > way_[at]) continue;
    const int x = static_cast<int>(at) % side;
    const int y = static_cast<int>(at) / side;
    for (int k = 0; k < 9; ++k) {
      const int dx = k % 3 - 1;
      const int dy = k / 3 - 1;
      if (x + dx < 0 || y + dy < 0 || x + dx >= side || y + dy >= side) continue;
      const int neighbour = (y + dy) * side + x + dx;
      const auto next = static_cast<std::size_t>(neighbour);
      const double there = way + cell_ * exact::sqrt(static_cast<double>(dx * dx + dy * dy));
      if (there >= way_[next] || (room_[next] < least_ && norm(center(next)) > cell_ * 1.5)) continue;
      way_[next] = there;
      open.emplace(there, next);
    }
  }
}

}  // namespace threewe::nav
