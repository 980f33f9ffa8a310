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
  decltype(&::mj_deleteSpec) mj_deleteSpec;
  decltype(&::mj_deleteModel) mj_deleteModel;
  decltype(&::mj_makeData) mj_makeData;
  decltype(&::mj_deleteData) mj_deleteData;
  decltype(&::mj_resetData) mj_resetData;
  decltype(&::mj_name2id) mj_name2id;
  decltype(&::mj_id2name) mj_id2name;
  decltype(&::mj_fwdPosition) mj_fwdPosition;
  decltype(&::mj_step1) mj_step1;
  decltype(&::mj_step2) mj_step2;
  decltype(&::mj_ray) mj_ray;
  decltype(&::mj_stateSize) mj_stateSize;
  decltype(&::mj_getState) mj_getState;
  decltype(&::mj_setState) mj_setState;
};

/// See `use_library`.
void set_library(std::string path);
/// Loads the library once; it stays. Throws ConfigError, naming the command that installs it, where it is not there or
/// is of another version than the headers that we were compiled with.
const Library& library();

}  // namespace threewe::backend::mujoco
