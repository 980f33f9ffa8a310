#include "threewe/core/assets.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <string>

#include <fmt/format.h>

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

// THREEWE_PATH as long as the test.
struct Environment {
  explicit Environment(const std::string& value) { setenv("THREEWE_PATH", value.c_str(), 1); }
  ~Environment() { unsetenv("THREEWE_PATH"); }
  Environment(const Environment&) = delete;
  Environment& operator=(const Environment&) = delete;
};

bool lists(const std::string& name) {
  const auto names = asset_names("scenes");
  return std::ranges::find(names, name) != names.end();
}

TEST_CASE("assets are found in the folders of other people") {
  const Folder first("first");
  const Folder second("second");
  const fs::path mine = first.scene("test_mine.yaml");
  const fs::path other = second.scene("test_other.yaml");
  second.scene("test_notes.txt");

  const Environment environment(first.path().string() + "::" + second.path().string() + ":" + second.path().string());
  CHECK(std::ranges::count(asset_directories(), second.path()) == 1);
  CHECK(find_asset("scenes", "test_mine") == mine);
  CHECK(find_asset("scenes", "test_other") == other);
  CHECK(lists("test_mine"));
  CHECK(lists("test_other"));
  CHECK_FALSE(lists("test_notes"));
  CHECK(std::ranges::is_sorted(asset_names("scenes")));
}

TEST_CASE("a name that two folders have is an error that names both files") {
  const Folder first("twice_first");
  const Folder second("twice_second");
  const fs::path mine = first.scene("test_hall.yaml");
  const fs::path other = second.scene("test_hall.yaml");
  const Environment environment(first.path().string() + ":" + second.path().string());
  CHECK_THROWS_WITH_AS(
      find_asset("scenes", "test_hall"),
      ("there are two scenes named 'test_hall': " + mine.string() + " and " + other.string() + "; rename one of them")
          .c_str(),
      ConfigError);
  const auto names = asset_names("scenes");
  CHECK(std::ranges::count(names, "test_hall") == 1);

  second.scene("office_v2.yaml");  // not even one that comes with the library
  CHECK_THROWS_WITH_AS(find_asset("scenes", "office_v2"), doctest::Contains("there are two scenes named 'office_v2'"),
                       ConfigError);
}

TEST_CASE("what is no asset is not listed") {
  const Folder folder("listed");
  folder.scene("test_hall.yaml");
  folder.scene(".test_hidden.yaml");  // as editors and archives leave them
  fs::create_directories(folder.path() / "scenes" / "test_folder.yaml");
  fs::create_symlink("nowhere", folder.path() / "scenes" / "test_dangling.yaml");
  const Environment environment(folder.path().string());
  CHECK(lists("test_hall"));
  CHECK_FALSE(lists(".test_hidden"));
  CHECK_FALSE(lists("test_folder"));
  CHECK_FALSE(lists("test_dangling"));
}

TEST_CASE("a file that ends in .yml is not overlooked in silence") {
  const Folder folder("yml");
  const fs::path file = folder.scene("test_hall.yml");
  const Environment environment(folder.path().string());
  CHECK_THROWS_WITH_AS(find_asset("scenes", "test_hall"),
                       ("rename " + file.string() + ": the names of such files end in .yaml").c_str(), ConfigError);
}

TEST_CASE("a folder that holds no assets is refused: the one above or below it may be meant") {
  const Folder folder("above");
  const fs::path below = folder.path() / "scenes";
  const std::string message =
      fmt::format("'{}' has no folder 'scenes', 'objects', 'robots', 'localization', 'randomization' or 'logs' in it",
                  below.string());
  CHECK_THROWS_WITH_AS(add_asset_directory(below), message.c_str(), ConfigError);
  const Environment environment(below.string());
  CHECK_THROWS_WITH_AS(asset_directories(), ("THREEWE_PATH: " + message).c_str(), ConfigError);
}

TEST_CASE("what is no folder is refused") {
  const Environment environment("/does/not/exist");
  CHECK_THROWS_WITH_AS(asset_directories(), "THREEWE_PATH: '/does/not/exist' is not a folder", ConfigError);
  CHECK_THROWS_WITH_AS(add_asset_directory("/does/not/exist"), "'/does/not/exist' is not a folder", ConfigError);
  CHECK_THROWS_WITH_AS(add_asset_directory(std::string(10'000, 'x')), doctest::Contains("is not a folder"),
                       ConfigError);
}

TEST_CASE("folders can be added") {
  const Folder folder("added");
  const fs::path file = folder.scene("test_added.yaml");
  CHECK_THROWS_AS(find_asset("scenes", "test_added"), ConfigError);
  add_asset_directory(folder.path());
  add_asset_directory(folder.path() / ".");
  CHECK(find_asset("scenes", "test_added") == file);
  CHECK(std::ranges::count(asset_directories(), folder.path()) == 1);
}

TEST_CASE("an added folder stays what it was when the program goes elsewhere") {
  const Folder folder("relative");
  const fs::path file = folder.scene("test_relative.yaml");
  const fs::path here = fs::current_path();
  fs::current_path(folder.path().parent_path());
  add_asset_directory(folder.path().filename());
  fs::current_path(here);
  CHECK(find_asset("scenes", "test_relative") == file);
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
