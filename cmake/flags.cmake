# How every source of ours is compiled. Users of the installed library inherit none of it.
#   threewe_flags     what the library's bits depend on
#   threewe_warnings  what is warned about

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)

if(THREEWE_FUZZ) # with THREEWE_SANITIZE
  add_compile_options(-g -fsanitize=fuzzer-no-link)
endif()
if(THREEWE_SANITIZE)
  set(CMAKE_BUILD_TYPE "None") # assertions stay on
  add_compile_options(-O1 -fsanitize=address,undefined -fno-sanitize=null,alignment,vptr,object-size)
  add_link_options(-fsanitize=address,undefined)
elseif(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE "Release")
endif()

find_program(CCACHE ccache)
if(CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros ${CCACHE})
endif()

# the same bits on every machine: a product and a sum are never fused, and Eigen keeps to plain loops,
# whatever instructions a compiler may use
add_library(threewe_flags INTERFACE)
target_compile_features(threewe_flags INTERFACE cxx_std_20)
target_compile_options(threewe_flags INTERFACE -ffp-contract=off)
target_compile_definitions(threewe_flags INTERFACE EIGEN_DONT_VECTORIZE)
target_include_directories(threewe_flags INTERFACE "${PROJECT_SOURCE_DIR}/include" "${PROJECT_SOURCE_DIR}/src")

# Highway's functions for 64-bit Arm may use AES, and the compiler puts them only into code that may use it too. Nothing
# of ours does: processors without it are as good
if(CMAKE_SYSTEM_PROCESSOR STREQUAL "aarch64")
  add_compile_options(-march=armv8-a+crypto)
endif()

add_library(threewe_warnings INTERFACE)
if(NOT THREEWE_SANITIZE) # what the sanitizers insert would be warned about too
  target_compile_options(
    threewe_warnings
    INTERFACE -Wall -Wextra -Wpedantic -Wconversion -Wsign-conversion -Wshadow -Wold-style-cast -Wcast-qual
              -Wnon-virtual-dtor -Woverloaded-virtual -Wdouble-promotion -Wformat=2 -Wnull-dereference
              -Wimplicit-fallthrough $<$<BOOL:${THREEWE_DEVELOPER}>:-Werror>)
endif()
