// A vector holds one quantity of as many robots as it has lanes. States and constants lie in memory robot by robot, and
// are taken over four numbers at a time: four of each robot become four vectors. For kernels, after highway-inl.hpp.
#if defined(THREEWE_SIM_ROWS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef THREEWE_SIM_ROWS_INL
#undef THREEWE_SIM_ROWS_INL
#else
#define THREEWE_SIM_ROWS_INL
#endif

#include <array>
#include <cstddef>

HWY_BEFORE_NAMESPACE();
namespace threewe::sim::kernel::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Doubles = hn::CappedTag<double, 8>;
using V = hn::Vec<Doubles>;
constexpr std::size_t kLanes = hn::MaxLanes(Doubles());

// Four numbers in a row.
constexpr std::size_t kRow = 4 * sizeof(double);
// Where something of each robot begins in memory.
using Places = std::array<std::byte*, kLanes>;

#if HWY_TARGET != HWY_SCALAR
using Pair = hn::Full128<double>;

// Pairs of every second robot from `robot` on, `first` bytes behind its place.
HWY_INLINE V load_pairs(const Places& places, std::size_t robot, std::size_t first) {
  const auto pair = [&](std::size_t i) {
    return hn::LoadU(Pair(), reinterpret_cast<const double*>(places[robot + 2 * i] + first));
  };
#if HWY_MAX_BYTES >= 64
  const hn::Half<Doubles> half;
  return hn::Combine(Doubles(), hn::Combine(half, pair(3), pair(2)), hn::Combine(half, pair(1), pair(0)));
#elif HWY_MAX_BYTES >= 32
  return hn::Combine(Doubles(), pair(1), pair(0));
#else
  return pair(0);
#endif
}

HWY_INLINE void store_pairs(V pairs, const Places& places, std::size_t robot, std::size_t first) {
  const auto store = [&](hn::Vec<Pair> pair, std::size_t i) {
    hn::StoreU(pair, Pair(), reinterpret_cast<double*>(places[robot + 2 * i] + first));
  };
#if HWY_MAX_BYTES >= 64
  const hn::Half<Doubles> half;
  const auto low = hn::LowerHalf(half, pairs);
  const auto high = hn::UpperHalf(half, pairs);
  store(hn::LowerHalf(Pair(), low), 0);
  store(hn::UpperHalf(Pair(), low), 1);
  store(hn::LowerHalf(Pair(), high), 2);
  store(hn::UpperHalf(Pair(), high), 3);
#elif HWY_MAX_BYTES >= 32
  store(hn::LowerHalf(Pair(), pairs), 0);
  store(hn::UpperHalf(Pair(), pairs), 1);
#else
  store(pairs, 0);
#endif
}
#endif

// Four numbers of every robot, `first` bytes behind its place.
HWY_INLINE void gather(const Places& places, std::size_t first, V& a, V& b, V& c, V& d) {
#if HWY_TARGET == HWY_SCALAR
  const auto* row = reinterpret_cast<const double*>(places[0] + first);
  a = hn::LoadU(Doubles(), row);
  b = hn::LoadU(Doubles(), row + 1);
  c = hn::LoadU(Doubles(), row + 2);
  d = hn::LoadU(Doubles(), row + 3);
#else
  const V ab_even = load_pairs(places, 0, first);
  const V ab_odd = load_pairs(places, 1, first);
  const V cd_even = load_pairs(places, 0, first + kRow / 2);
  const V cd_odd = load_pairs(places, 1, first + kRow / 2);
  a = hn::InterleaveLower(Doubles(), ab_even, ab_odd);
  b = hn::InterleaveUpper(Doubles(), ab_even, ab_odd);
  c = hn::InterleaveLower(Doubles(), cd_even, cd_odd);
  d = hn::InterleaveUpper(Doubles(), cd_even, cd_odd);
#endif
}

// The way back.
HWY_INLINE void scatter(const Places& places, std::size_t first, V a, V b, V c, V d) {
#if HWY_TARGET == HWY_SCALAR
  auto* row = reinterpret_cast<double*>(places[0] + first);
  hn::StoreU(a, Doubles(), row);
  hn::StoreU(b, Doubles(), row + 1);
  hn::StoreU(c, Doubles(), row + 2);
  hn::StoreU(d, Doubles(), row + 3);
#else
  store_pairs(hn::InterleaveLower(Doubles(), a, b), places, 0, first);
  store_pairs(hn::InterleaveUpper(Doubles(), a, b), places, 1, first);
  store_pairs(hn::InterleaveLower(Doubles(), c, d), places, 0, first + kRow / 2);
  store_pairs(hn::InterleaveUpper(Doubles(), c, d), places, 1, first + kRow / 2);
#endif
}

// Of plain data; what is const is only read.
template <class T>
HWY_INLINE std::byte* bytes_of(const T& data) {
  return reinterpret_cast<std::byte*>(const_cast<T*>(&data));
}

}  // namespace threewe::sim::kernel::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
