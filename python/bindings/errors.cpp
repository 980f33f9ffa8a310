// C++ exceptions become the Python exceptions of the same name in threewe.errors: the one place for it.
#include <cstring>
#include <exception>

#include "bindings.hpp"

namespace {

using namespace threewe;

void raise(const char* name, const std::exception& error) {
  const nb::object type = nb::module_::import_("threewe.errors").attr(name);
  const char* const what = error.what();  // may quote bytes of a file, which are any
  const auto size = static_cast<Py_ssize_t>(std::strlen(what));
  const nb::object text = nb::steal(PyUnicode_DecodeUTF8(what, size, "replace"));
  PyErr_SetObject(type.ptr(), text.ptr());
}

void translate(const std::exception_ptr& thrown, void* /*payload*/) {
  try {
    std::rethrow_exception(thrown);
  } catch (const EmergencyStopError& error) {
    raise("EmergencyStopError", error);
  } catch (const SafetyError& error) {
    raise("SafetyError", error);
  } catch (const ConnectionError& error) {
    raise("ConnectionError", error);
  } catch (const HardwareError& error) {
    raise("HardwareError", error);
  } catch (const NavigationError& error) {
    raise("NavigationError", error);
  } catch (const TimeoutError& error) {
    raise("TimeoutError", error);
  } catch (const ContractError& error) {
    raise("ContractError", error);
  } catch (const RecordingError& error) {
    raise("RecordingError", error);
  } catch (const ConfigError& error) {
    raise("ConfigError", error);
  } catch (const ThreeweError& error) {
    raise("ThreeweError", error);
  }
}

}  // namespace

void init_errors(nb::module_& /*m*/) { nb::register_exception_translator(translate); }
