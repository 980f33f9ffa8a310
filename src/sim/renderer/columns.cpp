#include "sim/renderer/columns.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace threewe::sim::view {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

class Search {
 public:
  Search(const Place& place, const View& view, const Rows& rows, const Candidates& candidates, Columns& out)
      : place_(place), view_(view), rows_(rows), candidates_(candidates), out_(out) {
    const auto count = static_cast<std::size_t>(rows.count);
    out_.inverse.resize(count);
    out_.owner.resize(count);
    out_.changed.resize(count);
  }

  void run(int first, int count) {
    out_.spans.clear();
    for (int block = 0; block < count; block += kBlock) {
      find_hits(first + block);
      for (int i = 0; i < std::min(kBlock, count - block); ++i) {
        find_column(first + block + i, block + i, out_.hits[static_cast<std::size_t>(i)]);
      }
    }
  }

 private:
  // What stands before the walls in a block of columns.
  void find_hits(int first) {
    for (auto& hits : out_.hits) hits.clear();
    const auto at = static_cast<std::size_t>(first);
    Meeting meeting;
    for (const Candidates::Entry& entry : candidates_.blocks[at / kBlock]) {
      const Candidate& c = candidates_.others[static_cast<std::size_t>(entry.candidate)];
      unsigned met = meet(c.outline, candidates_.slopes.data() + at, candidates_.wall_inverse.data() + at, meeting);
      for (std::size_t i = 0; met != 0; ++i, met >>= 1U) {
        const int face = c.outline.is_disc ? kRoundFace : static_cast<int>(meeting.face[i]);
        if (met & 1U) out_.hits[i].push_back({&c, face, meeting.near[i], meeting.far[i]});
      }
    }
  }

  // Finds what a column shows; `place` is its number in the strip.
  void find_column(int column, int place, const std::vector<ColumnHit>& hits) {
    const double s = view_.slope_of(column);
    find_base(column, s);
    if (hits.empty()) {
      for (std::size_t i = 0; i < out_.base.size(); ++i) {
        add_span(place, s, out_.base[i], out_.runs[i]);
      }
      return;
    }
    lay_base();
    for (const ColumnHit& hit : hits) put_faces(hit, s);
    add_spans(place, s);
  }

  // Ceiling or sky, the wall, the floor: from top to bottom without a gap.
  void find_base(int column, double s) {
    out_.runs.clear();
    out_.base.clear();
    const auto at = static_cast<std::size_t>(column);
    const std::int32_t wall = candidates_.wall[at];
    if (wall < 0) return find_open_base(s);

    const ColumnHit hit{&candidates_.walls[static_cast<std::size_t>(wall)], candidates_.wall_face[at],
                        candidates_.wall_inverse[at], 0.0};
    const int top = view_.row_at(place_.ceiling - view_.height, hit.near);
    const int bottom = std::max(top, view_.row_at(-view_.height, hit.near));
    add_base(ceiling(), 0, top);
    for_each_part(hit, s, top, bottom, [&](const Run& run, int begin, int end) { add_base(run, begin, end); });
    add_floors(s, hit.near, bottom);
  }

  Run ceiling() const {
    Run run{Run::Kind::ceiling};
    run.inverse = inverse_of_level(place_.ceiling - view_.height);
    return run;
  }

  void find_open_base(double s) {
    const int horizon = view_.row_at(0.0, 0.0);
    if (view_.is_roofed) {
      add_base(ceiling(), 0, horizon);
    } else {
      const bool has_hills = place_.is_open;
      const int hills = has_hills ? std::min(horizon, view_.row_at(hill_slope(view_.direction(s)), 1.0)) : horizon;
      add_base({Run::Kind::sky}, 0, hills);
      add_base({Run::Kind::hills}, hills, horizon);
    }
    // a row may look exactly along the horizon
    const bool on_row = view_.camera.cy - 0.5 == horizon && horizon < rows_.count;
    if (on_row) add_base({Run::Kind::nothing}, horizon, horizon + 1);
    add_floors(s, 0.0, on_row ? horizon + 1 : horizon);
  }

  void add_base(const Run& run, int begin, int end) {
    out_.runs.push_back(run);
    out_.base.push_back({begin, end});
  }

  // The floors along the ray, from the wall to the eye: rows from `top` down.
  void add_floors(double s, double inverse, int top) {
    constexpr int kMostFloors = 32;
    constexpr double kStep = 1e-7;  // [m] into the next room
    const Vec2 direction = view_.direction(s);
    const double reach = inverse > 0.0 ? 1.0 / inverse : kInfinity;
    const std::size_t first = out_.runs.size();
    int end = rows_.count;
    double x = 0.0;
    for (int i = 0; i < kMostFloors && end > top; ++i) {
      const FloorRegion* floor = place_.floor_at(view_.eye + (x + kStep) * direction);
      x = i + 1 < kMostFloors ? std::max(x, next_floor(floor, direction, x + kStep)) : kInfinity;
      const int begin = x >= reach || x == kInfinity ? top : std::clamp(view_.row_at(-view_.height, 1.0 / x), top, end);
      Run run{Run::Kind::floor};
      run.inverse = inverse_of_level(-view_.height);
      run.floor = floor;
      add_base(run, begin, end);
      end = begin;
    }
    std::reverse(out_.runs.begin() + static_cast<std::ptrdiff_t>(first), out_.runs.end());
    std::reverse(out_.base.begin() + static_cast<std::ptrdiff_t>(first), out_.base.end());
  }

  // How far along the ray a floor ends: where it does, or another begins that lies on it.
  double next_floor(const FloorRegion* floor, Vec2 direction, double x) const {
    double nearest = floor ? crossing(*floor, direction).second : kInfinity;
    const auto meet = [&](const FloorRegion& other) {
      const auto [enter, leave] = crossing(other, direction);
      if (enter < leave && enter > x) nearest = std::min(nearest, enter);
    };
    if (!floor) std::ranges::for_each(place_.floors, meet);
    if (floor) std::ranges::for_each(floor->above, [&](std::size_t i) { meet(place_.floors[i]); });
    return nearest;
  }

  std::pair<double, double> crossing(const FloorRegion& floor, Vec2 direction) const {
    double enter = -kInfinity;
    double leave = kInfinity;
    const auto clip = [&](double low, double high, double step) {
      if (step == 0.0) {
        if (low > 0.0 || high <= 0.0) leave = -kInfinity;
        return;
      }
      const double a = low / step;
      const double b = high / step;
      enter = std::max(enter, std::min(a, b));
      leave = std::min(leave, std::max(a, b));
    };
    clip(floor.min.x - view_.eye.x, floor.max.x - view_.eye.x, direction.x);
    clip(floor.min.y - view_.eye.y, floor.max.y - view_.eye.y, direction.y);
    return {enter, leave};
  }

  // Lays the base out by rows, for other things to be compared with.
  void lay_base() {
    for (std::size_t i = 0; i < out_.base.size(); ++i) {
      const auto [inverse, rise] = out_.runs[i].inverse;
      lay(layers(), out_.base[i].begin, out_.base[i].end, inverse, rise, static_cast<std::int32_t>(i));
    }
  }

  Layers layers() { return {rows_.slopes.data(), out_.inverse.data(), out_.owner.data()}; }

  void put_faces(const ColumnHit& hit, double s) {
    const Candidate& c = *hit.candidate;
    const int top = view_.row_at(c.high, hit.near);
    const int bottom = view_.row_at(c.low, hit.near);
    if (hit.near < kInfinity) {  // not from above or below
      for_each_part(hit, s, top, bottom, [&](const Run& run, int begin, int end) { put(run, begin, end); });
    }
    if (c.high < 0.0) {
      put({Run::Kind::top, kTopFace, &c, inverse_of_level(c.high)}, view_.row_at(c.high, hit.far), top);
    }
    if (c.low > 0.0) {
      put({Run::Kind::bottom, kBottomFace, &c, inverse_of_level(c.low)}, bottom, view_.row_at(c.low, hit.far));
    }
  }

  // The parts of a side between two rows, from top to bottom: what hangs on it, its skirting, and the rest.
  template <class Add>
  void for_each_part(const ColumnHit& hit, double s, int top, int bottom, Add add) const {
    Run part{Run::Kind::side, hit.face, hit.candidate, {static_cast<float>(hit.near), 0.0F}, hit.near};
    if (hit.candidate->visible->id != kWallId) return add(part, top, bottom);

    const auto row_of = [&](double z) { return std::clamp(view_.row_at(z - view_.height, hit.near), top, bottom); };
    const int foot = place_.has_skirting(*hit.candidate->visible) ? row_of(kSkirting) : bottom;
    if (const Decor* decor = find_decor(hit, s)) {
      const int high = row_of(decor->high);
      const int low = row_of(decor->low);
      add(part, top, high);
      add(Run{Run::Kind::decor, hit.face, hit.candidate, part.inverse, hit.near, nullptr, decor}, high, low);
      top = low;
    }
    add(part, top, foot);
    part.kind = Run::Kind::skirting;
    add(part, foot, bottom);
  }

  // What hangs on a wall where a ray meets it.
  const Decor* find_decor(const ColumnHit& hit, double s) const {
    const auto all = place_.decor_of(hit.candidate->solid);
    if (all.empty()) return nullptr;
    const Side& side = hit.candidate->sides->at(static_cast<std::size_t>(hit.face));
    const double along = dot(view_.eye + (1.0 / hit.near) * view_.direction(s) - side.corner, side.axis);
    const auto found = std::ranges::find_if(
        all, [&](const Decor& d) { return d.face == hit.face && d.begin <= along && along < d.end; });
    return found == all.end() ? nullptr : &*found;
  }

  // Gives a run the rows in which it is nearest so far.
  void put(const Run& run, int begin, int end) {
    if (begin >= end) return;
    const auto [inverse, rise] = run.inverse;
    const auto owner = static_cast<std::int32_t>(out_.runs.size());
    out_.runs.push_back(run);
    view::put(layers(), begin, end, inverse, rise, owner);
  }

  // One span for each stretch of rows with one owner.
  void add_spans(int column, double s) {
    int begin = 0;
    const auto add_until = [&](int end) {
      const auto owner = static_cast<std::size_t>(out_.owner[static_cast<std::size_t>(begin)]);
      add_span(column, s, {begin, end}, out_.runs[owner]);
      begin = end;
    };
    const int count = find_changes(out_.owner.data(), rows_.count, out_.changed.data());
    std::for_each_n(out_.changed.begin(), count, add_until);
    add_until(rows_.count);
  }

  void add_span(int column, double s, RowRange rows, const Run& run) {
    if (rows.begin >= rows.end) return;
    Span& span = out_.spans.emplace_back();
    span.column = column;
    span.begin = rows.begin;
    span.end = rows.end;
    fill(run, place_, view_, s, span);
  }

  const Place& place_;
  const View& view_;
  const Rows& rows_;
  const Candidates& candidates_;
  Columns& out_;
};

}  // namespace

void find_spans(const Place& place, const View& view, const Rows& rows, const Candidates& candidates, int first,
                int count, Columns& columns) {
  Search(place, view, rows, candidates, columns).run(first, count);
}

}  // namespace threewe::sim::view
