#include "threewe/map/ros_map.hpp"

#include <array>
#include <charconv>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

#include <fmt/format.h>

#include "core/config.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::map {
namespace {

// Grey values by which ROS's map saver marks cells. Unknown ones are 50/255 = 0.1961 black: above this threshold below
// which they would be free, and below 0.25, with which ROS 2's own saver turns them into free ones.
constexpr unsigned char kBlack = 0;
constexpr unsigned char kWhite = 254;
constexpr unsigned char kGrey = 205;
constexpr double kFreeThreshold = 0.196;
constexpr double kOccupiedThreshold = 0.65;

struct Picture {
  int width = 0;
  int height = 0;
  int brightest = 255;
  std::vector<unsigned char> shades;  // the first row is the highest y
};

// Reads a PGM file of either kind: https://netpbm.sourceforge.net/doc/pgm.html
class PgmReader {
 public:
  explicit PgmReader(const std::filesystem::path& file) : file_(file) {
    constexpr std::uintmax_t kLargest = 1U << 28U;  // [bytes] more than any grid needs
    std::error_code error;
    const bool is_file = std::filesystem::is_regular_file(file, error);
    const std::uintmax_t size = is_file ? std::filesystem::file_size(file, error) : 0;
    if (is_file && size > kLargest) fail("is too large for a map's picture");
    bytes_.resize(size);
    if (!is_file || !std::ifstream(file, std::ios::binary).read(bytes_.data(), static_cast<std::streamsize>(size))) {
      fail("cannot be read");
    }
  }

  Picture read() {
    const std::string_view magic = std::string_view(bytes_).substr(0, 2);
    if (magic != "P5" && magic != "P2") fail("is no PGM picture: it must begin with P5 or P2");
    at_ = 2;
    Picture picture;
    picture.width = number("width", 1, 1 << 20);
    picture.height = number("height", 1, 1 << 20);
    if (!fits_a_grid(picture.width, picture.height)) {
      fail(fmt::format("is {} x {}; a map has at most 8192 cells a side and 16.7 million in all", picture.width,
                       picture.height));
    }
    picture.brightest = number("brightest value", 1, 255);
    const auto count = static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height);
    if (magic == "P5") {
      ++at_;  // one space ends the header
      if (bytes_.size() < at_ + count) fail(fmt::format("is cut off: {} x {} cells", picture.width, picture.height));
      picture.shades.assign(bytes_.begin() + static_cast<std::ptrdiff_t>(at_),
                            bytes_.begin() + static_cast<std::ptrdiff_t>(at_ + count));
    } else {
      picture.shades.reserve(count);
      for (std::size_t i = 0; i < count; ++i) {
        picture.shades.push_back(static_cast<unsigned char>(number("cell", 0, picture.brightest)));
      }
    }
    return picture;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw ConfigError(fmt::format("{}: {}", file_.string(), what));
  }

  int number(const char* what, int low, int high) {
    skip_spaces_and_comments();
    int value = 0;
    const char* begin = bytes_.data() + at_;
    const auto [end, error] = std::from_chars(begin, bytes_.data() + bytes_.size(), value);
    if (error != std::errc{} || value < low || value > high) {
      fail(fmt::format("has no proper {}: expected a whole number from {} to {}", what, low, high));
    }
    at_ += static_cast<std::size_t>(end - begin);
    return value;
  }

  void skip_spaces_and_comments() {
    const auto is_space = [](char c) { return c == ' ' || (c >= '\t' && c <= '\r'); };
    while (at_ < bytes_.size() && (is_space(bytes_[at_]) || bytes_[at_] == '#')) {
      at_ = bytes_[at_] == '#' ? std::min(bytes_.find('\n', at_), bytes_.size()) : at_ + 1;
    }
  }

  std::filesystem::path file_;
  std::string bytes_;
  std::size_t at_ = 0;
};

// How ROS reads shades.
struct Meaning {
  bool negate = false;  // white is occupied
  double occupied = 0.0;
  double free = 0.0;
  std::int8_t of(int shade, int brightest) const {
    const double black = static_cast<double>(negate ? shade : brightest - shade) / brightest;
    if (black > occupied) return OccupancyGrid::kOccupied;
    return black < free ? OccupancyGrid::kFree : OccupancyGrid::kUnknown;
  }
};

Vec2 read_origin(const ConfigNode& node) {
  const std::vector<ConfigNode> values = node.items();
  if (values.size() != 3) node.fail("expected [x, y, yaw]");
  if (values[2].number() != 0.0) {
    values[2].fail("only maps along the axes are read: turn the picture, and write a yaw of 0");
  }
  return {values[0].number_in(-kFarthest, kFarthest), values[1].number_in(-kFarthest, kFarthest)};
}

Meaning read_meaning(ConfigNode& root) {
  if (root.has("mode")) {
    const std::string mode = root.text("mode");
    if (mode != "trinary") root.at("mode").fail(fmt::format("expected trinary, not '{}'", mode));
  }
  Meaning meaning;
  meaning.occupied = root.number_in("occupied_thresh", 0.0, 1.0);
  meaning.free = root.number_in("free_thresh", 0.0, 1.0);
  if (meaning.free > meaning.occupied) root.at("free_thresh").fail("must not be above occupied_thresh");
  if (root.has("negate")) {
    const std::string negate = root.text("negate");
    meaning.negate = negate == "1" || negate == "true";
    if (!meaning.negate && negate != "0" && negate != "false") {
      root.at("negate").fail(fmt::format("expected 0 or 1, not '{}'", negate));
    }
  }
  return meaning;
}

std::int8_t as_trinary(std::int8_t value) {
  if (value >= OccupancyGrid::kOccupiedThreshold) return OccupancyGrid::kOccupied;
  return value >= 0 && value <= OccupancyGrid::kFreeThreshold ? OccupancyGrid::kFree : OccupancyGrid::kUnknown;
}

// Replaces a file as a whole, or leaves it as it was.
void write_file(const std::filesystem::path& file, const std::string& bytes) {
  std::filesystem::path unfinished = file;
  unfinished += ".part";
  std::ofstream stream(unfinished, std::ios::binary);
  stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  stream.close();
  std::error_code error;
  if (stream) std::filesystem::rename(unfinished, file, error);
  if (!stream || error) {
    std::error_code ignored;
    std::filesystem::remove(unfinished, ignored);
    throw ConfigError(fmt::format("{}: cannot be written; is its folder there?", file.string()));
  }
}

}  // namespace

OccupancyGrid load_ros_map(const std::filesystem::path& yaml) {
  // other fields are let be: ROS programs add their own
  ConfigNode root = ConfigNode::load(yaml);
  OccupancyGrid grid;
  grid.resolution = root.number_in("resolution", kFinestResolution, kCoarsestResolution);
  grid.origin = read_origin(root.at("origin"));
  const Meaning meaning = read_meaning(root);
  const std::string image = root.text("image");
  if (image.empty()) root.at("image").fail("expected the name of a PGM picture");
  const Picture picture = PgmReader(yaml.parent_path() / image).read();

  grid.width = picture.width;
  grid.height = picture.height;
  grid.data.resize(picture.shades.size());
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      const unsigned char shade = picture.shades[grid.index({x, grid.height - 1 - y})];
      grid.data[grid.index({x, y})] = meaning.of(std::min<int>(shade, picture.brightest), picture.brightest);
    }
  }
  return grid;
}

void save_ros_map(const OccupancyGrid& grid, const std::filesystem::path& yaml) {
  if (yaml.extension() != ".yaml" || yaml.stem().empty()) {
    throw ConfigError(fmt::format("{}: the name of a map's file ends in .yaml", yaml.string()));
  }
  if (grid.data.empty()) throw ConfigError(fmt::format("{}: a map without cells is not saved", yaml.string()));

  std::filesystem::path image = yaml;
  image.replace_extension(".pgm");
  std::string picture = fmt::format("P5\n# written by threewe\n{} {}\n255\n", grid.width, grid.height);
  picture.reserve(picture.size() + grid.data.size());
  for (int y = grid.height - 1; y >= 0; --y) {
    for (int x = 0; x < grid.width; ++x) {
      const std::int8_t value = as_trinary(grid.data[grid.index({x, y})]);
      const bool occupied = value == OccupancyGrid::kOccupied;
      picture.push_back(static_cast<char>(occupied ? kBlack : value == OccupancyGrid::kFree ? kWhite : kGrey));
    }
  }
  const std::string name = YAML::Dump(YAML::Node(image.filename().string()));
  write_file(image, picture);
  write_file(yaml,
             fmt::format("image: {}\nmode: trinary\nresolution: {}\norigin: [{}, {}, 0]\nnegate: 0\n"
                         "occupied_thresh: {}\nfree_thresh: {}\n",
                         name, grid.resolution, grid.origin.x, grid.origin.y, kOccupiedThreshold, kFreeThreshold));
}

}  // namespace threewe::map
