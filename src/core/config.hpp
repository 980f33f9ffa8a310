// YAML configuration reader whose every mistake is one clear error: file:line, what is wrong, what would be right.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <yaml-cpp/yaml.h>

#include "threewe/core/pose.hpp"

namespace threewe {

/// Bounds that no robot and no place in a file passes. What is beyond them would take all memory, or hours to check.
inline constexpr double kFarthest = 1000.0;             ///< [m] from the origin
inline constexpr std::size_t kMostItems = 1000;         ///< of one list
inline constexpr std::size_t kLargestFile = 1U << 20U;  ///< [bytes]

/// One YAML node together with where it stands. Reading a field marks it as known; `finish` refuses the rest.
class ConfigNode {
 public:
  /// Parses a file. Throws ConfigError with file:line when it is missing, malformed or huge.
  static ConfigNode load(const std::filesystem::path& file);
  /// The text of a file, for `parse`; of a huge one no more than that refuses. Throws ConfigError when it is missing.
  static std::string read(const std::filesystem::path& file);
  /// Parses text; `name` stands for the file in messages.
  static ConfigNode parse(const std::string& text, const std::string& name);

  bool has(std::string_view field);
  /// The node of a field. Throws ConfigError when it is absent, naming the field that may have been meant to be it.
  ConfigNode at(std::string_view field);
  /// The items of a sequence, or ConfigError when they are more than `most`.
  std::vector<ConfigNode> items(std::size_t most = kMostItems) const;
  /// The fields of a mapping whose names are the file's to choose, in order, at most kMostItems and none of them twice.
  std::vector<std::pair<std::string, ConfigNode>> fields() const;

  bool is_number() const;
  bool is_list() const;
  bool is_map() const;
  double number() const;                            ///< finite, or ConfigError
  double number_in(double low, double high) const;  ///< within [low, high], or ConfigError
  int integer_in(int low, int high) const;          ///< the same, and whole
  bool boolean() const;
  std::string text() const;  ///< without control characters but tabs and line feeds, or ConfigError
  std::string name() const;  ///< that other formats and file systems take too (`is_name`), or ConfigError
  Vec2 vec2(double limit = kFarthest) const;    ///< [x, y], each within +-limit
  Pose2D pose(double limit = kFarthest) const;  ///< [x, y, theta], theta in radians; theta may be left out

  double number(std::string_view field) { return at(field).number(); }
  double number(std::string_view field, double fallback) { return has(field) ? at(field).number() : fallback; }
  double number_in(std::string_view field, double low, double high) { return at(field).number_in(low, high); }
  int integer_in(std::string_view field, int low, int high) { return at(field).integer_in(low, high); }
  std::string text(std::string_view field) { return at(field).text(); }
  std::string text(std::string_view field, std::string fallback) {
    return has(field) ? at(field).text() : std::move(fallback);
  }
  std::string name(std::string_view field) { return at(field).name(); }
  /// One of `choices`, or ConfigError with the nearest of them.
  std::string choice(std::string_view field, const std::vector<std::string>& choices);

  /// Throws ConfigError when the mapping has a field that was not asked for, naming the nearest known one, or one
  /// twice.
  void finish() const;
  /// Where it stands, for messages: "file:line: path".
  std::string place() const;
  /// Throws ConfigError at this node's place.
  [[noreturn]] void fail(const std::string& what) const;

 private:
  ConfigNode(const YAML::Node& node, std::string file, std::string path, int line);
  YAML::Node node_;
  std::string file_;
  std::string path_;
  int line_;
  std::vector<std::string> known_;  // fields that `at` or `has` was asked for
  void know(std::string_view field);
  void refuse_repeated_fields() const;
  [[noreturn]] void fail_missing(std::string_view field) const;
  std::string field_name(const YAML::Node& key) const;
};

}  // namespace threewe
