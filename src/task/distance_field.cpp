#include "task/distance_field.hpp"

#include <algorithm>
#include <cmath>

#include "core/numbers.hpp"

namespace threewe::task {
namespace {

constexpr std::uint16_t kNoWay = 65535;

}  // namespace

DistanceField::DistanceField(const scene::SceneTables& tables, Vec2 target)
    : target_(target),
      frame_(tables.passable().frame),
      first_(frame_.center({0, 0})),
      per_metre_(1.0 / frame_.resolution) {
  const scene::GeodesicField exact = tables.geodesic_field(target);
  std::vector<double> lengths(frame_.size(), kInfinity);
  double longest = 0.0;
  for (std::size_t i = 0; i < lengths.size(); ++i) {
    if (!tables.passable().cells[i]) continue;
    lengths[i] = exact.length_from(frame_.center(frame_.cell(i)));
    if (std::isfinite(lengths[i])) longest = std::max(longest, lengths[i]);
  }
  unit_ = std::max(longest, 0.001) / (kNoWay - 1);
  lengths_.reserve(lengths.size());
  for (const double length : lengths) {
    lengths_.push_back(std::isfinite(length) ? static_cast<std::uint16_t>(std::floor(length / unit_ + 0.5)) : kNoWay);
  }
}

double DistanceField::at(int x, int y) const {
  const std::uint16_t length = lengths_[frame_.index({x, y})];
  return length == kNoWay ? kInfinity : unit_ * length;
}

// Bilinear between the four cells around a point; beside obstacles, by way of the best cell nearby.
double DistanceField::length_from(Vec2 point) const {
  const Vec2 place = per_metre_ * (point - first_);
  const bool on_field = place.x >= 1.0 && place.y >= 1.0 && place.x < frame_.width - 2 && place.y < frame_.height - 2;
  if (!on_field) return kInfinity;
  const int x = static_cast<int>(place.x);
  const int y = static_cast<int>(place.y);
  const std::uint16_t* low = &lengths_[frame_.index({x, y})];
  const std::uint16_t* high = &lengths_[frame_.index({x, y + 1})];
  if (std::max({low[0], low[1], high[0], high[1]}) != kNoWay) {
    const auto along = [&](const std::uint16_t* row) {
      const double left = unit_ * row[0];
      return left + (place.x - x) * (unit_ * row[1] - left);
    };
    const double below = along(low);
    return below + (place.y - y) * (along(high) - below);
  }

  const scene::CellIndex cell = frame_.cell(point);
  double shortest = kInfinity;
  for (int row = cell.y - 1; row <= cell.y + 1; ++row) {
    for (int column = cell.x - 1; column <= cell.x + 1; ++column) {
      shortest = std::min(shortest, at(column, row) + distance(point, frame_.center({column, row})));
    }
  }
  return shortest;
}

}  // namespace threewe::task
