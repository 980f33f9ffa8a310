# Headers that nearly every source includes, parsed once for many targets: parsing them is half of a build.
#   threewe_precompile(OWNER [MORE...])        with MORE headers, for a target
#   threewe_precompile(TARGET REUSE_FROM OWNER)  for another that is compiled with the same flags
# A source includes what it uses all the same: with THREEWE_FAST_BUILD off, nothing is precompiled, which proves it.
set(THREEWE_PRECOMPILED
    <algorithm> <array> <atomic> <chrono> <cmath> <cstdint> <deque> <filesystem> <fstream> <functional> <limits> <map>
    <memory> <mutex> <numeric> <optional> <ranges> <set> <span> <sstream> <stdexcept> <string> <string_view> <thread>
    <unordered_map> <utility> <variant> <vector> <Eigen/Core> <Eigen/Geometry> <fmt/format.h> <tl/expected.hpp>)

function(threewe_precompile target)
  if(NOT THREEWE_FAST_BUILD)
    return()
  elseif("REUSE_FROM" IN_LIST ARGN)
    target_precompile_headers(${target} ${ARGN})
  else()
    target_precompile_headers(${target} PRIVATE ${THREEWE_PRECOMPILED} ${ARGN})
  endif()
  # so that ccache can keep what is compiled with them
  target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-fpch-preprocess>)
endfunction()
