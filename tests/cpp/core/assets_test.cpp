#include "threewe/core/assets.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <string>

#include "threewe/core/errors.hpp"

namespace threewe {
namespace {

namespace fs = std::filesystem;

// A folder of assets that exists as long as the test.
class Folder {
 public:
  explicit Folder(const std::string& name) : path_(fs::temp_directory_path() / ("threewe_assets_test_" + name)) {
    fs::remove_all(path_);
    fs::create_directories(path_ / "scenes");
  }
  ~Folder() { fs::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  const fs::path& path() const { return path_; }
  fs::path scene(const std::string& name) const {
    const fs::path file = path_ / "scenes" / name;
    std::ofstream(file) << "name: test\n";
    return file;
  }

 private:
  fs::path path_;
};

// THREEWE_ASSETS as long as the test.
struct Environment {
  explicit Environment(const std::string& value) { setenv("THREEWE_ASSETS", value.c_str(), 1); }
  ~Environment() { unsetenv("THREEWE_ASSETS"); }
  Environment(const Environment&) = delete;
  Environment& operator=(const Environment&) = delete;
};

bool lists(const std::string& name) {
  const auto names = asset_names("scenes");
  return std::ranges::find(names, name) != names.end();
}

TEST_CASE("assets are found in the environment's folders, the first of them first") {
  const Folder first("first");
  const Folder second("second");
  const fs::path mine = first.scene("test_mine.yaml");
  second.scene("test_mine.yaml");
  const fs::path other = second.scene("test_other.yaml");
  second.scene("test_notes.txt");

  const Environment environment(first.path().string() + "::" + second.path().string() + ":/does/not/exist");
  CHECK(asset_directories().front() == first.path());
  CHECK(find_asset("scenes", "test_mine") == mine);
  CHECK(find_asset("scenes", "test_other") == other);
  CHECK(lists("test_mine"));
  CHECK(lists("test_other"));
  CHECK_FALSE(lists("test_notes"));

  const auto names = asset_names("scenes");
  CHECK(std::ranges::is_sorted(names));
  CHECK(std::ranges::count(names, "test_mine") == 1);
}

TEST_CASE("folders can be added") {
  const Folder folder("added");
  const fs::path file = folder.scene("test_added.yaml");
  CHECK_THROWS_AS(find_asset("scenes", "test_added"), ConfigError);
  add_asset_directory(folder.path());
  add_asset_directory(folder.path());
  CHECK(find_asset("scenes", "test_added") == file);
  CHECK(std::ranges::count(asset_directories(), folder.path()) == 1);
}

TEST_CASE("a path that ends in .yaml is taken as it is") {
  const Folder folder("path");
  const fs::path file = folder.scene("test_path.yaml");
  CHECK(find_asset("scenes", file.string()) == file);
  const std::string missing = (folder.path() / "nothing.yaml").string();
  CHECK_THROWS_WITH_AS(find_asset("scenes", missing), ("scene file '" + missing + "' does not exist").c_str(),
                       ConfigError);
}

TEST_CASE("an unknown name is answered with the nearest") {
  const Folder folder("unknown");
  folder.scene("test_ballroom.yaml");
  const Environment environment(folder.path().string());
  CHECK_THROWS_WITH_AS(find_asset("scenes", "test_balroom"),
                       "unknown scene 'test_balroom'; did you mean 'test_ballroom'?", ConfigError);
  CHECK_THROWS_AS(find_asset("scenes", ""), ConfigError);
  CHECK_THROWS_AS(find_asset("scenes", "../scenes/test_ballroom"), ConfigError);  // a name is not a path
}

}  // namespace
}  // namespace threewe
