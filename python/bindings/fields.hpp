// The fields of plain structs, so that what is done with values (keep, compare) is written once for all of them.
#pragma once

#include <cstddef>
#include <optional>
#include <tuple>
#include <type_traits>
#include <utility>

namespace fields {

/// Stands for a field of any type but std::optional, which could be made of it in two ways.
struct Any {
  template <class T>
  constexpr operator T&() const noexcept;  // NOLINT(google-explicit-constructor): it stands for a value
};
struct AnyOptional {
  template <class T>
  constexpr operator std::optional<T>&() const noexcept;  // NOLINT(google-explicit-constructor)
};

/// How many fields an aggregate has whose fields can all be left out.
template <class T, class... Found>
consteval std::size_t count() {
  static_assert(std::is_aggregate_v<T>);
  if constexpr (requires { T{std::declval<const Found&>()..., std::declval<const Any&>()}; }) {
    return count<T, Found..., Any>();
  } else if constexpr (requires { T{std::declval<const Found&>()..., std::declval<const AnyOptional&>()}; }) {
    return count<T, Found..., AnyOptional>();
  } else {
    return sizeof...(Found);
  }
}

/// References to all fields of an aggregate, in order. A wrong count does not compile.
template <class T>
auto of(T& v) {
  constexpr std::size_t kCount = count<std::remove_const_t<T>>();
  static_assert(kCount >= 1 && kCount <= 16, "add a case below");
  if constexpr (kCount == 1) {
    auto& [a] = v;
    return std::tie(a);
  } else if constexpr (kCount == 2) {
    auto& [a, b] = v;
    return std::tie(a, b);
  } else if constexpr (kCount == 3) {
    auto& [a, b, c] = v;
    return std::tie(a, b, c);
  } else if constexpr (kCount == 4) {
    auto& [a, b, c, d] = v;
    return std::tie(a, b, c, d);
  } else if constexpr (kCount == 5) {
    auto& [a, b, c, d, e] = v;
    return std::tie(a, b, c, d, e);
  } else if constexpr (kCount == 6) {
    auto& [a, b, c, d, e, f] = v;
    return std::tie(a, b, c, d, e, f);
  } else if constexpr (kCount == 7) {
    auto& [a, b, c, d, e, f, g] = v;
    return std::tie(a, b, c, d, e, f, g);
  } else if constexpr (kCount == 8) {
    auto& [a, b, c, d, e, f, g, h] = v;
    return std::tie(a, b, c, d, e, f, g, h);
  } else if constexpr (kCount == 9) {
    auto& [a, b, c, d, e, f, g, h, i] = v;
    return std::tie(a, b, c, d, e, f, g, h, i);
  } else if constexpr (kCount == 10) {
    auto& [a, b, c, d, e, f, g, h, i, j] = v;
    return std::tie(a, b, c, d, e, f, g, h, i, j);
  } else if constexpr (kCount == 11) {
    auto& [a, b, c, d, e, f, g, h, i, j, k] = v;
    return std::tie(a, b, c, d, e, f, g, h, i, j, k);
  } else if constexpr (kCount == 12) {
    auto& [a, b, c, d, e, f, g, h, i, j, k, l] = v;
    return std::tie(a, b, c, d, e, f, g, h, i, j, k, l);
  } else if constexpr (kCount == 13) {
    auto& [a, b, c, d, e, f, g, h, i, j, k, l, m] = v;
    return std::tie(a, b, c, d, e, f, g, h, i, j, k, l, m);
  } else if constexpr (kCount == 14) {
    auto& [a, b, c, d, e, f, g, h, i, j, k, l, m, n] = v;
    return std::tie(a, b, c, d, e, f, g, h, i, j, k, l, m, n);
  } else if constexpr (kCount == 15) {
    auto& [a, b, c, d, e, f, g, h, i, j, k, l, m, n, o] = v;
    return std::tie(a, b, c, d, e, f, g, h, i, j, k, l, m, n, o);
  } else if constexpr (kCount == 16) {
    auto& [a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p] = v;
    return std::tie(a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p);
  }
}

}  // namespace fields
