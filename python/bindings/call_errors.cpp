// Calls with arguments of wrong types get one clear error: threewe._calls says which argument, and what would be right.
//
// nanobind reports them by PyErr_SetString with a text that lists the signatures and the types that were given. The
// linker sends that call here (`--wrap`, see python/CMakeLists.txt): the one place through which all of them pass,
// constructors too, and which costs nothing as long as calls are right.
#include <string_view>

#include "bindings.hpp"

namespace {

constexpr std::string_view kFromNanobind = "(): incompatible function arguments. The following argument types";

void raise_explained(const char* text) {
  const nb::object explain = nb::module_::import_("threewe._calls").attr("explain");
  const nb::object error = explain(text);
  PyErr_SetObject(error.type().ptr(), error.ptr());
}

}  // namespace

extern "C" {

void __real_PyErr_SetString(PyObject* type, const char* text);  // NOLINT: the linker's names

void __wrap_PyErr_SetString(PyObject* type, const char* text);   // NOLINT
void __wrap_PyErr_SetString(PyObject* type, const char* text) {  // NOLINT
  if (type == PyExc_TypeError && std::string_view(text).find(kFromNanobind) != std::string_view::npos) {
    try {
      raise_explained(text);
      return;
    } catch (...) {
      PyErr_Clear();  // as nanobind has it, then
    }
  }
  __real_PyErr_SetString(type, text);
}
}
