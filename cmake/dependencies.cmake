# What libthreewe links. Read by our own build and, where it is installed as a static library, by find_package(threewe).
include(CMakeFindDependencyMacro)

find_dependency(Threads)
find_dependency(hwy)
find_dependency(yaml-cpp)
find_dependency(fmt)
find_dependency(pugixml)

# yaml-cpp 0.7 (Debian 12) has no namespaced target, 0.8 (Ubuntu 24.04) has
if(NOT TARGET yaml-cpp::yaml-cpp)
  add_library(yaml-cpp::yaml-cpp ALIAS yaml-cpp)
endif()

set(THREEWE_LINKED Threads::Threads hwy::hwy yaml-cpp::yaml-cpp fmt::fmt pugixml::pugixml)
