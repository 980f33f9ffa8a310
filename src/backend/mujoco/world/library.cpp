#include "backend/mujoco/world/library.hpp"

#include <mutex>
#include <optional>
#include <utility>

#include <dlfcn.h>
#include <fmt/format.h>

#include "backend/mujoco/mujoco.hpp"
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
  find(handle, found.mjs_addBody, "mjs_addBody");
  find(handle, found.mjs_addGeom, "mjs_addGeom");
  find(handle, found.mjs_asGeom, "mjs_asGeom");
  find(handle, found.mjs_findBody, "mjs_findBody");
  find(handle, found.mjs_findElement, "mjs_findElement");
  find(handle, found.mjs_setName, "mjs_setName");
  find(handle, found.mj_deleteSpec, "mj_deleteSpec");
  find(handle, found.mj_copyModel, "mj_copyModel");
  find(handle, found.mj_deleteModel, "mj_deleteModel");
  find(handle, found.mj_makeData, "mj_makeData");
  find(handle, found.mj_deleteData, "mj_deleteData");
  find(handle, found.mj_resetData, "mj_resetData");
  find(handle, found.mj_name2id, "mj_name2id");
  find(handle, found.mj_id2name, "mj_id2name");
  find(handle, found.mj_step1, "mj_step1");
  find(handle, found.mj_step2, "mj_step2");
  find(handle, found.mj_ray, "mj_ray");
  find(handle, found.mj_stateSize, "mj_stateSize");
  find(handle, found.mj_getState, "mj_getState");
  find(handle, found.mj_setState, "mj_setState");
  find(handle, found.mj_kinematics, "mj_kinematics");
  find(handle, found.mjv_defaultCamera, "mjv_defaultCamera");
  find(handle, found.mjv_defaultOption, "mjv_defaultOption");
  find(handle, found.mjv_defaultScene, "mjv_defaultScene");
  find(handle, found.mjv_makeScene, "mjv_makeScene");
  find(handle, found.mjv_freeScene, "mjv_freeScene");
  find(handle, found.mjv_initGeom, "mjv_initGeom");
  find(handle, found.mjv_updateScene, "mjv_updateScene");
  find(handle, found.mjr_defaultContext, "mjr_defaultContext");
  find(handle, found.mjr_makeContext, "mjr_makeContext");
  find(handle, found.mjr_resizeOffscreen, "mjr_resizeOffscreen");
  find(handle, found.mjr_setBuffer, "mjr_setBuffer");
  find(handle, found.mjr_render, "mjr_render");
  find(handle, found.mjr_readPixels, "mjr_readPixels");
  find(handle, found.mju_warningText, "mju_warningText");
  // what MuJoCo's own Python package uses, for the same purpose
  find(handle, found.set_log_handler, "_mjPRIVATE_setTlsLogHandler");
  return found;
}

// Thrown through MuJoCo's own functions, which hold nothing that would have to be given back.
void throw_error(const mjLogMessage* message) {
  if (message->level == mjLOG_ERROR) throw ContractError(fmt::format("MuJoCo: {}", message->subject));
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

ErrorsThrown::ErrorsThrown() : before_(library().set_log_handler(throw_error)) {}

ErrorsThrown::~ErrorsThrown() { library().set_log_handler(before_); }

}  // namespace threewe::backend::mujoco
