// What numpy makes of a value.
#pragma once

#include <utility>

#include "bindings.hpp"

/// `nb::class_<T>(...).def(AsArray("(3,) float64: x, y, theta", view))`: `numpy.asarray(value)` is `view(self)`, an
/// array that shares the value's memory or, where `fresh`, has been made for the caller.
template <class View>
struct AsArray : nb::def_visitor<AsArray<View>> {
  AsArray(const char* what, View view_of, bool is_fresh = false) : doc(what), view(view_of), fresh(is_fresh) {}

  template <class Class, class... Extra>
  void execute(Class& bound, const Extra&...) {
    bound.def(
        "__array__",
        [view = view, fresh = fresh](nb::handle self, nb::handle dtype, nb::handle copy) {
          if (fresh && copy.is(nb::handle(Py_False))) {
            throw nb::value_error("Unable to avoid copy: this value is no array itself");
          }
          return nb::module_::import_("numpy").attr("array")(view(self), "dtype"_a = dtype, "copy"_a = copy);
        },
        "dtype"_a = nb::none(), nb::kw_only(), "copy"_a = nb::none(),
        nb::sig("def __array__(self, dtype: numpy.typing.DTypeLike | None = None, *, copy: bool | None = None) -> "
                "numpy.typing.NDArray[typing.Any]"),
        doc);
  }

  const char* doc;
  View view;
  bool fresh;
};

/// `numpy.asarray(value)` is refused, since it could be several: `which` names them.
struct NoArray : nb::def_visitor<NoArray> {
  explicit NoArray(const char* which_ones) : which(which_ones) {}

  template <class Class, class... Extra>
  void execute(Class& bound, const Extra&...) {
    bound.def(
        "__array__",
        [which = which](nb::handle self, const nb::args&, const nb::kwargs&) -> nb::object {
          const std::string name = nb::cast<std::string>(self.type().attr("__name__"));
          throw nb::type_error(fmt::format("{} holds several arrays: take {}", name, which).c_str());
        },
        nb::sig("def __array__(self, *args: object, **kwargs: object) -> typing.NoReturn"));
  }

  const char* which;
};
