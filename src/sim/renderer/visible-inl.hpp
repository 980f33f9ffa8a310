// What each pixel of a block of columns shows; for a kernel's source file to include, once per target.
#if defined(THREEWE_SIM_RENDERER_VISIBLE_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef THREEWE_SIM_RENDERER_VISIBLE_INL_HPP
#undef THREEWE_SIM_RENDERER_VISIBLE_INL_HPP
#else
#define THREEWE_SIM_RENDERER_VISIBLE_INL_HPP
#endif

#include <algorithm>
#include <cmath>
#include <limits>
#include <ranges>
#include <span>
#include <utility>

#include "sim/renderer/kernel.hpp"
//
#include "sim/renderer/intersect-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace threewe::sim::view::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Ints = hn::RebindToSigned<Floats>;
using Words = hn::RebindToUnsigned<Floats>;
using F = hn::Vec<Floats>;
using I = hn::Vec<Ints>;
using W = hn::Vec<Words>;
using M = hn::Mask<Floats>;

HWY_INLINE F set(float x) { return hn::Set(Floats(), x); }
HWY_INLINE F set(double x) { return hn::Set(Floats(), static_cast<float>(x)); }
HWY_INLINE W set(std::uint32_t x) { return hn::Set(Words(), x); }
HWY_INLINE I set(std::int32_t x) { return hn::Set(Ints(), x); }
HWY_INLINE F load(const float* from) { return hn::LoadU(Floats(), from); }
HWY_INLINE I load(const std::int32_t* from) { return hn::LoadU(Ints(), from); }
HWY_INLINE W load(const std::uint32_t* from) { return hn::LoadU(Words(), from); }
HWY_INLINE void store(F x, float* to) { hn::StoreU(x, Floats(), to); }
HWY_INLINE void store(I x, std::int32_t* to) { hn::StoreU(x, Ints(), to); }
HWY_INLINE void store(W x, std::uint32_t* to) { hn::StoreU(x, Words(), to); }

/// Calls `act` with the first column of each vector of a block.
template <class Act>
HWY_INLINE void for_lanes(Act act) {
  for (std::size_t i = 0; i < kBlock; i += hn::Lanes(Floats())) act(i);
}

// Who is seen. Floors are negative: region i is `floor_owner(i)`, what lies outside of all is the last of them.
inline constexpr std::int32_t kNothing = 0;
inline constexpr std::int32_t kSky = 1;
inline constexpr std::int32_t kOnHills = 2;
inline constexpr std::int32_t kCeiling = 3;
inline constexpr std::int32_t kFirstSurface = 4;
constexpr std::int32_t floor_owner(std::size_t region) { return -1 - static_cast<std::int32_t>(region); }

/// Rows from `top` up to but not including `bottom`, by column.
struct Extent {
  Lanes<float> top;
  Lanes<float> bottom;
};

/// The columns of a block: where their rays (1, s) go.
struct Columns {
  std::size_t first = 0;
  Lanes<float> slope;
  Lanes<float> x;  // the direction in the scene's frame
  Lanes<float> y;
  Lanes<float> inverse_norm;
};

HWY_INLINE Columns columns_of(const View& view, const Candidates& candidates, std::size_t first) {
  Columns columns;
  columns.first = first;
  for (std::size_t i = 0; i < kBlock; ++i) columns.slope[i] = static_cast<float>(candidates.slopes[first + i]);
  for_lanes([&](std::size_t i) HWY_ATTR {
    const F s = load(&columns.slope[i]);
    store(hn::Add(set(view.forward.x), hn::Mul(s, set(view.left.x))), &columns.x[i]);
    store(hn::Add(set(view.forward.y), hn::Mul(s, set(view.left.y))), &columns.y[i]);
    const F norm = hn::Sqrt(hn::Add(set(1.0F), hn::Mul(s, s)));
    store(hn::Div(set(1.0F), norm), &columns.inverse_norm[i]);
  });
  return columns;
}

/// Finds who is seen where in a block, and how far away: first walls, ceiling or sky, and floors, which leave no gap;
/// then what stands before them, in any order, each where it is nearer than what is there.
class Finder {
 public:
  Finder(const Drawing& drawing, const Columns& columns, BlockWork& work)
      : place_(drawing.place),
        view_(drawing.view),
        rows_(drawing.rows),
        candidates_(drawing.candidates),
        columns_(columns),
        work_(work),
        detail_(drawing.shading.detail),
        count_(static_cast<float>(rows_.count)),
        middle_(static_cast<float>(view_.camera.cy - 0.5)) {}

  void run() {
    work_.surface_count = 0;
    fill_base();
    fill_floors();
    for (const Candidates::Entry& entry : candidates_.blocks[columns_.first / kBlock]) {
      put(candidates_.others[static_cast<std::size_t>(entry.candidate)]);
    }
  }

 private:
  // A column of the picture; those beyond the last are like it.
  std::size_t column(std::size_t i) const {
    return std::min(columns_.first + i, static_cast<std::size_t>(view_.camera.width) - 1);
  }

  // How many rows per unit of inverse depth a height above the eye is above the horizon.
  F pixels(double z) const { return set(view_.camera.fy * z); }

  // The first row whose centre is at or below a height, given as `pixels`, that is seen at an inverse depth.
  HWY_INLINE F row_of(F pixels, F inverse) const {
    const F row = hn::Ceil(hn::Sub(set(middle_), hn::Mul(pixels, inverse)));
    return hn::Min(hn::Max(row, set(0.0F)), set(count_));
  }

  // Calls `act(place, lanes)` for every vector of an extent: its place in arrays by row, its first lane, and which of
  // its columns are in the extent.
  template <class Act>
  HWY_INLINE void for_extent(const Extent& extent, Act act) const {
    const Floats d;
    for_lanes([&](std::size_t i) HWY_ATTR {
      const F top = load(&extent.top[i]);
      const F bottom = load(&extent.bottom[i]);
      const float first = hn::GetLane(hn::MinOfLanes(d, top));
      const auto end = static_cast<std::size_t>(hn::GetLane(hn::MaxOfLanes(d, bottom)));
      F row = set(first);
      for (auto r = static_cast<std::size_t>(first); r < end; ++r) {
        act(r, i, hn::And(hn::Ge(row, top), hn::Lt(row, bottom)));
        row = hn::Add(row, set(1.0F));
      }
    });
  }

  // Gives an extent to an owner wherever that is nearer; false if it is not anywhere.
  template <class DepthAt>
  HWY_INLINE bool claim(const Extent& extent, DepthAt depth_at, std::int32_t owner) {
    const Ints di;
    float* HWY_RESTRICT depths = work_.depth.data();
    std::int32_t* HWY_RESTRICT owners = work_.owner.data();
    I any = hn::Zero(di);
    for_extent(extent, [&](std::size_t r, std::size_t i, M within) HWY_ATTR {
      const std::size_t at = r * kBlock + i;
      const F there = load(depths + at);
      const F depth = depth_at(r, i);
      const M nearer = hn::And(within, hn::Lt(depth, there));
      const auto who = hn::RebindMask(di, nearer);
      store(hn::IfThenElse(nearer, depth, there), depths + at);
      store(hn::IfThenElse(who, set(owner), load(owners + at)), owners + at);
      any = hn::Or(any, hn::VecFromMask(di, who));
    });
    return !hn::AllTrue(di, hn::Eq(any, hn::Zero(di)));
  }

  // Gives the part of an extent that belongs to owners from `low` to `high` to another; false if that is nothing.
  HWY_INLINE bool take_over(const Extent& extent, std::int32_t low, std::int32_t high, std::int32_t owner) {
    const Ints di;
    std::int32_t* HWY_RESTRICT owners = work_.owner.data();
    I any = hn::Zero(di);
    for_extent(extent, [&](std::size_t r, std::size_t i, M within) HWY_ATTR {
      std::int32_t* at = owners + r * kBlock + i;
      const I there = load(at);
      const auto theirs = hn::And(hn::Gt(there, set(low - 1)), hn::Lt(there, set(high + 1)));
      const auto who = hn::And(hn::RebindMask(di, within), theirs);
      store(hn::IfThenElse(who, set(owner), there), at);
      any = hn::Or(any, hn::VecFromMask(di, who));
    });
    return !hn::AllTrue(di, hn::Eq(any, hn::Zero(di)));
  }

  // A surface that is not yet seen; `keep` it if it is.
  Surface& next_surface(Surface::Kind kind, const Candidate& candidate) {
    if (work_.surfaces.size() == work_.surface_count) work_.surfaces.emplace_back();
    Surface& surface = work_.surfaces[work_.surface_count];
    surface.kind = kind;
    surface.is_ready = false;
    surface.candidate = &candidate;
    surface.decor = nullptr;
    return surface;
  }
  std::int32_t next_owner() const { return kFirstSurface + static_cast<std::int32_t>(work_.surface_count); }
  void keep() { ++work_.surface_count; }

  // Ceiling or sky, the nearest wall, the floor.
  void fill_base() {
    Extent wall;
    Lanes<float> depth;
    Lanes<std::int32_t> owner;
    Lanes<float> inverse;
    for (std::size_t i = 0; i < kBlock; ++i) {
      inverse[i] = static_cast<float>(candidates_.wall_inverse[column(i)]);
    }
    const F top = pixels(view_.is_roofed ? place_.ceiling - view_.height : 0.0);
    const F bottom = pixels(-view_.height);
    for_lanes([&](std::size_t i) HWY_ATTR {
      const F w = load(&inverse[i]);
      const F from = row_of(top, w);
      store(from, &wall.top[i]);
      store(hn::Max(from, row_of(bottom, w)), &wall.bottom[i]);
      store(hn::Div(set(1.0F), hn::Max(w, set(1e-30F))), &depth[i]);  // finite also where there is no wall
    });
    find_walls(depth, owner);

    const I above = set(view_.is_roofed ? kCeiling : kSky);
    const I below = set(floor_owner(place_.floors.size()));
    const auto [first, first_all] = range_of(wall.top);
    const auto [last_all, last] = range_of(wall.bottom);
    fill_rows(0, first, rows_.above.data(), above);
    fill_rows(last, static_cast<std::size_t>(rows_.count), rows_.below.data(), below);
    float* HWY_RESTRICT depths = work_.depth.data();
    std::int32_t* HWY_RESTRICT owners = work_.owner.data();
    for_lanes([&](std::size_t i) HWY_ATTR {
      const Ints di;
      const F from = load(&wall.top[i]);
      const F to = load(&wall.bottom[i]);
      const F at_wall = load(&depth[i]);
      const I of_wall = load(&owner[i]);
      const auto at_edge = [&](std::size_t begin, std::size_t end) HWY_ATTR {
        F row = set(static_cast<float>(begin));
        for (std::size_t r = begin; r < end; ++r) {
          const M is_above = hn::Lt(row, from);
          const M is_below = hn::Ge(row, to);
          const F far = hn::IfThenElse(is_above, set(rows_.above[r]), at_wall);
          const I who = hn::IfThenElse(hn::RebindMask(di, is_above), above, of_wall);
          store(hn::IfThenElse(is_below, set(rows_.below[r]), far), depths + r * kBlock + i);
          store(hn::IfThenElse(hn::RebindMask(di, is_below), below, who), owners + r * kBlock + i);
          row = hn::Add(row, set(1.0F));
        }
      };
      if (first_all >= last_all) return at_edge(first, last);
      at_edge(first, first_all);
      for (std::size_t r = first_all; r < last_all; ++r) {
        store(at_wall, depths + r * kBlock + i);
        store(of_wall, owners + r * kBlock + i);
      }
      at_edge(last_all, last);
    });
    if (rows_.level >= 0) fill_horizon();
    if (place_.is_open && !view_.is_roofed) fill_hills();
    hang_on_walls(wall, owner);
    bottom_ = wall.bottom;
  }

  // The least and the greatest row of some.
  HWY_INLINE std::pair<std::size_t, std::size_t> range_of(const Lanes<float>& rows) const {
    const auto [least, most] = std::ranges::minmax(std::span(rows).first(kBlock));
    return {static_cast<std::size_t>(least), static_cast<std::size_t>(most)};
  }

  // Whole rows that look at one level surface.
  HWY_INLINE void fill_rows(std::size_t begin, std::size_t end, const float* HWY_RESTRICT depth, I owner) {
    float* HWY_RESTRICT depths = work_.depth.data();
    std::int32_t* HWY_RESTRICT owners = work_.owner.data();
    for (std::size_t r = begin; r < end; ++r) {
      for_lanes([&](std::size_t i) HWY_ATTR {
        store(set(depth[r]), depths + r * kBlock + i);
        store(owner, owners + r * kBlock + i);
      });
    }
  }

  // A row that looks exactly along the horizon sees no floor.
  void fill_horizon() {
    const std::size_t at = static_cast<std::size_t>(rows_.level) * kBlock;
    for (std::size_t i = at; i < at + kBlock; ++i) {
      if (work_.owner[i] < 0) work_.owner[i] = kNothing;
    }
  }

  void fill_hills() {
    Extent hills;
    for (std::size_t i = 0; i < kBlock; ++i) {
      const double s = candidates_.slopes[columns_.first + i];
      hills.top[i] = static_cast<float>(view_.row_at(hill_slope(view_.direction(s)), 1.0));
      hills.bottom[i] = count_;
    }
    take_over(hills, kSky, kSky, kOnHills);
  }

  // The nearest walls of the block become surfaces, each with all of the block's depths.
  void find_walls(const Lanes<float>& depth, Lanes<std::int32_t>& owner) {
    Lanes<float> face;
    for (std::size_t i = 0; i < kBlock; ++i) face[i] = static_cast<float>(candidates_.wall_face[column(i)]);
    std::int32_t last = -1;
    for (std::size_t i = 0; i < kBlock; ++i) {
      const std::int32_t wall = candidates_.wall[column(i)];
      if (wall < 0) {
        owner[i] = kNothing;
        continue;
      }
      if (wall != last) {
        Surface& surface = next_surface(Surface::Kind::side, candidates_.walls[static_cast<std::size_t>(wall)]);
        surface.depth = depth;
        surface.face = face;
        keep();
        last = wall;
      }
      owner[i] = kFirstSurface + static_cast<std::int32_t>(work_.surface_count) - 1;
    }
  }

  void hang_on_walls(const Extent& walls, const Lanes<std::int32_t>& owner) {
    const std::size_t count = work_.surface_count;
    for (std::size_t k = 0; k < count; ++k) {
      const std::int32_t who = kFirstSurface + static_cast<std::int32_t>(k);
      Extent extent;
      for (std::size_t i = 0; i < kBlock; ++i) {
        extent.top[i] = owner[i] == who ? walls.top[i] : count_;
        extent.bottom[i] = owner[i] == who ? walls.bottom[i] : 0.0F;
      }
      hang_on_wall(k, extent);
    }
  }

  // The floors of rooms and patches, what lies on top last.
  void fill_floors() {
    const std::size_t here = candidates_.floor;
    const std::size_t count = place_.floors.size();
    if (here < count) {
      const Extent extent = extent_of(place_.floors[here]);
      if (reaches_walls(extent)) {
        fill_floor(here, extent);
        for (const std::size_t i : std::views::reverse(place_.floors[here].above)) fill_floor(i);
        return;
      }
    }
    for (std::size_t i = count; i-- > 0;) fill_floor(i);
  }

  void fill_floor(std::size_t i) { fill_floor(i, extent_of(place_.floors[i])); }
  void fill_floor(std::size_t i, const Extent& extent) {
    take_over(extent, floor_owner(place_.floors.size()), -1, floor_owner(i));
  }

  bool reaches_walls(const Extent& extent) const {
    for (std::size_t i = 0; i < kBlock; ++i) {
      if (extent.top[i] > bottom_[i] || extent.bottom[i] < count_) return false;
    }
    return true;
  }

  // Rows in which a region of the floor is seen, or would be.
  HWY_INLINE Extent extent_of(const FloorRegion& region) const {
    Extent extent;
    const F floor = pixels(-view_.height);
    for_lanes([&](std::size_t i) HWY_ATTR {
      const F zero = set(0.0F);
      const auto inverse = [&](const Lanes<float>& direction) HWY_ATTR {
        const F x = load(&direction[i]);
        return hn::IfThenElse(hn::Eq(x, zero), set(1e30F), hn::Div(set(1.0F), x));
      };
      const F x = inverse(columns_.x);
      const F y = inverse(columns_.y);
      const F x0 = hn::Mul(set(region.min.x - view_.eye.x), x);
      const F x1 = hn::Mul(set(region.max.x - view_.eye.x), x);
      const F y0 = hn::Mul(set(region.min.y - view_.eye.y), y);
      const F y1 = hn::Mul(set(region.max.y - view_.eye.y), y);
      const F enter = hn::Max(hn::Min(x0, x1), hn::Min(y0, y1));
      const F leave = hn::Min(hn::Max(x0, x1), hn::Max(y0, y1));
      const M is_seen = hn::And(hn::Gt(leave, enter), hn::Gt(leave, zero));
      const F one = set(1.0F);
      const F top = hn::Max(row_of(floor, hn::Div(one, leave)), load(&bottom_[i]));
      const F bottom = hn::IfThenElse(hn::Gt(enter, zero), row_of(floor, hn::Div(one, enter)), set(count_));
      store(hn::IfThenElse(is_seen, top, set(count_)), &extent.top[i]);
      store(hn::IfThenElse(is_seen, bottom, zero), &extent.bottom[i]);
    });
    return extent;
  }

  // A solid before the walls: its sides, and its top or bottom.
  void put(const Candidate& c) {
    Lanes<float> near;
    Lanes<float> far;
    if (!intersect_columns(c, near, far)) return;
    const F high = pixels(c.high);
    const F low = pixels(c.low);
    Extent side;
    Extent top;
    Extent bottom;
    Surface& surface = work_.surfaces[work_.surface_count];
    for_lanes([&](std::size_t i) HWY_ATTR {
      const F w = load(&near[i]);
      const F v = load(&far[i]);
      const M is_met = hn::Gt(w, set(0.0F));
      const M is_beside = hn::And(is_met, hn::Lt(w, set(std::numeric_limits<float>::infinity())));
      const F from = row_of(high, w);
      const F to = row_of(low, w);
      store(hn::Div(set(1.0F), w), &surface.depth[i]);
      store(hn::IfThenElse(is_beside, from, set(count_)), &side.top[i]);
      store(hn::IfThenElse(is_beside, to, set(0.0F)), &side.bottom[i]);
      store(hn::IfThenElse(is_met, row_of(high, v), set(count_)), &top.top[i]);
      store(hn::IfThenElse(is_met, from, set(0.0F)), &top.bottom[i]);
      store(hn::IfThenElse(is_met, to, set(count_)), &bottom.top[i]);
      store(hn::IfThenElse(is_met, row_of(low, v), set(0.0F)), &bottom.bottom[i]);
    });
    const float* HWY_RESTRICT depth = surface.depth.data();
    if (claim(side, [&](std::size_t, std::size_t i) HWY_ATTR { return load(depth + i); }, next_owner())) {
      keep();
      if (c.visible->id == kWallId) hang_on_wall(work_.surface_count - 1, side);
    }
    if (c.high < 0.0) put_level(c, Surface::Kind::top, c.high, top);
    if (c.low > 0.0) put_level(c, Surface::Kind::bottom, c.low, bottom);
  }

  void put_level(const Candidate& c, Surface::Kind kind, double height, const Extent& extent) {
    next_surface(kind, c);
    const float* HWY_RESTRICT inverse = rows_.inverse.data();
    const F z = set(height);
    const auto depth_at = [&](std::size_t r, std::size_t) HWY_ATTR { return hn::Mul(z, set(inverse[r])); };
    if (claim(extent, depth_at, next_owner())) keep();
  }

  // Where the columns pass through a solid, as inverse depths; `near` is negative where they do not. False if none
  // does.
  HWY_INLINE bool intersect_columns(const Candidate& c, Lanes<float>& near, Lanes<float>& far) {
    const Doubles d;
    const hn::Rebind<float, Doubles> df;
    Surface& surface = next_surface(Surface::Kind::side, c);
    const double* slopes = candidates_.slopes.data() + columns_.first;
    const double* walls = candidates_.wall_inverse.data() + columns_.first;
    bool any = false;
    for (std::size_t i = 0; i < kBlock; i += hn::Lanes(d)) {
      const Passage passage = pass_through(c.outline, hn::LoadU(d, slopes + i), hn::LoadU(d, walls + i));
      const D entered = hn::IfThenElse(passage.met, passage.hits.near, hn::Set(d, -1.0));
      hn::StoreU(hn::DemoteTo(df, entered), df, &near[i]);
      hn::StoreU(hn::DemoteTo(df, passage.hits.far), df, &far[i]);
      hn::StoreU(hn::DemoteTo(df, passage.hits.face), df, &surface.face[i]);
      any |= !hn::AllFalse(d, passage.met);
    }
    return any;
  }

  // What is on a wall that is seen: its skirting, windows, pictures.
  void hang_on_wall(std::size_t k, const Extent& wall) {
    const Candidate& c = *work_.surfaces[k].candidate;
    if (place_.has_skirting(*c.visible) && detail_ >= kSkirtingDetail) {
      hang(k, Surface::Kind::skirting, nullptr, part_of(k, wall, kSkirting, 0.0));
    }
    for (const Decor& decor : place_.decor_of(c.solid)) {
      if (detail_ < decor.detail) continue;
      Extent extent = part_of(k, wall, decor.high, decor.low);
      if (keep_columns(k, decor, extent)) hang(k, Surface::Kind::decor, &decor, extent);
    }
  }

  void hang(std::size_t k, Surface::Kind kind, const Decor* decor, const Extent& extent) {
    Surface& surface = next_surface(kind, *work_.surfaces[k].candidate);
    const Surface& wall = work_.surfaces[k];
    surface.decor = decor;
    surface.depth = wall.depth;
    surface.face = wall.face;
    const std::int32_t owner = kFirstSurface + static_cast<std::int32_t>(k);
    if (take_over(extent, owner, owner, next_owner())) keep();
  }

  // The part of a wall between two heights above the floor.
  HWY_INLINE Extent part_of(std::size_t k, const Extent& wall, double high, double low) const {
    Extent extent;
    const F top = pixels(high - view_.height);
    const F bottom = pixels(low - view_.height);
    for_lanes([&](std::size_t i) HWY_ATTR {
      const F w = hn::Div(set(1.0F), load(&work_.surfaces[k].depth[i]));
      store(hn::Max(row_of(top, w), load(&wall.top[i])), &extent.top[i]);
      store(hn::Min(row_of(bottom, w), load(&wall.bottom[i])), &extent.bottom[i]);
    });
    return extent;
  }

  // Leaves an extent only those columns that meet a wall where something hangs; false if none does.
  HWY_INLINE bool keep_columns(std::size_t k, const Decor& decor, Extent& extent) const {
    const Surface& surface = work_.surfaces[k];
    const Side& side = (*surface.candidate->sides)[static_cast<std::size_t>(decor.face)];
    const Vec2 from = view_.eye - side.corner;
    bool any = false;
    for_lanes([&](std::size_t i) HWY_ATTR {
      const F ahead = hn::Add(set(dot(view_.forward, side.axis)),
                              hn::Mul(load(&columns_.slope[i]), set(dot(view_.left, side.axis))));
      const F along = hn::Add(set(dot(from, side.axis)), hn::Mul(load(&surface.depth[i]), ahead));
      const M on_face = hn::Eq(load(&surface.face[i]), set(static_cast<float>(decor.face)));
      const M within = hn::And(hn::Ge(along, set(decor.begin)), hn::Lt(along, set(decor.end)));
      const M here = hn::And(on_face, within);
      store(hn::IfThenElse(here, load(&extent.top[i]), set(count_)), &extent.top[i]);
      store(hn::IfThenElse(here, load(&extent.bottom[i]), set(0.0F)), &extent.bottom[i]);
      any |= !hn::AllFalse(Floats(), here);
    });
    return any;
  }

  const Place& place_;
  const View& view_;
  const Rows& rows_;
  const Candidates& candidates_;
  const Columns& columns_;
  BlockWork& work_;
  float detail_;
  float count_;
  float middle_;
  Lanes<float> bottom_;  // of the walls
};

}  // namespace threewe::sim::view::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
