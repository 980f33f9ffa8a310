// MuJoCo's functions, found in its library when they are first needed.
#pragma once

#include <string>

#include <mujoco/mujoco.h>

namespace threewe::backend::mujoco {

/// What we call of MuJoCo, under its own names.
struct Library {
  decltype(&::mj_version) mj_version;
  decltype(&::mj_parseXMLString) mj_parseXMLString;
  decltype(&::mj_compile) mj_compile;
  decltype(&::mjs_getError) mjs_getError;
  decltype(&::mjs_firstElement) mjs_firstElement;
  decltype(&::mjs_nextElement) mjs_nextElement;
  decltype(&::mjs_asSensor) mjs_asSensor;
  decltype(&::mjs_delete) mjs_delete;
  decltype(&::mjs_addBody) mjs_addBody;
  decltype(&::mjs_addGeom) mjs_addGeom;
  decltype(&::mjs_asGeom) mjs_asGeom;
  decltype(&::mjs_findBody) mjs_findBody;
  decltype(&::mjs_findElement) mjs_findElement;
  decltype(&::mjs_setName) mjs_setName;
  decltype(&::mj_deleteSpec) mj_deleteSpec;
  decltype(&::mj_copyModel) mj_copyModel;
  decltype(&::mj_deleteModel) mj_deleteModel;
  decltype(&::mj_makeData) mj_makeData;
  decltype(&::mj_deleteData) mj_deleteData;
  decltype(&::mj_resetData) mj_resetData;
  decltype(&::mj_name2id) mj_name2id;
  decltype(&::mj_id2name) mj_id2name;
  decltype(&::mj_step1) mj_step1;
  decltype(&::mj_step2) mj_step2;
  decltype(&::mj_ray) mj_ray;
  decltype(&::mj_stateSize) mj_stateSize;
  decltype(&::mj_getState) mj_getState;
  decltype(&::mj_setState) mj_setState;
  decltype(&::mj_kinematics) mj_kinematics;
  decltype(&::mjv_defaultCamera) mjv_defaultCamera;
  decltype(&::mjv_defaultOption) mjv_defaultOption;
  decltype(&::mjv_defaultScene) mjv_defaultScene;
  decltype(&::mjv_makeScene) mjv_makeScene;
  decltype(&::mjv_freeScene) mjv_freeScene;
  decltype(&::mjv_initGeom) mjv_initGeom;
  decltype(&::mjv_updateScene) mjv_updateScene;
  decltype(&::mjr_defaultContext) mjr_defaultContext;
  decltype(&::mjr_makeContext) mjr_makeContext;
  decltype(&::mjr_resizeOffscreen) mjr_resizeOffscreen;
  decltype(&::mjr_setBuffer) mjr_setBuffer;
  decltype(&::mjr_render) mjr_render;
  decltype(&::mjr_readPixels) mjr_readPixels;
  decltype(&::mju_warningText) mju_warningText;
  mjfLogHandler (*set_log_handler)(mjfLogHandler handler);  ///< of this thread; returns the one before
};

/// See `use_library`.
void set_library(std::string path);
/// Loads the library once; it stays. Throws ConfigError, naming the command that installs it, where it is not there or
/// is of another version than the headers that we were compiled with.
const Library& library();

/// While this lives, an error inside MuJoCo is thrown as a ContractError by the call that met it, in this thread, where
/// MuJoCo would end the process. What it warns of is not printed: the counts in `mjData` say it.
class ErrorsThrown {
 public:
  ErrorsThrown();
  ErrorsThrown(const ErrorsThrown&) = delete;
  ErrorsThrown& operator=(const ErrorsThrown&) = delete;
  ~ErrorsThrown();

 private:
  mjfLogHandler before_;
};

}  // namespace threewe::backend::mujoco
