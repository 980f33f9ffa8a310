// Reading configuration files so that every mistake is one clear error: file:line, what is wrong, what would be right.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <yaml-cpp/yaml.h>

#include "threewe/core/pose.hpp"

namespace threewe {

/// One YAML node together with where it stands. Reading a field marks it as known; `finish` refuses the rest.
class ConfigNode {
 public:
  /// Parses a file. Throws ConfigError with file:line when it is missing or malformed.
  static ConfigNode load(const std::filesystem::path& file);
  /// Parses text; `name` stands for the file in messages.
  static ConfigNode parse(const std::string& text, const std::string& name);

  bool has(std::string_view field);
  /// The node of a field. Throws ConfigError when it is absent, naming the field that may have been meant to be it.
  ConfigNode at(std::string_view field);
  /// The items of a sequence.
  std::vector<ConfigNode> items() const;
  /// The fields of a mapping, in order.
  std::vector<std::pair<std::string, ConfigNode>> fields();

  double number() const;  ///< finite, or ConfigError
  std::int64_t integer() const;
  bool boolean() const;
  std::string text() const;
  Vec2 vec2() const;    ///< [x, y]
  Pose2D pose() const;  ///< [x, y, theta], theta in radians; theta may be left out

  double number(std::string_view field) { return at(field).number(); }
  double number(std::string_view field, double fallback) { return has(field) ? at(field).number() : fallback; }
  /// A number that must lie in [low, high].
  double number_in(std::string_view field, double low, double high);
  std::string text(std::string_view field) { return at(field).text(); }
  std::string text(std::string_view field, std::string fallback) {
    return has(field) ? at(field).text() : std::move(fallback);
  }
  /// One of `choices`, or ConfigError with the nearest of them.
  std::string choice(std::string_view field, const std::vector<std::string>& choices);

  /// Throws ConfigError when the mapping has a field that nobody asked for, naming the nearest known one, or one twice.
  void finish() const;
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
  [[noreturn]] void fail_missing(std::string_view field) const;
  std::string field_name(const YAML::Node& key) const;
};

}  // namespace threewe
