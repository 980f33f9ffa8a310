// Maps in ROS's files: what is written is read back, what strangers write is read as ROS reads it, and what cannot be
// read is refused with its place.
#include <doctest/doctest.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "draw.hpp"
#include "mistakes.hpp"
#include "threewe/core/errors.hpp"
#include "threewe/map/ros_map.hpp"

namespace threewe::map {
namespace {

// A folder for one test.
class Folder {
 public:
  explicit Folder(const std::string& name) : path_(std::filesystem::temp_directory_path() / ("threewe_" + name)) {
    std::filesystem::remove_all(path_);
    std::filesystem::create_directories(path_);
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  void write(const std::string& name, const std::string& bytes) const {
    std::ofstream(path_ / name, std::ios::binary) << bytes;
  }

 private:
  std::filesystem::path path_;
};

std::string read(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

std::string complaint_about(const std::filesystem::path& yaml) {
  try {
    (void)load_ros_map(yaml);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "none";
}

const std::string kYaml =
    "image: m.pgm\nresolution: 0.1\norigin: [-1.5, 2.25, 0.0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n";

TEST_CASE("a map is the same after it was saved and loaded, apart from what is neither free nor occupied") {
  const Folder folder("ros_map_round_trip");
  for (std::uint64_t seed = 0; seed < cases(300); ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    OccupancyGrid grid;
    grid.width = draw.whole(1, 40);
    grid.height = draw.whole(1, 40);
    grid.resolution = draw(0.01, 0.3);
    grid.origin = draw.point(-100.0, 100.0);
    OccupancyGrid expected = grid;
    for (int i = 0; i < grid.width * grid.height; ++i) {
      const auto value = static_cast<std::int8_t>(draw.whole(-1, 100));
      grid.data.push_back(value);
      expected.data.push_back(value >= 65 ? 100 : value >= 0 && value <= 25 ? 0 : -1);
    }
    save_ros_map(grid, folder / "a map: 1.yaml");
    CHECK(load_ros_map(folder / "a map: 1.yaml") == expected);
  }
}

TEST_CASE("the picture is as ROS draws it: north up, black walls, grey where nobody looked") {
  const Folder folder("ros_map_picture");
  save_ros_map({3, 2, 0.1, {-1.0, 2.5}, {-1, 0, 100, 25, 26, 65}}, folder / "map.yaml");
  CHECK(read(folder / "map.pgm") == std::string("P5\n# written by threewe\n3 2\n255\n\xfe\xcd\0\xcd\xfe\0", 38));
  CHECK(read(folder / "map.yaml") ==
        "image: map.pgm\nmode: trinary\nresolution: 0.1\norigin: [-1, 2.5, 0]\nnegate: 0\noccupied_thresh: 0.65\n"
        "free_thresh: 0.196\n");
}

TEST_CASE("thresholds and negate count as in map_server") {
  const Folder folder("ros_map_meaning");
  folder.write("m.pgm", "P2 # by hand\n4 1\n# a comment\n100\n0 30 50 100\n");
  const auto cells = [&](const std::string& rest) {
    folder.write("m.yaml", "image: m.pgm\nresolution: 0.1\norigin: [0, 0, 0]\n" + rest);
    return load_ros_map(folder / "m.yaml").data;
  };
  using Cells = std::vector<std::int8_t>;
  CHECK(cells("occupied_thresh: 0.65\nfree_thresh: 0.25\n") == Cells{100, 100, -1, 0});
  CHECK(cells("occupied_thresh: 0.75\nfree_thresh: 0.55\nnegate: false\n") == Cells{100, -1, 0, 0});
  CHECK(cells("occupied_thresh: 0.65\nfree_thresh: 0.25\nnegate: 1\nmode: trinary\n") == Cells{0, -1, -1, 100});
  CHECK(cells("occupied_thresh: 0.5\nfree_thresh: 0.5\nnegate: true\nours: 1\n") == Cells{0, 0, -1, 100});
}

TEST_CASE("what cannot be read is one error that says where") {
  const Folder folder("ros_map_wrong");
  folder.write("m.pgm", "P5 2 2 255\nabcd");
  folder.write("good.yaml", kYaml);
  CHECK(load_ros_map(folder / "good.yaml").origin == Vec2{-1.5, 2.25});
  const auto expect = [&](const std::string& from, const std::string& to, const std::string& message) {
    std::string text = kYaml;
    text.replace(text.find(from), from.size(), to);
    folder.write("m.yaml", text);
    const std::string complaint = complaint_about(folder / "m.yaml");
    CAPTURE(complaint);
    CHECK(complaint.find((folder / "m.").string()) == 0);
    CHECK(complaint.find(message) != std::string::npos);
  };
  expect("origin: [-1.5, 2.25, 0.0]", "origin: [0, 0, 0.3]", "m.yaml:3: origin[2]: only maps along the axes");
  expect("origin: [-1.5, 2.25, 0.0]", "origin: [0, 0]", "m.yaml:3: origin: expected [x, y, yaw]");
  expect("resolution: 0.1", "resolution: 0", "m.yaml:2: resolution: 0 is outside [0.001, 10]");
  expect("resolution", "resolutoin", "missing field 'resolution'; is 'resolutoin' meant to be it?");
  expect("negate: 0", "negate: 2", "m.yaml:4: negate: expected 0 or 1, not '2'");
  expect("negate: 0", "mode: raw", "m.yaml:4: mode: expected trinary, not 'raw'");
  expect("free_thresh: 0.196", "free_thresh: 0.9", "m.yaml:6: free_thresh: must not be above occupied_thresh");
  expect("image: m.pgm", "image: m.none", "m.none: cannot be read");
  expect("image: m.pgm", "image: m.yaml", "m.yaml: is no PGM picture");
  CHECK(complaint_about(folder / "nothing.yaml").find("nothing.yaml: cannot be read") != std::string::npos);

  for (const auto& [bytes, message] : std::vector<std::pair<std::string, std::string>>{
           {"P5 2 2 255\nabc", "is cut off: 2 x 2 cells"},
           {"P5 2 -2 255\nabcd", "has no proper height"},
           {"P5 2 2 65535\nabcdabcd", "has no proper brightest value: expected a whole number from 1 to 255"},
           {"P5 9000 2 255\n", "is 9000 x 2; a map has at most 8192 cells a side"},
           {"P2 2 2 255 1 2 3", "has no proper cell"},
           {"P5", "has no proper width"},
           {"", "is no PGM picture"},
       }) {
    folder.write("m.pgm", bytes);
    const std::string complaint = complaint_about(folder / "good.yaml");
    CAPTURE(complaint);
    CHECK(complaint.find((folder / "m.pgm").string() + ": " + message) == 0);
  }
}

TEST_CASE("files with random mistakes are read or refused, nothing else") {
  const Folder folder("ros_map_mistakes");
  folder.write("m.pgm", "P5 2 2 255\nabcd");
  for (std::uint64_t seed = 0; seed < cases(500); ++seed) {
    const std::string places[] = {(folder / "m.yaml").string() + ":", (folder / "").string()};
    testing::read_with_mistakes(kYaml, seed, {places[0], places[1]}, [&](const std::string& spoilt) {
      folder.write("m.yaml", spoilt);
      (void)load_ros_map(folder / "m.yaml");
    });
  }
}

TEST_CASE("a map that cannot be saved is one error, and no file") {
  const Folder folder("ros_map_unsaved");
  const OccupancyGrid grid{1, 1, 0.05, {}, {0}};
  CHECK_THROWS_WITH_AS(save_ros_map(grid, folder / "map.pgm"), doctest::Contains("ends in .yaml"), ConfigError);
  CHECK_THROWS_WITH_AS(save_ros_map({}, folder / "map.yaml"), doctest::Contains("without cells"), ConfigError);
  CHECK_THROWS_WITH_AS(save_ros_map(grid, folder / "none" / "map.yaml"), doctest::Contains("cannot be written"),
                       ConfigError);
  CHECK_FALSE(std::filesystem::exists(folder / "map.yaml"));
}

}  // namespace
}  // namespace threewe::map
