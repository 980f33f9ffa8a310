// Enumerations whose members are their names too, as in `result.reason == "reached"`.
#pragma once

#include "bindings.hpp"

/// An enum.StrEnum of a C++ enumeration.
template <class E>
class NamedEnum : public nb::enum_<E> {
 public:
  NamedEnum(nb::handle scope, const char* name, const char* doc = nullptr)
      : nb::enum_<E>(scope, name, nb::is_str(), doc) {
    this->def("__str__", [](nb::handle member) { return nb::str(member.attr("value")); });
  }
  NamedEnum& value(const char* name, E member, const char* doc = nullptr) {
    this->str_value(name, member, name, doc);
    return *this;
  }
};
