#include "sim/renderer_columns.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "sim/renderer_textures.hpp"

namespace threewe::sim::view {
namespace {

using scene::Solid;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kBlock = 8;  // columns

class Search {
 public:
  Search(const Place& place, const CameraIntrinsics& camera, const CameraPose& view, Columns& out)
      : place_(place), camera_(camera), eye_(view.pose.position()), height_(view.height), out_(out) {
    const auto [s, c] = exact::sincos(view.pose.theta);
    forward_ = {c, s};
    left_ = {-s, c};
    roofed_ = place.ceiling < kInfinity && height_ < place.ceiling;
  }

  void run(const Paint& paint, std::span<const VisibleSolid> moving, const std::function<void(int, int)>& draw) {
    begin();
    for (const Group& group : place_.groups) {
      if (group.is_full && roofed_) add_wall(group.first, paint.colours[group.first]);
    }
    find_nearest_walls();
    for (const Group& group : place_.groups) {
      if ((group.is_full && roofed_) || is_hidden(group)) continue;
      for (std::size_t i = group.first; i < group.last; ++i)
        add_other(place_.solids[i], static_cast<int>(i), paint.colours[i]);
    }
    for (const VisibleSolid& visible : moving) add_other(visible, -1, visible.colour);

    for (int first = 0; first < camera_.width; first += kStripWidth) {
      const int count = std::min(kStripWidth, camera_.width - first);
      out_.spans.clear();
      std::ranges::fill(out_.first_span, -1);
      for (int column = 0; column < count; ++column) draw_column(first + column, column);
      draw(first, count);
    }
  }

 private:
  void begin() {
    out_.walls.clear();
    out_.others.clear();
    const auto rows = static_cast<std::size_t>(camera_.height);
    const auto columns = static_cast<std::size_t>(camera_.width);
    const std::size_t blocks = (columns + kBlock - 1) / kBlock;
    out_.blocks.resize(blocks);
    for (auto& block : out_.blocks) block.clear();
    out_.block_inverses.assign(blocks, 0.0);
    out_.wall_hits.assign(columns, {});
    out_.first_span.resize(rows);
    out_.slopes.resize(rows);
    out_.inverse.resize(rows);
    out_.owner.resize(rows);
    for (int row = 0; row < camera_.height; ++row) {
      out_.slopes[static_cast<std::size_t>(row)] = static_cast<float>((camera_.cy - (row + 0.5)) / camera_.fy);
    }
  }

  double slope_of(int column) const { return (camera_.cx - (column + 0.5)) / camera_.fx; }

  Vec2 to_camera(Vec2 point) const {
    const Vec2 d = point - eye_;
    return {dot(d, forward_), dot(d, left_)};
  }

  // Whether all of a group is beside or behind the picture, or behind walls.
  bool is_hidden(const Group& group) const {
    constexpr double kNear = 1e-6;
    const Vec2 center = to_camera(group.center);
    const double r = group.radius;
    if (center.x + r <= 0.0) return true;
    Reach reach;
    if (center.x - r > kNear) {
      const double left = center.y + r;
      const double right = center.y - r;
      const double s_max = left / (left > 0.0 ? center.x - r : center.x + r);
      const double s_min = right / (right < 0.0 ? center.x - r : center.x + r);
      if (!find_reach(s_min, s_max, center.x - r, reach)) return true;
    } else {
      reach = {0, camera_.width - 1, kInfinity};
    }
    return is_behind_walls(reach);
  }

  struct Reach {
    int first = 0;  // columns
    int last = 0;
    double nearest = 0.0;  // inverse depth
  };

  bool is_behind_walls(const Reach& reach) const {
    for (int block = reach.first / kBlock; block <= reach.last / kBlock; ++block) {
      if (reach.nearest > out_.block_inverses[static_cast<std::size_t>(block)]) return false;
    }
    return true;
  }

  // The columns between two slopes, widened by rounding; false when there are none.
  bool find_reach(double s_min, double s_max, double x_min, Reach& reach) const {
    const double first = camera_.cx - camera_.fx * s_max - 1.0;
    const double last = camera_.cx - camera_.fx * s_min + 1.0;
    if (first > camera_.width || last < 0.0) return false;
    reach.first = std::min(static_cast<int>(std::max(first, 0.0)), camera_.width - 1);
    reach.last = static_cast<int>(std::min(last, camera_.width - 1.0));
    reach.nearest = 1.0 / x_min * (1.0 + 1e-9);
    return true;
  }

  void add_wall(std::size_t solid, Colour colour) {
    Candidate& c = out_.walls.emplace_back();
    c.solid = static_cast<int>(solid);
    if (!see(place_.solids[solid], colour, c)) out_.walls.pop_back();
  }

  void add_other(const VisibleSolid& visible, int solid, Colour colour) {
    Candidate& c = out_.others.emplace_back();
    c.solid = solid;
    if (!see(visible, colour, c) || is_behind_walls({c.first_column, c.last_column, c.nearest})) {
      out_.others.pop_back();
      return;
    }
    const auto index = static_cast<std::int32_t>(out_.others.size()) - 1;
    for (int block = c.first_column / kBlock; block <= c.last_column / kBlock; ++block) {
      const auto b = static_cast<std::size_t>(block);
      if (c.nearest <= out_.block_inverses[b]) continue;
      out_.blocks[b].push_back({c.nearest, c.first_column, c.last_column, index});
    }
  }

  void find_nearest_walls() {
    // those that come nearest first: most others are then hidden without being met
    std::ranges::stable_sort(out_.walls, std::ranges::greater{}, &Candidate::nearest);
    for (std::size_t k = 0; k < out_.walls.size(); ++k) {
      const Candidate& c = out_.walls[k];
      for (int column = c.first_column; column <= c.last_column; ++column) {
        auto& hit = out_.wall_hits[static_cast<std::size_t>(column)];
        if (c.nearest <= hit.inverse) continue;
        const Interval interval = meet(c, slope_of(column), hit.inverse);
        if (interval.empty() || interval.near <= hit.inverse) continue;
        hit = {interval.near, static_cast<std::int32_t>(k), interval.face};
      }
    }
    for (std::size_t block = 0; block < out_.blocks.size(); ++block) {
      double farthest = kInfinity;
      const std::size_t end = std::min((block + 1) * kBlock, out_.wall_hits.size());
      for (std::size_t i = block * kBlock; i < end; ++i) farthest = std::min(farthest, out_.wall_hits[i].inverse);
      out_.block_inverses[block] = farthest;
    }
  }

  // Describes a solid as the camera sees it; false when nothing of it can be in the picture.
  bool see(const VisibleSolid& visible, Colour colour, Candidate& c) const {
    const Solid& solid = visible.solid;
    const Vec2 center = to_camera(solid.center);
    if (center.x + solid.radius <= 0.0) return false;

    c.visible = &visible;
    c.colour = colour;
    c.is_disc = solid.shape == Solid::Shape::disc;
    c.low = solid.z_min - height_;
    c.high = solid.z_max - height_;
    Vec2 corners[4];
    for (int i = 0; i < 4; ++i) {
      const double r = solid.radius;
      const Vec2 around[4] = {{-r, -r}, {r, -r}, {r, r}, {-r, r}};
      corners[i] = c.is_disc ? center + around[i] : to_camera(solid.corners[static_cast<std::size_t>(i)]);
    }
    if (!find_columns(corners, c)) return false;

    if (c.is_disc) {
      c.center = center;
      c.beyond = dot(center, center) - solid.radius * solid.radius;
    } else {
      add_lines(corners, c);
    }
    const bool within_height = c.low <= 0.0 && c.high > 0.0;
    const bool inside = within_height && (c.is_disc ? c.beyond <= 0.0 : c.near_count == 0);
    return !inside;  // nothing is seen from inside
  }

  // The columns between the corners' outermost ones, and how near they come.
  bool find_columns(const Vec2 (&corners)[4], Candidate& c) const {
    constexpr double kNear = 1e-6;
    double x_min = kInfinity;
    for (const Vec2 corner : corners) x_min = std::min(x_min, corner.x);
    Reach reach{0, camera_.width - 1, kInfinity};  // beside the camera: no bound
    if (x_min > kNear) {
      double s_min = kInfinity;
      double s_max = -kInfinity;
      for (const Vec2 corner : corners) {
        s_min = std::min(s_min, corner.y / corner.x);
        s_max = std::max(s_max, corner.y / corner.x);
      }
      if (!find_reach(s_min, s_max, x_min, reach)) return false;
    }
    c.first_column = reach.first;
    c.last_column = reach.last;
    c.nearest = reach.nearest;
    return true;
  }

  // An edge's inner side is where dist * w + (slope of the edge against the ray) >= 0.
  static void add_lines(const Vec2 (&corners)[4], Candidate& c) {
    constexpr double kOnTheLine = 1e-12;
    for (int i = 0; i < 4; ++i) {
      const Vec2 edge = corners[(i + 1) % 4] - corners[i];
      const double dist = -cross(edge, corners[i]);
      if (dist < kOnTheLine) {
        const double scale = 1.0 / -std::min(dist, -kOnTheLine);
        c.near[c.near_count++] = {scale * edge.x, -scale * edge.y, i};
      } else {
        const double scale = -1.0 / dist;
        c.far[c.far_count++] = {scale * edge.x, -scale * edge.y, i};
      }
    }
  }

  struct Interval {
    double near = 0.0;  // inverse depths
    double far = 0.0;
    int face = 0;
    bool empty() const { return !(near > far); }
  };

  // Where a ray passes through a solid; perhaps empty if all of that is farther than `farthest`.
  static Interval meet(const Candidate& c, double s, double farthest) {
    if (c.is_disc) return meet_disc(c, s);
    Interval interval{kInfinity, 0.0, -1};
    for (int i = 0; i < c.near_count; ++i) {
      const double w = c.near[i].slope * s + c.near[i].offset;
      if (w < interval.near) interval = {w, 0.0, c.near[i].face};
    }
    if (interval.near <= farthest) return {};
    for (int i = 0; i < c.far_count; ++i) {
      interval.far = std::max(interval.far, c.far[i].slope * s + c.far[i].offset);
    }
    return interval;
  }

  // beyond w^2 - 2 ahead w + (1 + s^2) <= 0
  static Interval meet_disc(const Candidate& c, double s) {
    const double ahead = c.center.x + s * c.center.y;
    const double square = 1.0 + s * s;
    const double root = ahead * ahead - c.beyond * square;
    if (root < 0.0) return {};
    const double r = exact::sqrt(root);
    if (c.beyond > 0.0) {
      return ahead > 0.0 ? Interval{(ahead + r) / c.beyond, square / (ahead + r), kRoundFace} : Interval{};
    }
    const double far = ahead > 0.0 ? square / (ahead + r) : (ahead - r) / c.beyond;  // the eye is above or below it
    return {kInfinity, far, kRoundFace};
  }

  // The first row whose centre is at or below a height seen at an inverse depth.
  int row_at(double height, double inverse) const {
    const double v = camera_.cy - camera_.fy * (height * inverse) - 0.5;
    if (!(v > 0.0)) return 0;
    return v >= camera_.height ? camera_.height : static_cast<int>(std::ceil(v));
  }

  // Finds what a column shows; `place` is its number in the strip.
  void draw_column(int column, int place) {
    const double s = slope_of(column);
    const auto& hit = out_.wall_hits[static_cast<std::size_t>(column)];
    const Candidate* wall = hit.wall < 0 ? nullptr : &out_.walls[static_cast<std::size_t>(hit.wall)];
    add_base(s, {hit.inverse, 0.0, hit.face}, wall);

    // what stands before the wall
    bool layered = false;
    for (const Columns::Entry& entry : out_.blocks[static_cast<std::size_t>(column / kBlock)]) {
      if (entry.nearest <= hit.inverse || column < entry.first_column || column > entry.last_column) continue;
      const Candidate& c = out_.others[static_cast<std::size_t>(entry.candidate)];
      Interval interval = meet(c, s, hit.inverse);
      interval.far = std::max(interval.far, hit.inverse);
      if (interval.empty()) continue;
      if (!layered) lay_base();
      layered = true;
      add_faces(c, interval, s);
    }

    if (!layered) {
      for (std::size_t i = 0; i < out_.base.size(); ++i) {
        if (out_.base[i].begin < out_.base[i].end) add_span(place, s, out_.base[i].begin, out_.runs[i]);
      }
      return;
    }
    add_spans(place, s);
  }

  // Ceiling or sky, the wall, the floor: from top to bottom without a gap.
  void add_base(double s, const Interval& wall, const Candidate* candidate) {
    out_.runs.clear();
    out_.base.clear();
    const auto add = [&](const Run& run, int begin, int end) {
      out_.runs.push_back(run);
      out_.base.push_back({begin, end});
    };
    const double v = camera_.cy - 0.5;
    const int horizon = row_at(0.0, 0.0);
    const bool on_row = v == horizon && horizon < camera_.height;  // a row looks exactly along the horizon
    int bottom = on_row ? horizon + 1 : horizon;
    if (candidate) {
      const int top = row_at(place_.ceiling - height_, wall.near);
      bottom = std::max(top, row_at(-height_, wall.near));
      add({Run::Kind::ceiling}, 0, top);
      for_each_part(*candidate, wall, s, top, bottom, add);
    } else if (roofed_) {
      add({Run::Kind::ceiling}, 0, horizon);
    } else {
      const int hills = place_.is_open ? std::min(horizon, row_at(hill_slope(forward_ + s * left_), 1.0)) : horizon;
      add({Run::Kind::sky}, 0, hills);
      add({Run::Kind::hills}, hills, horizon);
    }
    if (!candidate && on_row) add({Run::Kind::nothing}, horizon, bottom);
    add_floors(s, wall.near, bottom);
  }

  // The floors along the ray, from the wall to the eye: rows from `top` down.
  void add_floors(double s, double inverse, int top) {
    constexpr int kMostFloors = 32;
    constexpr double kStep = 1e-7;  // [m] into the next room
    const Vec2 direction = forward_ + s * left_;
    const double reach = inverse > 0.0 ? 1.0 / inverse : kInfinity;
    const std::size_t first = out_.runs.size();
    int end = camera_.height;
    double x = 0.0;
    for (int i = 0; i < kMostFloors && end > top; ++i) {
      const FloorRegion* floor = place_.floor_at(eye_ + (x + kStep) * direction);
      x = i + 1 < kMostFloors ? std::max(x, next_floor(floor, direction, x + kStep)) : kInfinity;
      const int begin = x >= reach || x == kInfinity ? top : std::clamp(row_at(-height_, 1.0 / x), top, end);
      Run run{Run::Kind::floor};
      run.floor = floor;
      out_.runs.push_back(run);
      out_.base.push_back({begin, end});
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
    clip(floor.min.x - eye_.x, floor.max.x - eye_.x, direction.x);
    clip(floor.min.y - eye_.y, floor.max.y - eye_.y, direction.y);
    return {enter, leave};
  }

  // Lays the base out by rows, for other things to be compared with.
  void lay_base() {
    for (std::size_t i = 0; i < out_.base.size(); ++i) {
      const auto [inverse, rise] = inverse_of(out_.runs[i]);
      lay(layers(), out_.base[i].begin, out_.base[i].end, inverse, rise, static_cast<std::int32_t>(i));
    }
  }

  Layers layers() { return {out_.slopes.data(), out_.inverse.data(), out_.owner.data()}; }

  struct Inverse {
    float at_horizon = 0.0F;
    float rise = 0.0F;
  };
  Inverse inverse_of(const Run& run) const {
    const auto flat = [](double z) { return Inverse{0.0F, static_cast<float>(1.0 / z)}; };
    switch (run.kind) {
      case Run::Kind::ceiling: return flat(place_.ceiling - height_);
      case Run::Kind::floor: return flat(-height_);
      case Run::Kind::top: return flat(run.candidate->high);
      case Run::Kind::bottom: return flat(run.candidate->low);
      case Run::Kind::side:
      case Run::Kind::skirting:
      case Run::Kind::decor: return {static_cast<float>(run.inverse), 0.0F};
      default: return {};
    }
  }

  void add_faces(const Candidate& c, const Interval& interval, double s) {
    const int top = row_at(c.high, interval.near);
    const int bottom = row_at(c.low, interval.near);
    if (interval.near < kInfinity) {  // not from above or below
      for_each_part(c, interval, s, top, bottom, [&](const Run& run, int begin, int end) { put(run, begin, end); });
    }
    if (c.high < 0.0) put({Run::Kind::top, kTopFace, &c, 0.0}, row_at(c.high, interval.far), top);
    if (c.low > 0.0) put({Run::Kind::bottom, kBottomFace, &c, 0.0}, bottom, row_at(c.low, interval.far));
  }

  // The parts of a side between two rows, from top to bottom: what hangs on it, its skirting, and the rest.
  template <class Add>
  void for_each_part(const Candidate& c, const Interval& interval, double s, int top, int bottom, Add add) const {
    const Run side{Run::Kind::side, interval.face, &c, interval.near};
    const auto row_of = [&](double z) { return std::clamp(row_at(z - height_, interval.near), top, bottom); };
    const int foot = place_.has_skirting(*c.visible) ? row_of(kSkirting) : bottom;
    if (const Decor* decor = find_decor(c, interval, s)) {
      Run part = side;
      part.kind = Run::Kind::decor;
      part.decor = decor;
      const int high = row_of(decor->high);
      const int low = row_of(decor->low);
      add(side, top, high);
      add(part, high, low);
      top = low;
    }
    add(side, top, foot);
    Run skirting = side;
    skirting.kind = Run::Kind::skirting;
    add(skirting, foot, bottom);
  }

  // What hangs on a wall where a ray meets it.
  const Decor* find_decor(const Candidate& c, const Interval& interval, double s) const {
    const auto all = place_.decor_of(c.solid);
    if (all.empty()) return nullptr;
    const auto face = static_cast<std::size_t>(interval.face);
    const auto& corners = c.visible->solid.corners;
    const Vec2 edge = corners[(face + 1) % 4] - corners[face];
    const Vec2 hit = eye_ + (1.0 / interval.near) * (forward_ + s * left_);
    const double along = dot(hit - corners[face], edge) / norm(edge);
    const auto found = std::ranges::find_if(
        all, [&](const Decor& d) { return d.face == interval.face && d.begin <= along && along < d.end; });
    return found == all.end() ? nullptr : &*found;
  }

  // Gives a run the rows in which it is nearest so far.
  void put(const Run& run, int begin, int end) {
    if (begin >= end) return;
    const auto [inverse, rise] = inverse_of(run);
    const auto owner = static_cast<std::int32_t>(out_.runs.size());
    out_.runs.push_back(run);
    view::put(layers(), begin, end, inverse, rise, owner);
  }

  // One span for each stretch of rows with one owner. Most rows have that of the row above: look at many at a time.
  void add_spans(int column, double s) {
    constexpr std::size_t kAtOnce = 16;
    const std::size_t rows = out_.owner.size();
    const std::int32_t* owner = out_.owner.data();
    const auto add = [&](std::size_t row) {
      add_span(column, s, static_cast<int>(row), out_.runs[static_cast<std::size_t>(owner[row])]);
    };
    add(0);
    for (std::size_t begin = 1; begin < rows; begin += kAtOnce) {
      const std::size_t end = std::min(begin + kAtOnce, rows);
      if (end == begin + kAtOnce) {
        std::int32_t changes = 0;
        for (std::size_t i = 0; i < kAtOnce; ++i) changes |= owner[begin + i] ^ owner[begin + i - 1];
        if (changes == 0) continue;
      }
      for (std::size_t r = begin; r < end; ++r) {
        if (owner[r] != owner[r - 1]) add(r);
      }
    }
  }

  void add_span(int column, double s, int row, const Run& run) {
    auto& first = out_.first_span[static_cast<std::size_t>(row)];
    Span& span = out_.spans.emplace_back();
    span.column = column;
    span.next = first;
    first = static_cast<std::int32_t>(out_.spans.size()) - 1;
    const auto [inverse, rise] = inverse_of(run);
    span.fields[kInverse] = inverse;
    span.fields[kInverseRise] = rise;
    const Vec2 direction = forward_ + s * left_;
    switch (run.kind) {
      case Run::Kind::nothing: break;
      case Run::Kind::sky: fill_sky(span.fields, direction); break;
      case Run::Kind::hills:
        fill_look(span.fields, hill_look());
        span.fields[kInverse] = 1.0F;
        span.fields[kGlow] = sun_share(direction);
        break;
      case Run::Kind::ceiling:
        fill_flat(span.fields, place_.ceiling_look, {}, {1.0, 0.0}, direction, place_.ceiling - height_);
        span.fields[kId] = kCeilingId;
        break;
      case Run::Kind::floor:
        fill_flat(span.fields, run.floor ? run.floor->floor : place_.outside_floor, {}, {1.0, 0.0}, direction,
                  -height_);
        span.fields[kId] = kFloorId;
        break;
      case Run::Kind::side:
      case Run::Kind::skirting:
      case Run::Kind::decor: fill_side(span.fields, run, direction); break;
      case Run::Kind::top:
      case Run::Kind::bottom: fill_face(span.fields, run, direction); break;
    }
  }

  static void fill_look(Fields& f, const Look& look) {
    f[kBlue] = look.colour.b;
    f[kGreen] = look.colour.g;
    f[kRed] = look.colour.r;
    f[kDark] = look.dark;
    f[kContrast] = look.contrast;
    f[kShade] = look.shade;
    f[kShadeRise] = look.shade_rise;
    f[kTile] = static_cast<float>(static_cast<int>(look.material) * kTileRows);
  }

  // A level surface `height` above the eye, with its texture along `axis` from `origin`.
  void fill_flat(Fields& f, const Look& look, Vec2 origin, Vec2 axis, Vec2 direction, double height) const {
    fill_look(f, look);
    const double per_metre = 1.0 / spec(look.material).tile_size;
    const Vec2 across{-axis.y, axis.x};
    f[kU] = static_cast<float>(per_metre * dot(eye_ - origin, axis));
    f[kUStep] = static_cast<float>(per_metre * dot(direction, axis));
    f[kV] = static_cast<float>(per_metre * dot(eye_ - origin, across));
    f[kVStep] = static_cast<float>(per_metre * dot(direction, across));
    f[kFootprintRise] = static_cast<float>(flat_footprint(height) * kTileSide * per_metre);
  }

  // Of a pixel at depth 1 [m]; it grows with the square of the depth.
  double flat_footprint(double height) const { return 0.35 / (camera_.fy * std::fabs(height)); }

  void fill_face(Fields& f, const Run& run, Vec2 direction) const {
    const Candidate& c = *run.candidate;
    const Solid& solid = c.visible->solid;
    const bool is_top = run.kind == Run::Kind::top;
    const Look look = is_top ? top_look(*c.visible, c.colour) : bottom_look(*c.visible, c.colour);
    Vec2 axis{1.0, 0.0};
    if (!c.is_disc) {
      // along the longer side
      const Vec2 a = solid.corners[1] - solid.corners[0];
      const Vec2 b = solid.corners[3] - solid.corners[0];
      const Vec2 longer = dot(a, a) >= dot(b, b) ? a : b;
      axis = (1.0 / norm(longer)) * longer;
    }
    fill_flat(f, look, solid.center, axis, direction, is_top ? c.high : c.low);
    f[kId] = static_cast<float>(c.visible->id);
  }

  void fill_side(Fields& f, const Run& run, Vec2 direction) const {
    const Candidate& c = *run.candidate;
    const Solid& solid = c.visible->solid;
    const double depth = 1.0 / run.inverse;
    const Vec2 hit = eye_ + depth * direction;
    Vec2 normal;
    double along = 0.0;
    if (c.is_disc) {
      normal = (1.0 / solid.radius) * (hit - solid.center);
      along = solid.radius * exact::atan2(normal.y, normal.x);
    } else {
      const Vec2 a = solid.corners[static_cast<std::size_t>(run.face)];
      const Vec2 edge = solid.corners[static_cast<std::size_t>((run.face + 1) % 4)] - a;
      const Vec2 axis = (1.0 / norm(edge)) * edge;
      normal = {axis.y, -axis.x};
      along = dot(hit - a, axis);
    }
    const Look look = look_of(run, normal, hit);
    fill_look(f, look);
    const double per_metre = 1.0 / spec(look.material).tile_size;
    const double left = run.decor ? run.decor->begin : 0.0;
    const double low = run.decor ? run.decor->low : 0.0;
    f[kU] = static_cast<float>(per_metre * (along - left));
    f[kV] = static_cast<float>(per_metre * (height_ - low));
    f[kVRise] = static_cast<float>(per_metre);
    f[kFootprint] = static_cast<float>(side_footprint(depth, direction, normal) * kTileSide * per_metre);
    f[kId] = static_cast<float>(c.visible->id);
  }

  Look look_of(const Run& run, Vec2 normal, Vec2 hit) const {
    const Candidate& c = *run.candidate;
    if (run.kind == Run::Kind::skirting) return skirting_look(normal);
    if (run.kind == Run::Kind::decor) return run.decor->look;
    if (c.visible->id == kWallId) return place_.wall_look(*c.visible, run.face, normal, hit);
    return side_look(*c.visible, c.colour, normal);
  }

  // Clouds at their height, and the sun's glow.
  void fill_sky(Fields& f, Vec2 direction) const {
    fill_flat(f, cloud_look(), {}, {1.0, 0.0}, direction, kCloudHeight);
    f[kInverse] = 0.0F;
    f[kInverseRise] = static_cast<float>(1.0 / kCloudHeight);
    f[kShade] = 0.0F;
    f[kGlow] = sun_share(direction);
  }

  // Of a pixel on an upright surface [m].
  double side_footprint(double depth, Vec2 direction, Vec2 normal) const {
    const double facing = -dot(direction, normal) / norm(direction);
    return 0.7 * depth / camera_.fx / std::max(facing, 0.35);
  }

  const Place& place_;
  const CameraIntrinsics& camera_;
  Vec2 eye_;
  double height_;
  Columns& out_;
  Vec2 forward_;
  Vec2 left_;
  bool roofed_ = false;
};

}  // namespace

void find_spans(const Place& place, const CameraIntrinsics& camera, const CameraPose& view, const Paint& paint,
                std::span<const VisibleSolid> moving, Columns& columns, const std::function<void(int, int)>& draw) {
  Search(place, camera, view, columns).run(paint, moving, draw);
}

}  // namespace threewe::sim::view
