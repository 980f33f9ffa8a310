#include "slam/slam_file.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "core/bounds.hpp"
#include "slam/slam_config.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::slam {
namespace {

constexpr std::string_view kFirstLine = "threewe slam 1";
constexpr std::int64_t kLatest = 1'000'000'000'000'000'000;  // [ns] 30 years
constexpr std::size_t kShown = 24;                           // characters of what is no number

constexpr std::string_view kComments =
    "# lidar: x y theta range_max range_bias range_bias_sigma; map: resolution\n"
    "# odometry: distance_sigma position_drift heading_drift\n"
    "# keyframe: stamp [ns], driven [m], x y theta in the map\n"
    "# scan: x y theta in the keyframe, x y of the first beam's origin, how many beams, and of each:\n"
    "#   range [m], direction [turn/65536], x y of its origin from the first one's [0.1 mm], 1 a hit + 2 a thin thing\n"
    "# step: stamp [ns], x y theta in the keyframe\n"
    "# constraint: from to, x y theta of `to` in `from`, information xx xy xt yy yt tt, 1 a loop that was closed\n";

// One line: its first word says what it is about, the rest are numbers.
class Line {
 public:
  Line(const std::filesystem::path& path, int number, std::string_view text) : path_(path), number_(number) {
    word_ = text.substr(0, text.find(' '));
    rest_ = text.substr(word_.size());
  }

  std::string_view word() const { return word_; }
  [[noreturn]] void fail(const std::string& why) const {
    throw ConfigError(fmt::format("{}:{}: {}", path_.string(), number_, why));
  }

  double number(std::string_view what) {
    double value = 0.0;
    parse(what, "a finite number", value);
    if (!std::isfinite(value)) fail(fmt::format("{} must be a finite number", what));
    return value;
  }
  std::int64_t integer(std::string_view what, std::int64_t low, std::int64_t high) {
    std::int64_t value = 0;
    parse(what, "a whole number", value);
    if (value < low || value > high) {
      fail(fmt::format("{} must be a whole number from {} to {}, got {}", what, low, high, value));
    }
    return value;
  }
  double number_in(std::string_view what, double low, double high) {
    const double value = number(what);
    if (value < low || value > high) fail(fmt::format("{} must lie in [{}, {}], got {}", what, low, high, value));
    return value;
  }
  Vec2 place(std::string_view what) {
    const double x = number_in(what, -kMaxCoordinate, kMaxCoordinate);
    return {x, number_in(what, -kMaxCoordinate, kMaxCoordinate)};
  }
  Pose2D pose(std::string_view what) {
    const Vec2 position = place(what);
    return {position.x, position.y, number_in(what, -kMaxAngle, kMaxAngle)};
  }
  void finish() const {
    if (!rest_.empty()) fail(fmt::format("a line '{}' has more numbers than it should: '{}'", word_, rest_));
  }

 private:
  template <class Value>
  void parse(std::string_view what, std::string_view kind, Value& value) {
    if (rest_.empty()) fail(fmt::format("a line '{}' ends before {}", word_, what));
    const char* const begin = rest_.data() + 1;
    const char* const end = rest_.data() + rest_.size();
    const auto [stop, error] = std::from_chars(begin, end, value);
    if (error != std::errc() || (stop != end && *stop != ' ')) {
      const std::string_view left(begin, end);
      fail(fmt::format("{} must be {}, got '{}'", what, kind, left.substr(0, std::min(left.find(' '), kShown))));
    }
    rest_.remove_prefix(static_cast<std::size_t>(stop - rest_.data()));
  }

  const std::filesystem::path& path_;
  int number_;
  std::string_view word_;
  std::string_view rest_;  // begins with a space, unless nothing is left
};

std::string text_of(const Pose2D& pose) { return fmt::format("{} {} {}", pose.x, pose.y, pose.theta); }

void write_keyframe(const KeyframeGraphData& keyframe_graph, int keyframe, std::string& text) {
  const auto to = std::back_inserter(text);
  const Keyframe& k = keyframe_graph.keyframes[static_cast<std::size_t>(keyframe)];
  fmt::format_to(to, "keyframe {} {} {}\n", k.stamp.count(), k.driven, text_of(keyframe_graph.pose_of(keyframe)));
  for (const Keyframe::Scan& scan : k.scans) {
    const auto& [origin, beams] = scan.beams;
    fmt::format_to(to, "scan {} {} {} {}", text_of(scan.keyframe_from_base), origin.x, origin.y, beams.size());
    for (const PackedBeam& b : beams) {
      fmt::format_to(to, " {} {} {} {} {}", b.range, b.direction, b.origin_x, b.origin_y, b.hit_or_thin);
    }
    text += '\n';
  }
}

// Reads a file line by line, in the order in which they are written.
class Reader {
 public:
  explicit Reader(const std::filesystem::path& path) : path_(path) {
    std::error_code error;  // a device or a pipe may never end
    if (std::filesystem::is_regular_file(path, error)) file_.open(path, std::ios::binary);
    if (!file_.is_open()) {
      throw ConfigError(fmt::format("{}: cannot be read; a map is saved by Slam.save", path.string()));
    }
  }

  SlamFile read();

 private:
  bool next_line();
  Line line() const { return {path_, number_, text_}; }
  void read_line(Line& line);
  void read_keyframe(Line& line);
  void read_scan(Line& line);
  void read_step(Line& line);
  void read_constraint(Line& line);
  void read_settings(Line& line);

  const std::filesystem::path& path_;
  std::ifstream file_;
  std::string text_;
  int number_ = 0;
  SlamFile content_;
};

SlamFile Reader::read() {
  if (!next_line() || text_ != kFirstLine) {
    Line(path_, 1, "")
        .fail(fmt::format("this is no map that Slam.save wrote: the first line must be '{}'", kFirstLine));
  }
  while (next_line()) {
    Line here = line();
    if (here.word() == "end") {
      KeyframeGraphData& keyframe_graph = content_.keyframe_graph;
      if (keyframe_graph.steps.empty()) here.fail("a map has one keyframe and one step at least");
      try {
        keyframe_graph.graph.solve(0);
      } catch (const ContractError& error) {
        here.fail(error.what());
      }
      return std::move(content_);
    }
    read_line(here);
    here.finish();
  }
  Line(path_, number_, "").fail("the file was cut off: the last line must be 'end'");
}

// The next line that is no comment.
bool Reader::next_line() {
  while (std::getline(file_, text_)) {
    ++number_;
    if (!text_.empty() && text_.back() == '\r') text_.pop_back();
    if (!text_.empty() && text_.front() != '#') return true;
  }
  return false;
}

void Reader::read_line(Line& line) {
  const std::string_view word = line.word();
  if (word == "keyframe") return read_keyframe(line);
  if (word == "constraint") return read_constraint(line);
  if (word == "lidar" || word == "map" || word == "odometry") return read_settings(line);
  if (word != "scan" && word != "step") {
    line.fail(fmt::format("'{}' is none of lidar, map, odometry, keyframe, scan, step, constraint, end",
                          word.substr(0, kShown)));
  }
  if (content_.keyframe_graph.keyframes.empty()) line.fail(fmt::format("a line '{}' before the first keyframe", word));
  word == "scan" ? read_scan(line) : read_step(line);
}

void Reader::read_settings(Line& line) {
  SlamConfig& config = content_.config;
  if (line.word() == "lidar") {
    config.base_from_lidar = line.pose("base_from_lidar");
    config.range_max = line.number("range_max");
    content_.range_bias = line.number_in("range_bias", -map::kMaxRangeBias, map::kMaxRangeBias);
    config.range_bias_sigma = line.number("range_bias_sigma");
  } else if (line.word() == "map") {
    config.resolution = line.number("resolution");
  } else {
    config.distance_sigma = line.number("distance_sigma");
    config.position_drift = line.number("position_drift");
    config.heading_drift = line.number("heading_drift");
  }
  try {
    check(config);
  } catch (const ContractError& error) {
    line.fail(error.what());
  }
}

void Reader::read_keyframe(Line& line) {
  KeyframeGraphData& keyframe_graph = content_.keyframe_graph;
  const auto stamp = Time(line.integer("stamp", 0, kLatest));
  const double driven = line.number("driven");
  if (!keyframe_graph.keyframes.empty() && driven < keyframe_graph.keyframes.back().driven)
    line.fail("driven must not go back");
  keyframe_graph.graph.add_node(line.pose("a pose"), keyframe_graph.keyframes.empty());
  keyframe_graph.keyframes.push_back({stamp, driven, {}});
  keyframe_graph.extend_submaps(Params::Graph{}.submap_length);
}

void Reader::read_scan(Line& line) {
  Keyframe::Scan scan;
  scan.keyframe_from_base = line.pose("a pose");
  scan.beams.origin = line.place("an origin");
  const std::int64_t beams = line.integer("the number of beams", 0, kMaxBeams);
  for (std::int64_t i = 0; i < beams; ++i) {
    PackedBeam& beam = scan.beams.beams.emplace_back();
    beam.range = static_cast<float>(line.number_in("a range", 0.0, kMaxCoordinate));
    beam.direction = static_cast<std::uint16_t>(line.integer("a direction", 0, 65535));
    beam.origin_x = static_cast<std::int16_t>(line.integer("an origin", -32767, 32767));
    beam.origin_y = static_cast<std::int16_t>(line.integer("an origin", -32767, 32767));
    beam.hit_or_thin = static_cast<std::uint16_t>(line.integer("the kind of a beam", 0, 3));
  }
  content_.keyframe_graph.keyframes.back().scans.push_back(std::move(scan));
}

void Reader::read_step(Line& line) {
  KeyframeGraphData& keyframe_graph = content_.keyframe_graph;
  const auto stamp = Time(line.integer("stamp", 0, kLatest));
  if (!keyframe_graph.steps.empty() && stamp <= keyframe_graph.steps.back().stamp) {
    line.fail(fmt::format("time must go on from step to step: {} ns after {} ns", stamp.count(),
                          keyframe_graph.steps.back().stamp.count()));
  }
  keyframe_graph.steps.push_back({stamp, keyframe_graph.newest(), line.pose("a pose")});
}

void Reader::read_constraint(Line& line) {
  Constraint c;
  const std::int64_t newest = content_.keyframe_graph.newest();
  c.from = static_cast<int>(line.integer("a keyframe", 0, newest));
  c.to = static_cast<int>(line.integer("a keyframe", 0, newest));
  c.from_from_to = line.pose("a pose");
  for (int row = 0; row < 3; ++row) {
    for (int column = row; column < 3; ++column) {
      c.information(row, column) = c.information(column, row) = line.number("the information");
    }
  }
  c.doubtful = line.integer("whether a loop was closed", 0, 1) == 1;
  try {
    content_.keyframe_graph.graph.add_constraint(c);
  } catch (const ContractError& error) {
    line.fail(error.what());
  }
}

}  // namespace

void write_slam_file(const std::filesystem::path& path, const SlamFile& content) {
  const auto& [config, range_bias, keyframe_graph] = content;
  std::string text = fmt::format("{}\n{}", kFirstLine, kComments);
  const auto to = std::back_inserter(text);
  fmt::format_to(to, "lidar {} {} {} {}\n", text_of(config.base_from_lidar), config.range_max, range_bias,
                 config.range_bias_sigma);
  fmt::format_to(to, "map {}\nodometry {} {} {}\n", config.resolution, config.distance_sigma, config.position_drift,
                 config.heading_drift);
  auto step = keyframe_graph.steps.begin();
  for (int k = 0; k <= keyframe_graph.newest(); ++k) {
    write_keyframe(keyframe_graph, k, text);
    for (; step != keyframe_graph.steps.end() && step->keyframe == k; ++step) {
      fmt::format_to(to, "step {} {}\n", step->stamp.count(), text_of(step->keyframe_from_base));
    }
  }
  for (const Constraint& c : keyframe_graph.graph.constraints()) {
    const Eigen::Matrix3d& i = c.information;
    fmt::format_to(to, "constraint {} {} {} {} {} {} {} {} {} {}\n", c.from, c.to, text_of(c.from_from_to), i(0, 0),
                   i(0, 1), i(0, 2), i(1, 1), i(1, 2), i(2, 2), c.doubtful ? 1 : 0);
  }
  text += "end\n";

  std::filesystem::path beside = path;
  beside += ".part";
  std::ofstream file(beside, std::ios::binary);
  file << text;
  file.close();
  std::error_code error;
  if (file) std::filesystem::rename(beside, path, error);
  if (!file || error) {
    std::error_code ignored;
    std::filesystem::remove(beside, ignored);
    throw ConfigError(fmt::format("{}: the map cannot be written there{}", path.string(),
                                  error ? ": " + error.message() : std::string()));
  }
}

SlamFile read_slam_file(const std::filesystem::path& path) { return Reader(path).read(); }
}  // namespace threewe::slam
