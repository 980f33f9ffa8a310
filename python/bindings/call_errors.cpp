// Calls with arguments of wrong types get one clear error: threewe._calls says which argument, and what would be right.
//
// nanobind reports them by PyErr_SetString with a text that lists the signatures and the types that were given. The
// linker sends that call here (`--wrap`, see python/CMakeLists.txt): the one place through which all of them pass,
// constructors too, and which costs nothing as long as calls are right. The types alone do not say that a string holds
// half of a surrogate pair, which nanobind cannot turn into UTF-8: the call that fails at it is wrapped, too.
#include <string>
#include <string_view>
#include <utility>

#include "bindings.hpp"

namespace {

constexpr std::string_view kFromNanobind = "(): incompatible function arguments. The following argument types";

thread_local std::string not_encodable;  // the last string that was no UTF-8, as Python writes it; of this call or none

void raise_explained(const char* text) {
  const nb::object explain = nb::module_::import_("threewe._calls").attr("explain");
  const nb::object error = explain(text, std::exchange(not_encodable, {}));
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

const char* __real_PyUnicode_AsUTF8AndSize(PyObject* text, Py_ssize_t* size);  // NOLINT

const char* __wrap_PyUnicode_AsUTF8AndSize(PyObject* text, Py_ssize_t* size);   // NOLINT
const char* __wrap_PyUnicode_AsUTF8AndSize(PyObject* text, Py_ssize_t* size) {  // NOLINT
  const char* const bytes = __real_PyUnicode_AsUTF8AndSize(text, size);
  if (bytes == nullptr && PyUnicode_Check(text)) {
    const nb::error_scope kept;  // the error that says so
    const nb::object shown = nb::steal(PyObject_ASCII(text));
    if (shown.is_valid()) not_encodable = __real_PyUnicode_AsUTF8AndSize(shown.ptr(), nullptr);
  }
  return bytes;
}
}
