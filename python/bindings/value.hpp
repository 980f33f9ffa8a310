// What makes a C++ struct a value in Python: equality, a hash, and pickling, which copy.copy and copy.deepcopy use too.
#pragma once

#include <algorithm>
#include <functional>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <variant>

#include "bindings.hpp"
#include "fields.hpp"
#include "value_bytes.hpp"

namespace value {

/// Equal in all fields, as numbers are: NaN equals nothing.
template <class T>
bool equal(const T& a, const T& b);

template <class... T>
bool equal_fields(const std::tuple<T&...>& a, const std::tuple<T&...>& b) {
  return [&]<std::size_t... I>(std::index_sequence<I...>) {
    return (equal(std::get<I>(a), std::get<I>(b)) && ...);
  }(std::index_sequence_for<T...>{});
}

template <class T>
inline constexpr bool kIsRange = requires(const T& items) {
  items.begin();
  items.size();
};

template <class T>
bool equal(const T& a, const T& b) {
  if constexpr (kIsRange<T>) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const auto& x, const auto& y) { return equal(x, y); });
  } else if constexpr (requires { a.has_value(); }) {
    return a.has_value() == b.has_value() && (!a || equal(*a, *b));
  } else if constexpr (requires { a.valueless_by_exception(); }) {
    return a.index() == b.index() && std::visit(
                                         [&b](const auto& x) {
                                           using Which = std::remove_cvref_t<decltype(x)>;
                                           return equal(x, std::get<Which>(b));
                                         },
                                         a);
  } else if constexpr (std::is_same_v<T, threewe::Picture>) {
    return equal(a.image(), b.image());
  } else if constexpr (std::is_aggregate_v<T>) {
    return equal_fields(fields::of(a), fields::of(b));
  } else {
    return a == b;
  }
}

}  // namespace value

/// `nb::class_<T>(...).def(Value())`: a value, of whatever fields T has.
struct Value : nb::def_visitor<Value> {
  template <class Class, class... Extra>
  void execute(Class& bound, const Extra&...) {
    using T = typename Class::Type;
    bound
        .def(
            "__eq__", [](const T& a, const T& b) { return value::equal(a, b); }, nb::is_operator(),
            nb::sig("def __eq__(self, other: object) -> bool"))
        .def("__hash__",
             [](const T& a) {
               value::Writer writer(true);
               writer.put(a);
               return static_cast<Py_hash_t>(std::hash<std::string>{}(writer.bytes()));
             })
        .def("__getstate__",
             [](const T& a) {
               value::Writer writer;
               writer.put(a);
               return nb::bytes(writer.bytes().data(), writer.bytes().size());
             })
        .def("__setstate__", [](T& self, const nb::bytes& state) {
          value::Reader reader({state.c_str(), state.size()});
          T read = reader.get<T>();
          reader.finish();
          new (&self) T(std::move(read));
        });
  }
};
