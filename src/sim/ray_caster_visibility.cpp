// A convex solid hides one convex set from another exactly if it cuts every line between their corners: seen from one
// point, its shadow is convex, so a shape is in it when its corners are; and likewise the other way round.
// The plane is halved until a cell is left, and what is hidden from the whole is never looked at again in its parts.
#include "sim/ray_caster_visibility.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <span>

#include "core/numbers.hpp"

namespace threewe::sim {
namespace {

using scene::Segment;
using scene::Slice;

// How far [m] an occluder must stand in front: the nearest of two coinciding surfaces must never be left out, nor each
// for the sake of the other.
constexpr double kMargin = 1e-6;
constexpr std::size_t kMaxPolygonCorners = 8;

// The points p with normal . p > offset are outside.
struct Line {
  Vec2 normal;
  double offset = 0.0;
  double height(Vec2 point) const { return dot(normal, point) - offset; }
};

// A convex solid, or the one face of a shape that is none, a little smaller than it is.
struct Occluder {
  std::array<Vec2, kMaxPolygonCorners> corners;
  std::array<Line, kMaxPolygonCorners> lines;
  std::size_t corner_count = 0;
  std::size_t line_count = 0;
  std::size_t first_segment = 0;  // of those in the slice that go round it
  std::size_t segment_count = 1;
};

using Square = std::array<Vec2, 4>;

// Whether the line from p to q cuts the occluder: no line separates them.
bool cuts(const Occluder& occluder, Vec2 p, Vec2 q) {
  for (std::size_t i = 0; i < occluder.line_count; ++i) {
    if (occluder.lines[i].height(p) > 0.0 && occluder.lines[i].height(q) > 0.0) return false;
  }
  bool left = false;
  bool right = false;
  for (std::size_t i = 0; i < occluder.corner_count; ++i) {
    const double side = cross(q - p, occluder.corners[i] - p);
    left = left || side > 0.0;
    right = right || side < 0.0;
  }
  return left && right;
}

bool hides(const Occluder& occluder, const Square& square, std::span<const Vec2> points) {
  return std::ranges::all_of(
      points, [&](Vec2 q) { return std::ranges::all_of(square, [&](Vec2 p) { return cuts(occluder, p, q); }); });
}

// Whether all of the square stands in front of one of its faces.
bool faces(const Occluder& occluder, const Square& square) {
  for (std::size_t i = 0; i < occluder.line_count; ++i) {
    if (std::ranges::all_of(square, [&](Vec2 p) { return occluder.lines[i].height(p) > kMargin; })) return true;
  }
  return false;
}

Line line_of(const Segment& segment) {
  const Vec2 along = segment.b - segment.a;
  const Vec2 normal = (1.0 / norm(along)) * Vec2{along.y, -along.x};
  return {normal, dot(normal, segment.a) - kMargin};
}

// The number of segments from `first` on that go once round a convex solid; 0 if they do not.
std::size_t convex_loop(std::span<const Segment> segments, std::size_t first) {
  const std::size_t most = std::min(segments.size() - first, kMaxPolygonCorners);
  std::size_t n = 1;
  while (n < most && segments[first + n - 1].b == segments[first + n].a &&
         segments[first + n - 1].b != segments[first].a)
    ++n;
  if (n < 3 || segments[first + n - 1].b != segments[first].a) return 0;
  const auto loop = segments.subspan(first, n);
  for (const Segment& side : loop) {
    for (const Segment& other : loop) {
      if (other.a != side.a && other.a != side.b && cross(side.b - side.a, other.a - side.a) <= 0.0) return 0;
    }
  }
  return n;
}

// The corner where two neighbouring lines meet.
Vec2 intersection(const Line& a, const Line& b) {
  const double det = cross(a.normal, b.normal);
  return (1.0 / det) *
         Vec2{a.offset * b.normal.y - b.offset * a.normal.y, b.offset * a.normal.x - a.offset * b.normal.x};
}

Occluder solid(std::span<const Segment> loop) {
  Occluder occluder;
  for (const Segment& side : loop) occluder.lines[occluder.line_count++] = line_of(side);
  for (std::size_t i = 0; i < loop.size(); ++i) {
    occluder.corners[occluder.corner_count++] = intersection(occluder.lines[i], occluder.lines[(i + 1) % loop.size()]);
  }
  return occluder;
}

Occluder face(const Segment& segment) {
  const Vec2 inset = (kMargin / norm(segment.b - segment.a)) * (segment.b - segment.a);
  Occluder occluder;
  occluder.lines[0] = line_of(segment);
  occluder.corners[0] = segment.a + inset;
  occluder.corners[1] = segment.b - inset;
  occluder.line_count = 1;
  occluder.corner_count = 2;
  return occluder;
}

// Wide enough to be one after all margins.
bool is_thick(const Occluder& occluder) {
  double depth = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < occluder.line_count; ++i) {
    double deepest = 0.0;
    for (std::size_t k = 0; k < occluder.corner_count; ++k) {
      deepest = std::max(deepest, -occluder.lines[i].height(occluder.corners[k]));
    }
    depth = std::min(depth, deepest);
  }
  return depth > 1e-3;
}

std::vector<Occluder> occluders_of(const Slice& slice) {
  std::vector<Occluder> occluders;
  const std::span<const Segment> segments(slice.segments);
  for (std::size_t i = 0; i < segments.size();) {
    const std::size_t n = convex_loop(segments, i);
    const Occluder whole = n > 0 ? solid(segments.subspan(i, n)) : Occluder{};
    if (n > 0 && is_thick(whole)) {
      occluders.push_back(whole);
      occluders.back().first_segment = i;
      occluders.back().segment_count = n;
      i += n;
      continue;
    }
    if (distance(segments[i].a, segments[i].b) > 1e-3) {
      occluders.push_back(face(segments[i]));
      occluders.back().first_segment = i;
    }
    ++i;
  }
  return occluders;
}

// An occluder as seen from the middle of a square: between two directions, less than half a turn apart.
struct View {
  const Occluder* occluder;
  Vec2 left;
  Vec2 right;
  double narrowness;
};

// Which of the sectors around a point a direction points into, counter-clockwise. They are equally long on a diamond.
constexpr int kSectors = 32;
std::size_t sector(Vec2 direction) {
  const double size = std::fabs(direction.x) + std::fabs(direction.y);
  const double slope = size > 0.0 ? direction.y / size : 0.0;
  const double turn = direction.x < 0.0 ? 3.0 - slope : 1.0 + slope;
  return static_cast<std::size_t>(std::min(static_cast<int>(kSectors / 4.0 * turn), kSectors - 1));
}

struct CellRange {
  int x0, y0, x1, y1;
};

class Search {
 public:
  Search(const Slice& slice, const CellGrid& grid, double range_max)
      : slice_(slice),
        grid_(grid),
        range_max_(range_max),
        all_occluders_(occluders_of(slice)),
        is_listed_(slice.segments.size()),
        sets_(static_cast<std::size_t>(grid.count())) {}

  std::vector<VisibleSet> run() {
    VisibleSet all;
    for (std::size_t i = 0; i < slice_.segments.size(); ++i) all.segments.push_back(static_cast<int>(i));
    for (std::size_t i = 0; i < slice_.circles.size(); ++i) all.circles.push_back(static_cast<int>(i));
    std::vector<const Occluder*> occluders;
    for (const Occluder& occluder : all_occluders_) occluders.push_back(&occluder);
    refine({0, 0, grid_.width, grid_.height}, all, occluders);
    return std::move(sets_);
  }

 private:
  void refine(const CellRange& range, const VisibleSet& parent, const std::vector<const Occluder*>& parents) {
    const VisibleSet visible = seen_from(range, parent, parents);
    const int width = range.x1 - range.x0;
    const int height = range.y1 - range.y0;
    if (width == 1 && height == 1) {
      const int cell = range.y0 * grid_.width + range.x0;
      sets_[static_cast<std::size_t>(cell)] = visible;
      return;
    }
    CellRange low = range;
    CellRange high = range;
    if (width >= height) {
      low.x1 = high.x0 = range.x0 + width / 2;
    } else {
      low.y1 = high.y0 = range.y0 + height / 2;
    }
    const std::vector<const Occluder*> occluders = those_seen(visible, parents);
    refine(low, visible, occluders);
    refine(high, visible, occluders);
  }

  // Occluders that can be seen themselves. What stands behind another hides nothing that is not hidden already.
  std::vector<const Occluder*> those_seen(const VisibleSet& visible, const std::vector<const Occluder*>& occluders) {
    for (const int i : visible.segments) is_listed_[static_cast<std::size_t>(i)] = 1;
    std::vector<const Occluder*> seen;
    for (const Occluder* occluder : occluders) {
      const auto segments = std::span(is_listed_).subspan(occluder->first_segment, occluder->segment_count);
      if (std::ranges::any_of(segments, [](char listed) { return listed != 0; })) seen.push_back(occluder);
    }
    std::ranges::fill(is_listed_, char{0});
    return seen;
  }

  VisibleSet seen_from(const CellRange& range, const VisibleSet& candidates,
                       const std::vector<const Occluder*>& occluders) {
    // a hair larger than its cells, so that rounding at their edges does no harm
    const double x0 = grid_.origin.x + CellGrid::kSize * range.x0 - kMargin;
    const double y0 = grid_.origin.y + CellGrid::kSize * range.y0 - kMargin;
    const double x1 = grid_.origin.x + CellGrid::kSize * range.x1 + kMargin;
    const double y1 = grid_.origin.y + CellGrid::kSize * range.y1 + kMargin;
    const Square square{Vec2{x0, y0}, Vec2{x1, y0}, Vec2{x1, y1}, Vec2{x0, y1}};
    const Vec2 middle{0.5 * (x0 + x1), 0.5 * (y0 + y1)};
    const double reach = range_max_ + distance(middle, square[0]) + kMargin;

    order_occluders(square, middle, occluders);
    VisibleSet visible;
    for (const int i : candidates.segments) {
      const Segment& segment = slice_.segments[static_cast<std::size_t>(i)];
      const std::array<Vec2, 2> ends{segment.a, segment.b};
      const Vec2 along = segment.b - segment.a;
      if (std::ranges::all_of(square, [&](Vec2 p) { return cross(along, segment.a - p) <= 0.0; })) continue;
      if (distance_to(segment, middle) > reach || is_hidden(square, middle, ends)) continue;
      visible.segments.push_back(i);
    }
    for (const int i : candidates.circles) {
      const auto& [center, r, object] = slice_.circles[static_cast<std::size_t>(i)];
      const std::array<Vec2, 4> corners{center + Vec2{-r, -r}, center + Vec2{r, -r}, center + Vec2{r, r},
                                        center + Vec2{-r, r}};
      if (distance(center, middle) - r > reach || is_hidden(square, middle, corners)) continue;
      visible.circles.push_back(i);
    }
    return visible;
  }

  static double distance_to(const Segment& segment, Vec2 point) {
    const Vec2 along = segment.b - segment.a;
    const double t = std::clamp(dot(point - segment.a, along) / dot(along, along), 0.0, 1.0);
    return distance(point, segment.a + t * along);
  }

  // Those that can hide anything from the square, by where they are seen, the widest first: most of what is hidden is
  // hidden by them.
  void order_occluders(const Square& square, Vec2 middle, const std::vector<const Occluder*>& occluders) {
    occluders_.clear();
    for (const Occluder* occluder : occluders) {
      if (!faces(*occluder, square)) continue;
      View view{occluder, occluder->corners[0] - middle, occluder->corners[0] - middle, 0.0};
      for (std::size_t i = 1; i < occluder->corner_count; ++i) {
        const Vec2 corner = occluder->corners[i] - middle;
        if (cross(view.left, corner) > 0.0) view.left = corner;
        if (cross(view.right, corner) < 0.0) view.right = corner;
      }
      view.narrowness = -cross(view.right, view.left) / (dot(view.left, view.left) + dot(view.right, view.right));
      occluders_.push_back(view);
    }
    std::ranges::stable_sort(occluders_, {}, &View::narrowness);
    for (auto& views : sectors_) views.clear();
    for (const View& view : occluders_) {
      const std::size_t last = sector(view.left);
      for (std::size_t i = sector(view.right); i != last; i = (i + 1) % kSectors) sectors_[i].push_back(&view);
      sectors_[last].push_back(&view);
    }
  }

  bool is_hidden(const Square& square, Vec2 middle, std::span<const Vec2> points) const {
    return std::ranges::any_of(sectors_[sector(points[0] - middle)], [&](const View* view) {
      const bool covered = std::ranges::all_of(points, [&](Vec2 point) {
        return cross(view->right, point - middle) >= 0.0 && cross(point - middle, view->left) >= 0.0;
      });
      return covered && hides(*view->occluder, square, points);
    });
  }

  const Slice& slice_;
  const CellGrid& grid_;
  double range_max_;
  std::vector<Occluder> all_occluders_;
  std::vector<char> is_listed_;  // each segment, while occluders are sifted
  std::vector<View> occluders_;
  std::array<std::vector<const View*>, kSectors> sectors_;  // those of `occluders_` that reach into each
  std::vector<VisibleSet> sets_;
};

}  // namespace

CellGrid covering_grid(const Slice& slice) {
  if (slice.segments.empty() && slice.circles.empty()) return {};
  Vec2 low{kInfinity, kInfinity};
  Vec2 high{-kInfinity, -kInfinity};
  const auto cover = [&](Vec2 p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y)};
  };
  for (const Segment& segment : slice.segments) cover(segment.a), cover(segment.b);
  for (const auto& [center, r, object] : slice.circles) cover(center - Vec2{r, r}), cover(center + Vec2{r, r});
  const auto cells = [](double length) { return static_cast<int>(length / CellGrid::kSize) + 1; };
  return {low, cells(high.x - low.x), cells(high.y - low.y)};
}

std::vector<VisibleSet> potentially_visible_sets(const Slice& slice, const CellGrid& grid, double range_max) {
  if (grid.count() == 0) return {};
  return Search(slice, grid, range_max).run();
}

}  // namespace threewe::sim
