// What every file of bindings shares. One file per C++ module; each `init_*` adds that module's names to threewe._core.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/vector.h>

#include <fmt/format.h>

#include "threewe/core/errors.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/core/time.hpp"

namespace nb = nanobind;
using namespace nb::literals;

void init_errors(nb::module_& m);
void init_core(nb::module_& m);
void init_hardware(nb::module_& m);
void init_scene(nb::module_& m);
void init_map(nb::module_& m);
void init_slam(nb::module_& m);
void init_sim(nb::module_& m);
void init_backend(nb::module_& m);
void init_calibration(nb::module_& m);
void init_ros2(nb::module_& m);
void init_language(nb::module_& m);
void init_plugin(nb::module_& m);
void init_nav(nb::module_& m);
void init_robot(nb::module_& m);
void init_record(nb::module_& m);
void init_vision(nb::module_& m);
void init_policy(nb::module_& m);
void init_agent(nb::module_& m);
void init_env(nb::module_& m);
void init_benchmark(nb::module_& m);
void init_export(nb::module_& m);

/// While C++ works, other Python threads run.
using WithoutGil = nb::call_guard<nb::gil_scoped_release>;

/// A read-only view of C++ memory as a numpy array; a property that returns it keeps its owner alive.
template <typename T, typename... Shape>
using ArrayView = nb::ndarray<nb::numpy, const T, Shape...>;

/// `value` seconds. Throws ContractError naming the argument unless it is finite, in [0, 10^9].
inline threewe::Duration seconds(std::string_view name, double value) {
  if (!(value >= 0.0 && value <= 1e9)) {
    throw threewe::ContractError(fmt::format("{} must lie in [0, 1e+09] s, got {}", name, value));
  }
  return threewe::from_seconds(value);
}

namespace nanobind::detail {

/// A point is a pair of floats in Python.
template <>
struct type_caster<threewe::Vec2> {
  NB_TYPE_CASTER(threewe::Vec2, const_name("tuple[float, float]"))

  bool from_python(handle source, std::uint8_t flags, cleanup_list* cleanup) noexcept {
    if (!PySequence_Check(source.ptr()) || PySequence_Size(source.ptr()) != 2) {
      PyErr_Clear();
      return false;
    }
    return load(source, 0, value.x, flags, cleanup) && load(source, 1, value.y, flags, cleanup);
  }
  static handle from_cpp(const threewe::Vec2& point, rv_policy, cleanup_list*) noexcept {
    return nanobind::make_tuple(point.x, point.y).release();
  }

 private:
  static bool load(handle source, Py_ssize_t index, double& to, std::uint8_t flags, cleanup_list* cleanup) noexcept {
    const object item = steal(PySequence_GetItem(source.ptr(), index));
    make_caster<double> caster;
    if (!item.is_valid() || !caster.from_python(item, flags, cleanup)) {
      PyErr_Clear();
      return false;
    }
    to = caster.value;
    return true;
  }
};

/// Times are float seconds in Python.
template <>
struct type_caster<threewe::Duration> {
  NB_TYPE_CASTER(threewe::Duration, const_name("float"))

  bool from_python(handle source, std::uint8_t flags, cleanup_list* cleanup) noexcept {
    make_caster<double> caster;
    if (!caster.from_python(source, flags, cleanup) || !(std::abs(caster.value) <= 1e9)) return false;
    value = threewe::from_seconds(caster.value);
    return true;
  }
  static handle from_cpp(threewe::Duration duration, rv_policy, cleanup_list*) noexcept {
    return PyFloat_FromDouble(threewe::to_seconds(duration));
  }
};

}  // namespace nanobind::detail
