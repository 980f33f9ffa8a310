// What users hear where MuJoCo is not, or not as it must be. These cases run first: a library that was loaded stays.
#include <string>

#include <doctest/doctest.h>

#include "backend/mujoco/mujoco.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::backend {
namespace {

std::string error_of_making() {
  try {
    mujoco::make_world({});
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

bool contains(const std::string& text, const char* part) { return text.find(part) != std::string::npos; }

#if THREEWE_WITH_MUJOCO

TEST_CASE("without MuJoCo's library the error says how to get it") {
  mujoco::use_library("/nowhere/libmujoco.so.4.0.0");
  const std::string error = error_of_making();
  CHECK_MESSAGE(contains(error, "/nowhere/libmujoco.so.4.0.0"), error);
  CHECK_MESSAGE(contains(error, "pip install mujoco-core==4.0.0"), error);
}

TEST_CASE("another version of MuJoCo is refused") {
  mujoco::use_library(OTHER_MUJOCO);
  const std::string error = error_of_making();
  CHECK_MESSAGE(contains(error, "3003000"), error);
  CHECK_MESSAGE(contains(error, "pip install mujoco-core==4.0.0"), error);
}

#else

TEST_CASE("a build without MuJoCo's headers says how to get the backend") {
  CHECK(contains(error_of_making(), "pip install mujoco-core==4.0.0"));
}

#endif

}  // namespace
}  // namespace threewe::backend
