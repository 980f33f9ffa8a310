#include "backend/mujoco/world/library.hpp"

#include <mutex>
#include <optional>
#include <utility>

#include <dlfcn.h>
#include <fmt/format.h>

#include "threewe/backend/mujoco/mujoco.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::backend::mujoco {
namespace {

struct Loaded {
  std::mutex mutex;
  std::string path = fmt::format("libmujoco.so.{}", kVersion);
  std::optional<Library> library;
};

Loaded& loaded() {
  static Loaded instance;
  return instance;
}

[[noreturn]] void fail(const std::string& what) {
  throw ConfigError(fmt::format("backend 'mujoco' needs MuJoCo {}: {}\n{}", kVersion, what, kInstall));
}

template <typename Function>
void find(void* handle, Function& function, const char* name) {
  function = reinterpret_cast<Function>(::dlsym(handle, name));
  if (function == nullptr) fail(fmt::format("the library has no {}", name));
}

Library load(const std::string& path) {
  // the same file that Python's package loads, if it does: one library in the process
  void* handle = ::dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (handle == nullptr) fail(::dlerror());

  Library found{};
  find(handle, found.mj_version, "mj_version");
  if (const int version = found.mj_version(); version != mjVERSION_HEADER) {
    fail(fmt::format("{} is version {}", path, version));
  }
  find(handle, found.mj_parseXMLString, "mj_parseXMLString");
  find(handle, found.mj_compile, "mj_compile");
  find(handle, found.mjs_getError, "mjs_getError");
  find(handle, found.mjs_firstElement, "mjs_firstElement");
  find(handle, found.mjs_nextElement, "mjs_nextElement");
  find(handle, found.mjs_asSensor, "mjs_asSensor");
  find(handle, found.mjs_delete, "mjs_delete");
  find(handle, found.mj_deleteSpec, "mj_deleteSpec");
  find(handle, found.mj_deleteModel, "mj_deleteModel");
  find(handle, found.mj_makeData, "mj_makeData");
  find(handle, found.mj_deleteData, "mj_deleteData");
  find(handle, found.mj_resetData, "mj_resetData");
  find(handle, found.mj_name2id, "mj_name2id");
  find(handle, found.mj_id2name, "mj_id2name");
  find(handle, found.mj_fwdPosition, "mj_fwdPosition");
  find(handle, found.mj_step1, "mj_step1");
  find(handle, found.mj_step2, "mj_step2");
  find(handle, found.mj_ray, "mj_ray");
  find(handle, found.mj_stateSize, "mj_stateSize");
  find(handle, found.mj_getState, "mj_getState");
  find(handle, found.mj_setState, "mj_setState");
  return found;
}

}  // namespace

void set_library(std::string path) {
  const std::scoped_lock lock(loaded().mutex);
  loaded().path = std::move(path);
}

const Library& library() {
  const std::scoped_lock lock(loaded().mutex);
  if (!loaded().library) loaded().library = load(loaded().path);
  return *loaded().library;
}

}  // namespace threewe::backend::mujoco
