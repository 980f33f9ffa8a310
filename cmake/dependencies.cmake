# What the library links. Read by our own build and, once installed, by find_package(threewe).
include(CMakeFindDependencyMacro)

find_dependency(Threads)
find_dependency(Eigen3)
find_dependency(hwy)
find_dependency(nlohmann_json)
find_dependency(yaml-cpp)
find_dependency(fmt)
find_dependency(tl-expected)
find_dependency(pugixml)

# yaml-cpp 0.7 (Debian 12) has no namespaced target, 0.8 (Ubuntu 24.04) has
if(NOT TARGET yaml-cpp::yaml-cpp)
  add_library(yaml-cpp::yaml-cpp ALIAS yaml-cpp)
endif()

set(THREEWE_DEPENDENCIES Threads::Threads Eigen3::Eigen hwy::hwy nlohmann_json::nlohmann_json yaml-cpp::yaml-cpp
                         fmt::fmt tl::expected pugixml::pugixml)
