# What libthreewe links. Read by our own build and, where it is installed as a static library, by find_package(threewe).
include(CMakeFindDependencyMacro)

find_dependency(Threads)
find_dependency(hwy)
find_dependency(yaml-cpp)
find_dependency(fmt)
find_dependency(pugixml)

# Debian 12 has no CMake package of zstd; where there is one, its target has this name
if(NOT TARGET zstd::libzstd)
  find_library(THREEWE_ZSTD zstd REQUIRED)
  add_library(zstd::libzstd UNKNOWN IMPORTED)
  set_target_properties(zstd::libzstd PROPERTIES IMPORTED_LOCATION "${THREEWE_ZSTD}")
endif()

# yaml-cpp 0.7 (Debian 12) has no namespaced target, 0.8 (Ubuntu 24.04) has
if(NOT TARGET yaml-cpp::yaml-cpp)
  add_library(yaml-cpp::yaml-cpp ALIAS yaml-cpp)
endif()

set(THREEWE_LINKED Threads::Threads hwy::hwy yaml-cpp::yaml-cpp fmt::fmt pugixml::pugixml zstd::libzstd)
