// How the pixels of a block get their colours, once it is known who is seen; for a kernel's source file to include,
// once per target.
//
// In one pass each surface leaves four numbers in its pixels: the place of a texel, light, a tint, and under the sky a
// veil of haze. In a second all texels are found, in a third all colours are made of the four. Short passes keep a
// processor busy: in one long one every pixel would wait for its texel.
#if defined(THREEWE_SIM_RENDERER_SHADE_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef THREEWE_SIM_RENDERER_SHADE_INL_HPP
#undef THREEWE_SIM_RENDERER_SHADE_INL_HPP
#else
#define THREEWE_SIM_RENDERER_SHADE_INL_HPP
#endif

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <span>

#include "sim/renderer/kernel.hpp"
#include "sim/renderer/materials.hpp"
#include "sim/renderer/textures.hpp"
//
#include "sim/renderer/visible-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace threewe::sim::view::HWY_NAMESPACE {

// Adding this to a number below 2^22, of either sign, leaves the nearest whole number in the low bits: one operation,
// where converting takes several that guard against overflow.
constexpr float kRounder = 12582912.0F;
HWY_INLINE W rounded(F x) { return hn::BitCast(Words(), hn::Add(x, set(kRounder))); }
HWY_INLINE W byte(F x) { return hn::And(rounded(x), set(255U)); }

HWY_INLINE W pack(F b, F g, F r) {
  const auto channel = [](F x) HWY_ATTR { return byte(hn::Min(x, set(255.0F))); };
  return hn::Or(channel(b), hn::Or(hn::ShiftLeft<8>(channel(g)), hn::ShiftLeft<16>(channel(r))));
}

// The number of texels across the level that suits a footprint [texels of level 0]: a power of two, made from the
// exponent.
HWY_INLINE F level_side(F footprint) {
  constexpr std::uint32_t kOne = 127U << 23U;
  constexpr std::uint32_t kCoarsest = (127U + kTileLevels - 1U) << 23U;
  constexpr std::uint32_t kProduct = (127U + 127U + kTileLevels - 1U) << 23U;  // 2^e times 2^(8 - e)
  const W power = hn::And(hn::BitCast(Words(), footprint), set(0x7F800000U));
  const W within = hn::Min(hn::Max(power, set(kOne)), set(kCoarsest));
  return hn::BitCast(Floats(), hn::Sub(set(kProduct), within));
}
static_assert(kTileSide == 1 << (kTileLevels - 1));

HWY_INLINE W whole(F x) { return hn::BitCast(Words(), hn::ConvertTo(Ints(), x)); }

HWY_INLINE W stride_of(F side) {
  return whole(hn::Add(side, hn::IfThenElseZero(hn::Ge(side, set(64.0F)), hn::Mul(side, set(0.125F)))));
}
// The first texel of a level of a material.
HWY_INLINE W first_of(Material material, F side) {
  const auto end = static_cast<float>((static_cast<int>(material) + 1) * kTileSize);
  return whole(hn::Sub(set(end), hn::Mul(hn::Mul(side, side), set(1.5F))));
}

// Looks up words in a table, each in its place; an even number. One by one: the gather of AVX2 is slower on the
// machines that it was measured on. A function of its own: among other code it gets too few registers.
template <class T>
HWY_NOINLINE void look_up(const T* HWY_RESTRICT table, std::uint32_t* HWY_RESTRICT words, std::size_t count) {
#pragma GCC unroll 4
  for (std::size_t i = 0; i < count; i += 2) {
    std::uint64_t two;
    std::memcpy(&two, words + i, sizeof two);
    words[i] = table[two & 0xFFFFFFFFU];
    words[i + 1] = table[two >> 32U];
  }
}

inline double within_tile(double tiles) { return tiles - std::floor(tiles); }
inline std::uint32_t tint_of(const SurfaceMaterial& look) {
  return view::pack({look.light * look.colour.b, look.light * look.colour.g, look.light * look.colour.r});
}

/// Rows from `begin` up to but not including `end`.
struct Stretch {
  std::size_t begin;
  std::size_t end;
};

/// Gives the pixels of a block what their colours are made of.
class Shader {
 public:
  Shader(const Drawing& drawing, const Columns& columns, BlockWork& work)
      : place_(drawing.place),
        view_(drawing.view),
        rows_(drawing.rows),
        shading_(drawing.shading),
        detail_(detail_of(drawing.shading)),
        columns_(columns),
        work_(work) {}

  // Rows of a band in which the same surfaces lie side by side are painted together.
  void run(const Stretch& band) {
    if (!work_.veil.empty()) std::ranges::fill(work_.veil, 0U);
    band_ = band.begin;
    for (std::size_t begin = band.begin; begin < band.end;) {
      std::size_t end = begin + 1;
      while (end < band.end && is_same(begin, end)) ++end;
      shading({begin, end});
      begin = end;
    }
  }

 private:
  // Where the pixels of a band get what they are made of. Pointers of their own: the compiler believes that pixels may
  // be written over those of vectors.
  struct Pixels {
    std::uint32_t* HWY_RESTRICT texel;
    std::uint32_t* HWY_RESTRICT light;
    std::uint32_t* HWY_RESTRICT tint;
  };
  Pixels pixels() { return {work_.texel.data(), work_.light.data(), work_.tint.data()}; }

  // A row's place in the arrays of its band.
  std::size_t place_of(std::size_t row) const { return (row - band_) * kBlock; }

  HWY_INLINE bool is_same(std::size_t a, std::size_t b) const {
    bool same = true;
    for_lanes([&](std::size_t i) HWY_ATTR {
      const I there = load(&work_.owner[b * kBlock + i]);
      same &= hn::AllTrue(Ints(), hn::Eq(load(&work_.owner[a * kBlock + i]), there));
    });
    return same;
  }

  // The first surface paints all columns, the others then theirs.
  HWY_INLINE void shading(const Stretch& rows) {
    const std::int32_t* owners = work_.owner.data() + rows.begin * kBlock;
    unsigned left = mark(owners, owners[0]) ^ kAll;
    shade_owner<false>(owners[0], rows);
    while (left != 0) {
      const std::int32_t owner = owners[std::countr_zero(left)];
      left &= ~mark(owners, owner);
      shade_owner<true>(owner, rows);
    }
  }

  // Marks an owner's columns; as bits, too.
  HWY_INLINE unsigned mark(const std::int32_t* owners, std::int32_t owner) {
    const Ints d;
    unsigned all = 0;
    for_lanes([&](std::size_t i) HWY_ATTR {
      const auto here = hn::Eq(load(owners + i), set(owner));
      store(hn::VecFromMask(d, here), &mask_[i]);
      std::uint8_t bits[8] = {};
      hn::StoreMaskBits(d, here, bits);
      all |= ((bits[0] | bits[1] << 8U) & ((1U << hn::Lanes(d)) - 1U)) << i;
    });
    return all;
  }

  template <bool kMasked>
  void shade_owner(std::int32_t owner, const Stretch& rows) {
    if (owner < 0) return shade_floor<kMasked>(static_cast<std::size_t>(-1 - owner), rows);
    if (owner == kNothing) return shade_nothing<kMasked>(rows);
    if (owner == kSky) return shade_sky<kMasked>(Cover::clouds, rows);
    if (owner == kOnHills) return shade_sky<kMasked>(Cover::hills, rows);
    if (owner == kCeiling) return shade_ceiling<kMasked>(rows);
    Surface& surface = work_.surfaces[static_cast<std::size_t>(owner - kFirstSurface)];
    if (surface.kind == Surface::Kind::top || surface.kind == Surface::Kind::bottom) {
      return shade_face<kMasked>(surface, rows);
    }
    if (!surface.is_ready) make_ready(surface);
    shade_upright<kMasked>(surface, rows);
  }

  // Calls `act` with the first column of each vector of which something is to be painted.
  template <bool kMasked, class Act>
  HWY_INLINE void for_painted(Act act) const {
    for_lanes([&](std::size_t i) HWY_ATTR {
      if (kMasked && hn::AllTrue(Ints(), hn::Eq(load(&mask_[i]), set(0)))) return;
      act(i);
    });
  }

  template <bool kMasked>
  HWY_INLINE void put(W value, std::size_t i, std::uint32_t* to) const {
    if constexpr (kMasked) {
      const auto here = hn::MaskFromVec(hn::BitCast(Words(), load(&mask_[i])));
      value = hn::IfThenElse(here, value, load(to));
    }
    store(value, to);
  }

  template <bool kMasked>
  HWY_INLINE void shade_upright(const Surface& surface, const Stretch& rows) {
    const std::size_t band = band_;
    const Pixels to = pixels();
    const float* HWY_RESTRICT slopes = rows_.slopes.data();
    for_painted<kMasked>([&](std::size_t i) HWY_ATTR {
      const W line = load(&surface.line[i]);
      const W mask = load(&surface.mask[i]);
      const W tint = load(&surface.tint[i]);
      const F v = load(&surface.v[i]);
      const F v_step = load(&surface.v_step[i]);
      const F foot = load(&surface.foot[i]);
      const F rise = load(&surface.rise[i]);
      for (std::size_t r = rows.begin; r < rows.end; ++r) {
        const std::size_t at = (r - band) * kBlock + i;
        const F t = set(slopes[r]);
        const W place = hn::And(rounded(hn::Add(v, hn::Mul(v_step, t))), mask);
        const F light = hn::Min(hn::Add(foot, hn::Mul(rise, t)), set(kTexelOne));
        put<kMasked>(hn::Add(line, place), i, to.texel + at);
        put<kMasked>(byte(light), i, to.light + at);
        put<kMasked>(tint, i, to.tint + at);
      }
    });
  }

  // Level surfaces in the scene's frame: their texture is laid along `axis`, from `origin`.
  struct Filling {
    Material material{};
    double height = 0.0;  // [m] above the eye
    Vec2 origin{};
    Vec2 axis{1.0, 0.0};
  };

  // Where each row takes its texture from.
  HWY_INLINE void fill(const Filling& filling, const Stretch& rows, LevelRows& out) const {
    constexpr double kPixel = 0.35;  // the size of a pixel on the surface, against its length: it is narrow and long
    const Floats d;
    const double per_metre = 1.0 / spec(filling.material).tile_size;
    const Vec2 from = view_.eye - filling.origin;
    const F u = set(within_tile(per_metre * dot(from, filling.axis)));
    const F v = set(within_tile(per_metre * cross(filling.axis, from)));
    const F footprint = set(kPixel / (view_.camera.fy * std::fabs(filling.height)) * kTileSide * per_metre);
    const F height = set(filling.height);
    const F half = set(0.5F);
    for (std::size_t r = rows.begin; r < rows.end; r += hn::Lanes(d)) {
      const F depth = hn::Mul(height, load(&rows_.inverse[r]));
      const F side = level_side(hn::Mul(hn::Mul(depth, depth), footprint));
      store(hn::Mul(hn::Mul(depth, set(per_metre)), side), &out.scale[r]);
      store(hn::Sub(hn::Mul(u, side), half), &out.u[r]);
      store(hn::Sub(hn::Mul(v, side), half), &out.v[r]);
      store(whole(hn::Sub(side, set(1.0F))), &out.mask[r]);
      store(stride_of(side), &out.stride[r]);
      store(first_of(filling.material, side), &out.first[r]);
    }
  }

  // One that is lit has a light of its own.
  template <bool kMasked, bool kIsLit = false>
  HWY_INLINE void shade_level(const LevelRows& level, Vec2 axis, std::uint32_t tint, const Stretch& rows) {
    const std::size_t band = band_;
    const F x = set(axis.x);
    const F y = set(axis.y);
    const Pixels to = pixels();
    const float* HWY_RESTRICT scales = level.scale.data();
    const float* HWY_RESTRICT us = level.u.data();
    const float* HWY_RESTRICT vs = level.v.data();
    const std::uint32_t* HWY_RESTRICT masks = level.mask.data();
    const std::uint32_t* HWY_RESTRICT strides = level.stride.data();
    const std::uint32_t* HWY_RESTRICT firsts = level.first.data();
    for_painted<kMasked>([&](std::size_t i) HWY_ATTR {
      const F ahead = load(&columns_.x[i]);
      const F left = load(&columns_.y[i]);
      const F u_step = hn::Add(hn::Mul(ahead, x), hn::Mul(left, y));
      const F v_step = hn::Sub(hn::Mul(left, x), hn::Mul(ahead, y));
      for (std::size_t r = rows.begin; r < rows.end; ++r) {
        const std::size_t at = (r - band) * kBlock + i;
        const F scale = set(scales[r]);
        const W mask = set(masks[r]);
        const W u = hn::And(rounded(hn::Add(hn::Mul(u_step, scale), set(us[r]))), mask);
        const W v = hn::And(rounded(hn::Add(hn::Mul(v_step, scale), set(vs[r]))), mask);
        put<kMasked>(hn::Add(hn::Add(hn::Mul(u, set(strides[r])), v), set(firsts[r])), i, to.texel + at);
        if constexpr (!kIsLit) put<kMasked>(set(static_cast<std::uint32_t>(kTexelOne)), i, to.light + at);
        put<kMasked>(set(tint), i, to.tint + at);
      }
    });
  }

  template <bool kMasked>
  void shade_ceiling(const Stretch& rows) {
    const SurfaceMaterial& look = place_.ceiling_material;
    fill({pattern_of(look), place_.ceiling - view_.height}, rows, work_.others);
    shade_level<kMasked>(work_.others, {1.0, 0.0}, tint_of(look), rows);
  }

  // The top or the bottom of a solid, its texture along its longer side.
  template <bool kMasked>
  void shade_face(const Surface& surface, const Stretch& rows) {
    const Candidate& c = *surface.candidate;
    const bool is_top = surface.kind == Surface::Kind::top;
    const SurfaceMaterial look =
        is_top ? top_material(*c.visible, colour_of(c)) : bottom_material(*c.visible, colour_of(c));
    const Side& a = (*c.sides)[0];
    const Side& b = (*c.sides)[3];
    const Vec2 axis = c.outline.is_disc ? Vec2{1.0, 0.0} : a.length >= b.length ? a.axis : -1.0 * b.axis;
    fill({pattern_of(look), is_top ? c.high : c.low, c.visible->solid.center, axis}, rows, work_.others);
    shade_level<kMasked>(work_.others, axis, tint_of(look), rows);
  }

  // The floor of a region, or outside of all.
  template <bool kMasked>
  void shade_floor(std::size_t region, const Stretch& rows) {
    const SurfaceMaterial& look = region < place_.floors.size() ? place_.floors[region].floor : place_.outside_floor;
    LevelRows& level = work_.floors[static_cast<std::size_t>(pattern_of(look))];
    if (!level.is_known) {
      fill({pattern_of(look), -view_.height}, {0, static_cast<std::size_t>(rows_.count)}, level);
      level.is_known = true;
    }
    shade_level<kMasked, true>(level, {1.0, 0.0}, tint_of(look), rows);
    light_floor<kMasked>(rows);
    if (place_.is_open) veil_floor(rows);
  }

  template <bool kMasked>
  HWY_INLINE void light_floor(const Stretch& rows) {
    const std::size_t band = band_;
    constexpr double kPerMetre = 256.0 / FloorLight::kCell;
    const FloorLight& light = place_.light;
    const F last_x = set(256.0F * static_cast<float>(light.width - 1));
    const F last_y = set(256.0F * static_cast<float>(light.height - 1));
    const F eye_x = set(kPerMetre * (view_.eye.x - light.origin.x));
    const F eye_y = set(kPerMetre * (view_.eye.y - light.origin.y));
    const float* HWY_RESTRICT depths = rows_.below.data();
    std::uint32_t* HWY_RESTRICT lights = work_.light.data();
    std::uint32_t* HWY_RESTRICT cells = work_.cell.data();
    std::uint32_t* HWY_RESTRICT within = work_.within.data();
    for_lanes([&](std::size_t i) HWY_ATTR {
      const F x_step = hn::Mul(load(&columns_.x[i]), set(kPerMetre));
      const F y_step = hn::Mul(load(&columns_.y[i]), set(kPerMetre));
      const F zero = set(0.0F);
      for (std::size_t r = rows.begin; r < rows.end; ++r) {
        const F depth = set(depths[r]);
        const F x = hn::Add(eye_x, hn::Mul(depth, x_step));
        const F y = hn::Add(eye_y, hn::Mul(depth, y_step));
        const W at_x = whole(hn::Min(hn::Max(x, zero), last_x));
        const W at_y = whole(hn::Min(hn::Max(y, zero), last_y));
        const std::size_t at = (r - band) * kBlock + i;
        const W line = hn::ShiftLeftSame(hn::ShiftRight<8>(at_y), light.line_bits);
        store(hn::Add(line, hn::ShiftRight<8>(at_x)), cells + at);
        store(hn::Or(hn::ShiftLeft<16>(hn::And(at_x, set(255U))), hn::And(at_y, set(255U))), within + at);
      }
    });
    const std::uint32_t* HWY_RESTRICT table = light.cells.data();
    const std::uint32_t plain = plain_of(detail_);
    look_up(table, cells + place_of(rows.begin), (rows.end - rows.begin) * kBlock);
    for_painted<kMasked>([&](std::size_t i) HWY_ATTR {
      for (std::size_t r = rows.begin; r < rows.end; ++r) {
        const std::size_t at = (r - band) * kBlock + i;
        const W places = load(within + at);
        W found = interpolate(load(cells + at), hn::ShiftRight<16>(places), hn::And(places, set(255U)));
        if (detail_ < kWhole) found = hn::ShiftRight<8>(hn::Add(hn::Mul(found, set(detail_)), set(plain)));
        if (place_.is_open) {
          const F clear = set(1.0F - rows_.haze[r]);
          found = byte(hn::Mul(hn::ConvertTo(Floats(), hn::BitCast(Ints(), found)), clear));
        }
        put<kMasked>(found, i, lights + at);
      }
    });
  }

  // Interpolates between the four bytes of a cell by x and y, in 1/256. Two bytes at a time share a word.
  static HWY_INLINE W interpolate(W cell, W x, W y) {
    const W two_bytes = set(0x00FF00FFU);
    const W one = set(256U);
    const W left = hn::And(cell, two_bytes);
    const W right = hn::And(hn::ShiftRight<8>(cell), two_bytes);
    const W both = hn::Add(hn::Mul(left, hn::Sub(one, x)), hn::Mul(right, x));
    const W low = hn::And(both, set(0xFFFFU));
    const W high = hn::ShiftRight<16>(both);
    const W sum = hn::Add(hn::Mul(low, hn::Sub(one, y)), hn::Mul(high, y));
    return hn::ShiftRight<16>(hn::Add(sum, set(0x8000U)));
  }

  // Far away the ground is lost in haze.
  void veil_floor(const Stretch& rows) {
    const Colour sky = sky_colour(0.0F);
    const Colour gain = shading_.gain;
    const Colour horizon{gain.b * sky.b, gain.g * sky.g, gain.r * sky.r};
    for_lanes([&](std::size_t i) HWY_ATTR {
      for (std::size_t r = rows.begin; r < rows.end; ++r) {
        const float haze = rows_.haze[r];
        const W veil = set(view::pack({haze * horizon.b, haze * horizon.g, haze * horizon.r}));
        put<true>(veil, i, &work_.veil[place_of(r) + i]);
      }
    });
  }

  enum class Cover : std::uint8_t { clouds, hills };

  // Where one looks along the ground for ever.
  template <bool kMasked>
  void shade_nothing(const Stretch& rows) {
    const std::uint32_t tint = view::pack(sky_colour(0.0F));
    for_lanes([&](std::size_t i) HWY_ATTR {
      for (std::size_t r = rows.begin; r < rows.end; ++r) put_plain<kMasked>(set(tint), i, place_of(r) + i);
    });
  }

  // A colour that is its own light.
  template <bool kMasked>
  HWY_INLINE void put_plain(W tint, std::size_t i, std::size_t at) {
    put<kMasked>(tint, i, &work_.tint[at]);
    put<kMasked>(set(static_cast<std::uint32_t>(kOneTexel)), i, &work_.texel[at]);
    put<kMasked>(set(static_cast<std::uint32_t>(kTexelOne)), i, &work_.light[at]);
  }

  // The sky, and what covers it.
  template <bool kMasked>
  void shade_sky(Cover cover, const Stretch& rows) {
    const std::size_t band = band_;
    Lanes<float> share;
    for (std::size_t i = 0; i < kBlock; ++i) {
      share[i] = sun_share({static_cast<double>(columns_.x[i]), static_cast<double>(columns_.y[i])});
    }
    const Colour own = cover == Cover::hills ? kHills : cloud_material().colour;
    LevelRows& level = work_.others;
    if (cover == Cover::clouds) fill({Material::sky, kCloudHeight}, rows, level);
    const std::vector<std::uint8_t>& texels = tiles();
    for_lanes([&](std::size_t i) HWY_ATTR {
      const F glow = load(&share[i]);
      for (std::size_t r = rows.begin; r < rows.end; ++r) {
        F hidden = set(kHillCover);
        if (cover == Cover::clouds) {
          const F scale = set(level.scale[r]);
          const W mask = set(level.mask[r]);
          const W u = hn::And(rounded(hn::Add(hn::Mul(load(&columns_.x[i]), scale), set(level.u[r]))), mask);
          const W v = hn::And(rounded(hn::Add(hn::Mul(load(&columns_.y[i]), scale), set(level.v[r]))), mask);
          Lanes<std::uint32_t> place;
          store(hn::Add(hn::Add(hn::Mul(u, set(level.stride[r])), v), set(level.first[r])), place.data());
          for (std::size_t k = 0; k < hn::Lanes(Floats()); ++k) place[k] = texels[place[k]];
          const F bright = hn::ConvertTo(Floats(), hn::BitCast(Ints(), load(place.data())));
          hidden = hn::Mul(bright, set(1.0F / kTexelOne));
        }
        const auto channel = [&](std::size_t k, float covering) HWY_ATTR {
          const F lit = hn::Add(set(rows_.sky[k][r]), hn::Mul(set(rows_.glow[k][r]), glow));
          return hn::Add(lit, hn::Mul(hn::Sub(set(covering), lit), hidden));
        };
        const std::size_t at = (r - band) * kBlock + i;
        put_plain<kMasked>(pack(channel(0, own.b), channel(1, own.g), channel(2, own.r)), i, at);
      }
    });
  }

  // A wall's tint in a picture of less detail.
  std::uint32_t tint_of_less(std::uint32_t tint, std::uint32_t plain) const {
    std::uint32_t mixed = 0;
    for (const unsigned shift : {0U, 8U, 16U}) {
      const std::uint32_t sum = (tint >> shift & 255U) * detail_ + (plain >> shift & 255U) * (kWhole - detail_) + 128U;
      mixed |= (sum >> 8U) << shift;
    }
    return mixed;
  }
  Material pattern_of(const SurfaceMaterial& look) const {
    std::optional<Material>& pattern = work_.patterns[static_cast<std::size_t>(look.material)];
    if (!pattern) pattern = view::pattern_of(shading_.texture, look.material);
    return *pattern;
  }
  Colour colour_of(const Candidate& c) const {
    if (c.solid < 0) return c.visible->colour;
    std::optional<Colour>& colour = work_.colours[c.number];
    if (!colour) colour = place_.colour(shading_, static_cast<std::size_t>(c.solid));
    return *colour;
  }

  // An upright surface, where the columns meet it.
  void make_ready(Surface& surface) {
    surface.is_ready = true;
    const Candidate& c = *surface.candidate;
    if (c.outline.is_disc) return intersect_round(surface);
    bool is_first = true;
    for (std::size_t face = 0; face < 4; ++face) {
      const auto number = static_cast<float>(face);
      if (std::ranges::count(std::span(surface.face).first(kBlock), number) == 0) continue;
      if (surface.decor && static_cast<float>(surface.decor->face) != number) continue;
      intersect_flat(surface, face, is_first);
      is_first = false;
    }
  }

  void intersect_flat(Surface& surface, std::size_t face, bool is_first) {
    const Candidate& c = *surface.candidate;
    const Side& side = (*c.sides)[face];
    const Vec2 from = view_.eye - side.corner;
    const bool is_wall = c.visible->id == kWallId && c.solid >= 0 && surface.kind == Surface::Kind::side;
    SurfaceMaterial look = side.look;
    if (surface.kind == Surface::Kind::skirting) {
      look = skirting_material(side.normal);
    } else if (surface.decor) {
      look = surface.decor->look;
    } else if (!is_wall) {
      look.colour = colour_of(c);
    }
    const auto tints =
        is_wall ? place_.tints_of(static_cast<std::size_t>(c.solid), face) : std::span<const std::uint32_t>();
    const std::uint32_t tint = is_wall ? 0 : tint_of(look);
    for_lanes([&](std::size_t i) HWY_ATTR {
      const F slope = load(&columns_.slope[i]);
      const F depth = load(&surface.depth[i]);
      const auto part = [&](Vec2 axis) HWY_ATTR {
        return hn::Add(set(dot(view_.forward, axis)), hn::Mul(slope, set(dot(view_.left, axis))));
      };
      const F along = hn::Add(set(dot(from, side.axis)), hn::Mul(depth, part(side.axis)));
      const F facing = hn::Neg(hn::Mul(part(side.normal), load(&columns_.inverse_norm[i])));
      const M here = is_first ? hn::Eq(depth, depth) : hn::Eq(load(&surface.face[i]), set(static_cast<float>(face)));
      W colour = set(tint);
      if (is_wall) {
        Lanes<std::uint32_t> found;
        const F last = set(static_cast<float>(tints.size() - 1));
        const F bin = hn::Min(hn::Max(hn::Mul(along, set(1.0 / kTintStep)), set(0.0F)), last);
        store(whole(bin), found.data());
        for (std::size_t k = 0; k < hn::Lanes(Floats()); ++k) found[k] = tints[found[k]];
        if (detail_ < kWhole) {
          const std::uint32_t plain = tint_of({look.material, place_.plain_wall(), look.light});
          for (std::size_t k = 0; k < hn::Lanes(Floats()); ++k) found[k] = tint_of_less(found[k], plain);
        }
        colour = load(found.data());
      }
      cover(surface, look, along, facing, colour, here, i);
    });
  }

  void intersect_round(Surface& surface) {
    const Candidate& c = *surface.candidate;
    const scene::Solid& solid = c.visible->solid;
    SurfaceMaterial look = (*c.sides)[0].look;
    look.colour = colour_of(c);
    const Vec2 from = view_.eye - solid.center;
    for_lanes([&](std::size_t i) HWY_ATTR {
      const F depth = load(&surface.depth[i]);
      const F x = load(&columns_.x[i]);
      const F y = load(&columns_.y[i]);
      const F zero = set(0.0F);
      const F scale = set(1.0 / solid.radius);
      const F nx = hn::Mul(hn::Add(set(from.x), hn::Mul(depth, x)), scale);
      const F ny = hn::Mul(hn::Add(set(from.y), hn::Mul(depth, y)), scale);
      const F ahead = hn::Div(ny, hn::Add(hn::Abs(nx), hn::Abs(ny)));
      const F half_turn = hn::IfThenElse(hn::Ge(ny, zero), set(2.0F), set(-2.0F));
      const F quarters = hn::IfThenElse(hn::Ge(nx, zero), ahead, hn::Sub(half_turn, ahead));
      const F along = hn::Mul(quarters, set(0.5 * exact::kPi * solid.radius));
      const F cosine = hn::Add(hn::Mul(x, nx), hn::Mul(y, ny));
      const F facing = hn::Neg(hn::Mul(cosine, load(&columns_.inverse_norm[i])));
      const F sunward = hn::Add(hn::Mul(nx, set(kSunward.x)), hn::Mul(ny, set(kSunward.y)));
      const F light = hn::Mul(set(look.light), hn::Add(set(kShade), hn::Mul(set(kSunShade), sunward)));
      const W tint = pack(hn::Mul(light, set(look.colour.b)), hn::Mul(light, set(look.colour.g)),
                          hn::Mul(light, set(look.colour.r)));
      cover(surface, look, along, facing, tint, hn::Eq(depth, depth), i);
    });
  }

  // What pixels need of a surface in some of its columns. `along` it is where they meet it, and they look at it with
  // `facing`, the cosine of the angle of incidence.
  HWY_INLINE void cover(Surface& surface, const SurfaceMaterial& look, F along, F facing, W tint, M here,
                        std::size_t i) const {
    constexpr double kPixel = 0.7;
    const Material pattern = pattern_of(look);
    const double per_metre = 1.0 / spec(pattern).tile_size;
    const double left = surface.decor ? surface.decor->begin : 0.0;
    const double low = surface.decor ? surface.decor->low : 0.0;
    const F depth = load(&surface.depth[i]);
    const F size = set(kPixel / view_.camera.fx * kTileSide * per_metre);
    const F side = level_side(hn::Div(hn::Mul(depth, size), hn::Max(facing, set(0.35F))));
    const F half = set(0.5F);
    const F u = hn::Mul(hn::Mul(hn::Sub(along, set(left)), set(per_metre)), side);
    const W mask = whole(hn::Sub(side, set(1.0F)));
    const W line = hn::Mul(hn::And(rounded(hn::Sub(u, half)), mask), stride_of(side));
    const auto keep = [&](auto value, auto* to) HWY_ATTR {
      const hn::DFromV<decltype(value)> d;
      store(hn::IfThenElse(hn::RebindMask(d, here), value, load(to)), to);
    };
    keep(hn::Add(first_of(pattern, side), line), &surface.line[i]);
    keep(mask, &surface.mask[i]);
    keep(tint, &surface.tint[i]);
    keep(hn::Sub(hn::Mul(set(per_metre * (view_.height - low)), side), half), &surface.v[i]);
    keep(hn::Mul(hn::Mul(depth, set(per_metre)), side), &surface.v_step[i]);
    const float detail = shading_.detail;
    const float foot = (1.0F - detail) + detail * (look.foot + look.rise * static_cast<float>(view_.height));
    keep(set(kTexelOne * foot), &surface.foot[i]);
    keep(hn::Mul(depth, set(kTexelOne * (detail * look.rise))), &surface.rise[i]);
  }

  const Place& place_;
  const View& view_;
  const Rows& rows_;
  const Shading& shading_;
  const std::uint32_t detail_;
  const Columns& columns_;
  BlockWork& work_;
  static constexpr unsigned kAll = (1U << kBlock) - 1U;
  std::size_t band_ = 0;  // its first row
  Lanes<std::int32_t> mask_;
};

}  // namespace threewe::sim::view::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
