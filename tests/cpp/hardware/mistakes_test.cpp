// Robot profiles with random mistakes: each loads, or is refused with its file and line.
#include <doctest/doctest.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "mistakes.hpp"
#include "threewe/core/assets.hpp"
#include "threewe/hardware/profile.hpp"

namespace threewe {
namespace {

constexpr std::uint64_t kCases = 200;  // of each file

TEST_CASE("profiles with mistakes") {
  const std::string file = (std::filesystem::temp_directory_path() / "threewe_mistakes_test.yaml").string();
  for (const std::string& name : profile_names()) {
    CAPTURE(name);
    std::ostringstream text;
    text << std::ifstream(find_asset("robots", name)).rdbuf();
    for (std::uint64_t seed = 0; seed < kCases; ++seed) {
      testing::read_with_mistakes(text.str(), seed, {file + ":"}, [&](const std::string& spoilt) {
        std::ofstream(file) << spoilt;
        load_profile(file);
      });
    }
  }
  std::filesystem::remove(file);
}

}  // namespace
}  // namespace threewe
