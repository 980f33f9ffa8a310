# MuJoCo's headers, from the PyPI package `mujoco-core`: the backend is compiled where they are. Its library is not
# linked but loaded when a world is made, so that ours runs without. Both must be of one version, since the backend reads
# MuJoCo's structs.
#   -D THREEWE_MUJOCO_INCLUDE_DIR=DIR   the folder of mujoco/mujoco.h, where it is not that of the Python in use
set(THREEWE_MUJOCO_VERSION 4.0.0)
set(header 4000000)  # what its header says then

if(NOT THREEWE_MUJOCO_INCLUDE_DIR)
  find_package(Python 3.11 QUIET COMPONENTS Interpreter)
  if(Python_FOUND)
    execute_process(
      COMMAND "${Python_EXECUTABLE}" -c
              "import importlib.util as u; s = u.find_spec('mujoco'); print(s.submodule_search_locations[0] if s else '')"
      OUTPUT_VARIABLE package OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
    if(EXISTS "${package}/include/mujoco/mujoco.h")
      set(THREEWE_MUJOCO_INCLUDE_DIR "${package}/include")
    endif()
  endif()
endif()

set(THREEWE_MUJOCO_FOLDERS)
if(THREEWE_MUJOCO_INCLUDE_DIR)
  file(STRINGS "${THREEWE_MUJOCO_INCLUDE_DIR}/mujoco/mujoco.h" found REGEX "#define mjVERSION_HEADER ")
  string(REGEX REPLACE ".* " "" found "${found}")
  if(found STREQUAL header)
    set(THREEWE_MUJOCO_FOLDERS world)
  else()
    message(STATUS "MuJoCo ${found} in ${THREEWE_MUJOCO_INCLUDE_DIR} is not ${THREEWE_MUJOCO_VERSION}: its backend is left out")
  endif()
else()
  message(STATUS "MuJoCo's headers not found, its backend is left out: pip install mujoco-core==${THREEWE_MUJOCO_VERSION}")
endif()

# Gives a target the headers, and tells it whether the backend is compiled.
function(threewe_use_mujoco target)
  if(THREEWE_MUJOCO_FOLDERS)
    target_include_directories(${target} SYSTEM PRIVATE "${THREEWE_MUJOCO_INCLUDE_DIR}")
    target_compile_definitions(${target} PRIVATE THREEWE_WITH_MUJOCO=1)
    target_link_libraries(${target} PRIVATE ${CMAKE_DL_LIBS})
  else()
    target_compile_definitions(${target} PRIVATE THREEWE_WITH_MUJOCO=0)
  endif()
endfunction()
