#include "scene/geodesic.hpp"
#include "core/exact.hpp"
#include "core/numbers.hpp"
#include "scene/cell_lines.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <numbers>

namespace threewe::scene {
namespace {

constexpr int kBorder = 2;  // cells around the grid that are never known, so that no neighbour needs a check

// Around the target visible cells get their exact distance: there the front is so curved that differences are poor.
constexpr int kExactRadius = 12;  // [cells]
// What is solved is up to 2 % too long, so that a point this much farther than the straight line can't see the
// target.
constexpr double kSurelyDetour = 1.05;

// Cells in the order of their lengths, those within a twentieth of a cell as they came: several times as fast as a
// heap, with an error far below that of the differences (Yatziv, Bartesaghi & Sapiro 2006). A ring of buckets is
// enough, for no cell is pushed further ahead of the one just popped than the exact cells around the target are.
class FrontQueue {
 public:
  struct Entry {
    double length;
    std::uint32_t cell;
  };

  void push(double length, std::uint32_t cell) {
    const auto bucket = std::max(current_, static_cast<std::size_t>(length * kBucketsPerCell));
    ring_[bucket % ring_.size()].push_back({length, cell});
    ++count_;
  }

  bool pop(Entry& entry) {
    if (count_ == 0) return false;
    while (taken_ == ring_[current_ % ring_.size()].size()) {
      ring_[current_ % ring_.size()].clear();
      ++current_;
      taken_ = 0;
    }
    entry = ring_[current_ % ring_.size()][taken_++];
    --count_;
    return true;
  }

 private:
  static constexpr int kBucketsPerCell = 20;
  std::array<std::vector<Entry>, 512> ring_;
  std::size_t current_ = 0;  // bucket, counted from the target
  std::size_t taken_ = 0;    // entries of the current bucket
  std::size_t count_ = 0;    // entries left
  static_assert(2 * kExactRadius * kBucketsPerCell < 512);
};

// What the known cells on one axis say about a length T: its slope along the axis is sqrt(weight) * (T - offset).
struct Difference {
  double weight;
  double offset;
  double nearest;  // the length must not be below that of the cell it comes from
};

Difference difference(const double* length, std::ptrdiff_t step) {
  const std::ptrdiff_t side = length[step] < length[-step] ? step : -step;
  const double near = length[side];
  const double far = length[2 * side];
  if (far <= near && near < kInfinity) return {2.25, (4.0 * near - far) / 3.0, near};
  return {1.0, near, near};
}

}  // namespace

GeodesicField::GeodesicField(const CellSet& passable, Vec2 target, double limit)
    : passable_(&passable),
      target_(target),
      stride_(static_cast<std::uint32_t>(passable.frame.width + 2 * kBorder)),
      length_(std::size_t{stride_} * static_cast<std::size_t>(passable.frame.height + 2 * kBorder), kInfinity) {
  march(cells_around(target), limit / passable.frame.resolution);
}

GeodesicField::GeodesicField(const CellSet& passable, std::span<const std::size_t> targets, double limit)
    : passable_(&passable),
      stride_(static_cast<std::uint32_t>(passable.frame.width + 2 * kBorder)),
      length_(std::size_t{stride_} * static_cast<std::size_t>(passable.frame.height + 2 * kBorder), kInfinity) {
  std::vector<std::uint32_t> known;
  for (const std::size_t target : targets) {
    if (passable.cells[target] == 0) continue;
    known.push_back(index(passable.frame.cell(target)));
    length_[known.back()] = 0.0;
  }
  march(known, limit / passable.frame.resolution);
}

double GeodesicField::length_from(Vec2 point) const {
  const GridFrame& frame = passable_->frame;
  const CellIndex cell = frame.cell(point);
  if (!frame.contains(cell)) return kInfinity;
  if (!target_) return interpolate(point);
  const double straight = distance(point, *target_);
  if (cell == frame.cell(*target_)) return straight;
  const double solved = interpolate(point);
  const bool is_detour = solved < kInfinity && solved > kSurelyDetour * straight + frame.resolution;
  return !is_detour && sees_target(point) ? straight : std::max(straight, solved);
}

std::vector<Vec2> GeodesicField::path_from(Vec2 point) const {
  if (length_from(point) == kInfinity) return {};

  // from cell to cell downhill, then taut
  const GridFrame& frame = passable_->frame;
  std::vector<Vec2> chain = {point};
  for (const CellIndex cell : descend(frame.cell(point))) chain.push_back(frame.center(cell));
  if (target_) chain.push_back(*target_);
  std::vector<Vec2> path = {point};
  for (std::size_t at = 0; at + 1 < chain.size();) {
    // as far along the chain as can be seen: in steps that double, then halve
    std::size_t seen = at + 1;
    std::size_t step = 1;
    for (; seen + step < chain.size() && sees(chain[at], chain[seen + step]); step *= 2) seen += step;
    for (; step > 0; step /= 2) {
      if (seen + step < chain.size() && sees(chain[at], chain[seen + step])) seen += step;
    }
    at = seen;
    path.push_back(chain[at]);
  }
  return path;
}

// Gives the cells that see the target their distance. Where the target lies beside the passable cells, those next to
// it.
std::vector<std::uint32_t> GeodesicField::cells_around(Vec2 target) {
  const GridFrame& frame = passable_->frame;
  const CellIndex middle = frame.cell(target);
  const bool inside = passable_->value_or(middle, 0) != 0;
  const int radius = inside ? kExactRadius : 1;
  std::vector<std::uint32_t> known;
  for (int y = middle.y - radius; y <= middle.y + radius; ++y) {
    for (int x = middle.x - radius; x <= middle.x + radius; ++x) {
      if (!passable_->value_or({x, y}, 0) || (inside && !sees_target(frame.center({x, y})))) continue;
      length_[index({x, y})] = distance(frame.center({x, y}), target) / frame.resolution;
      known.push_back(index({x, y}));
    }
  }
  return known;
}

// Cells become known in the order of their lengths, as in Dijkstra's algorithm; each one solves for its neighbours
// anew.
void GeodesicField::march(const std::vector<std::uint32_t>& known, double limit) {
  std::vector<double> tentative(length_.size(), -kInfinity);  // nothing is below it: not passable, or known already
  const GridFrame& frame = passable_->frame;
  for (int y = 0; y < frame.height; ++y) {
    for (int x = 0; x < frame.width; ++x) {
      if ((*passable_)[{x, y}]) tentative[index({x, y})] = kInfinity;
    }
  }
  FrontQueue front;
  for (const std::uint32_t cell : known) {
    tentative[cell] = length_[cell];
    front.push(length_[cell], cell);
  }

  FrontQueue::Entry entry{};
  while (front.pop(entry) && entry.length <= limit) {
    const auto [length, cell] = entry;
    if (length != tentative[cell]) continue;  // it was known by a shorter way
    length_[cell] = length;
    tentative[cell] = -kInfinity;
    for (const std::uint32_t next : {cell - stride_, cell - 1, cell + 1, cell + stride_}) {
      if (tentative[next] < 0.0 || length_[next] < kInfinity) continue;
      const double better = solve(next);
      if (better >= tentative[next]) continue;
      tentative[next] = better;
      front.push(better, next);
    }
  }
}

// The length at which a front of unit speed arrives: |gradient| = 1, from the known neighbours.
double GeodesicField::solve(std::uint32_t cell) const {
  const Difference x = difference(&length_[cell], 1);
  const Difference y = difference(&length_[cell], static_cast<std::ptrdiff_t>(stride_));
  if (x.nearest < kInfinity && y.nearest < kInfinity) {
    const double weight = x.weight + y.weight;
    const double apart = x.offset - y.offset;
    const double discriminant = weight - x.weight * y.weight * apart * apart;
    if (discriminant >= 0.0) {
      const double length = (x.weight * x.offset + y.weight * y.offset + exact::sqrt(discriminant)) / weight;
      if (length >= std::max(x.nearest, y.nearest)) return length;
    }
  }
  return std::min(x.offset + 1.0 / exact::sqrt(x.weight), y.offset + 1.0 / exact::sqrt(y.weight));
}

// Bilinear between the four cells around a point; beside obstacles, by way of the best cell nearby.
double GeodesicField::interpolate(Vec2 point) const {
  const GridFrame& frame = passable_->frame;
  const CellIndex cell = frame.cell(point);
  const Vec2 offset = (1.0 / frame.resolution) * (point - frame.center(cell));
  const CellIndex low{cell.x - (offset.x < 0.0 ? 1 : 0), cell.y - (offset.y < 0.0 ? 1 : 0)};
  const Vec2 t{offset.x < 0.0 ? offset.x + 1.0 : offset.x, offset.y < 0.0 ? offset.y + 1.0 : offset.y};
  const double* l = &length_[index(low)];
  const std::array<double, 4> corners = {l[0], l[1], l[stride_], l[stride_ + 1]};
  if (*std::ranges::max_element(corners) < kInfinity) {
    const double below = corners[0] + t.x * (corners[1] - corners[0]);
    const double above = corners[2] + t.x * (corners[3] - corners[2]);
    return frame.resolution * (below + t.y * (above - below));
  }

  double shortest = kInfinity;
  for (int y = cell.y - 1; y <= cell.y + 1; ++y) {
    for (int x = cell.x - 1; x <= cell.x + 1; ++x) {
      const double there = frame.resolution * length_[index({x, y})];
      shortest = std::min(shortest, there + distance(point, frame.center({x, y})));
    }
  }
  return shortest;
}

bool GeodesicField::sees_target(Vec2 point) const { return sees(point, *target_); }

bool GeodesicField::sees(Vec2 a, Vec2 b) const {
  return walk_line(passable_->frame, a, b, [&](CellIndex c) { return passable_->value_or(c, 0) != 0; });
}

// The cells of a way downhill, from one beside or at `cell` to where no neighbour is lower. Between two cells that
// touch at a corner both others must be known, so that the straight line is clear.
std::vector<CellIndex> GeodesicField::descend(CellIndex cell) const {
  std::vector<CellIndex> way;
  const auto length = [&](int x, int y) { return length_[index({x, y})]; };
  while (true) {
    CellIndex lowest = cell;
    double steepest = 0.0;
    const double here = length(cell.x, cell.y);
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const bool diagonal = dx != 0 && dy != 0;
        const double there = length(cell.x + dx, cell.y + dy);
        if (there >= here) continue;
        if (here == kInfinity) {  // beside the set: whichever is best
          if (lowest == cell || there < length(lowest.x, lowest.y)) lowest = {cell.x + dx, cell.y + dy};
          continue;
        }
        if (diagonal && std::max(length(cell.x + dx, cell.y), length(cell.x, cell.y + dy)) == kInfinity) continue;
        const double slope = (here - there) * (diagonal ? 0.5 * std::numbers::sqrt2 : 1.0);
        if (slope > steepest) {
          steepest = slope;
          lowest = {cell.x + dx, cell.y + dy};
        }
      }
    }
    if (lowest == cell) return way;
    cell = lowest;
    way.push_back(cell);
  }
}

std::uint32_t GeodesicField::index(CellIndex c) const {
  return static_cast<std::uint32_t>(c.y + kBorder) * stride_ + static_cast<std::uint32_t>(c.x + kBorder);
}

}  // namespace threewe::scene
