#include "threewe/core/config.hpp"

#include <algorithm>
#include <array>
#include <fstream>
#include <map>
#include <sstream>
#include <utility>

#include <fmt/format.h>

#include "threewe/core/errors.hpp"
#include "threewe/core/names.hpp"

namespace threewe {
namespace {

// An empty document stands nowhere.
int line_of(const YAML::Node& node) { return std::max(node.Mark().line, 0) + 1; }

}  // namespace

ConfigNode::ConfigNode(const YAML::Node& node, std::string file, std::string path, int line)
    : node_(node), file_(std::move(file)), path_(std::move(path)), line_(line) {}

ConfigNode ConfigNode::load(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::ostringstream text;
  if (!std::filesystem::is_regular_file(file) || !stream) {
    throw ConfigError(fmt::format("{}: cannot be read", file.string()));
  }
  text << stream.rdbuf();
  return parse(text.str(), file.string());
}

ConfigNode ConfigNode::parse(const std::string& text, const std::string& name) {
  try {
    const YAML::Node node = YAML::Load(text);
    return {node, name, "", line_of(node)};
  } catch (const YAML::Exception& error) {
    throw ConfigError(fmt::format("{}:{}: malformed YAML: {}", name, error.mark.line + 1, error.msg));
  }
}

void ConfigNode::fail(const std::string& what) const {
  const std::string where = path_.empty() ? "" : fmt::format("{}: ", path_);
  throw ConfigError(fmt::format("{}:{}: {}{}", file_, line_, where, what));
}

void ConfigNode::know(std::string_view field) {
  if (!node_.IsMap()) fail("expected a mapping");
  if (std::ranges::find(known_, field) == known_.end()) known_.emplace_back(field);
}

bool ConfigNode::has(std::string_view field) {
  know(field);
  return std::as_const(node_)[std::string(field)].IsDefined();
}

ConfigNode ConfigNode::at(std::string_view field) {
  if (!has(field)) fail_missing(field);
  const std::string path = path_.empty() ? std::string(field) : fmt::format("{}.{}", path_, field);
  const YAML::Node value = std::as_const(node_)[std::string(field)];
  if (!value.IsNull()) return {value, file_, path, line_of(value)};

  // the parser places a value that was left out where the next field begins
  int line = line_;
  for (const auto& entry : node_) {
    if (entry.first.IsScalar() && entry.first.Scalar() == field) line = line_of(entry.first);
  }
  return {value, file_, path, line};
}

void ConfigNode::fail_missing(std::string_view field) const {
  for (const auto& entry : node_) {
    const std::string name = field_name(entry.first);
    const bool unknown = std::ranges::find(known_, name) == known_.end();
    if (!unknown || nearest_name(name, std::array{std::string(field)}).empty()) continue;
    const ConfigNode misspelt(entry.first, file_, path_, line_of(entry.first));
    misspelt.fail(fmt::format("missing field '{}'; is '{}' meant to be it?", field, name));
  }
  fail(fmt::format("missing field '{}'", field));
}

std::vector<ConfigNode> ConfigNode::items() const {
  if (!node_.IsSequence()) fail("expected a list");
  std::vector<ConfigNode> items;
  for (std::size_t i = 0; i < node_.size(); ++i) {
    const YAML::Node item = node_[i];
    items.push_back(ConfigNode(item, file_, fmt::format("{}[{}]", path_, i), line_of(item)));
  }
  return items;
}

std::vector<std::pair<std::string, ConfigNode>> ConfigNode::fields() {
  if (!node_.IsMap()) fail("expected a mapping");
  std::vector<std::pair<std::string, ConfigNode>> fields;
  for (const auto& entry : node_) {
    const std::string name = field_name(entry.first);
    fields.emplace_back(name, at(name));
  }
  return fields;
}

double ConfigNode::number() const {
  double value = 0.0;
  if (!node_.IsScalar() || !YAML::convert<double>::decode(node_, value)) fail("expected a number");
  if (!std::isfinite(value)) fail("expected a finite number");
  return value;
}

std::int64_t ConfigNode::integer() const {
  std::int64_t value = 0;
  if (!node_.IsScalar() || !YAML::convert<std::int64_t>::decode(node_, value)) fail("expected a whole number");
  return value;
}

bool ConfigNode::boolean() const {
  bool value = false;
  if (!node_.IsScalar() || !YAML::convert<bool>::decode(node_, value)) fail("expected true or false");
  return value;
}

std::string ConfigNode::text() const {
  if (!node_.IsScalar()) fail("expected text");
  return node_.Scalar();
}

Vec2 ConfigNode::vec2() const {
  const auto values = items();
  if (values.size() != 2) fail("expected [x, y]");
  return {values[0].number(), values[1].number()};
}

Pose2D ConfigNode::pose() const {
  const auto values = items();
  if (values.size() != 2 && values.size() != 3) fail("expected [x, y, theta]");
  return {values[0].number(), values[1].number(), values.size() == 3 ? wrap_angle(values[2].number()) : 0.0};
}

double ConfigNode::number_in(std::string_view field, double low, double high) {
  const ConfigNode node = at(field);
  const double value = node.number();
  if (value < low || value > high) node.fail(fmt::format("{} is outside [{}, {}]", value, low, high));
  return value;
}

std::string ConfigNode::choice(std::string_view field, const std::vector<std::string>& choices) {
  const ConfigNode node = at(field);
  const std::string value = node.text();
  if (std::ranges::find(choices, value) == choices.end()) node.fail(unknown_name(field, value, choices));
  return value;
}

void ConfigNode::finish() const {
  if (!node_.IsMap()) fail("expected a mapping");
  std::map<std::string, int> lines;
  for (const auto& entry : node_) {
    const std::string name = field_name(entry.first);
    const ConfigNode field(entry.first, file_, path_, line_of(entry.first));
    const auto [first, is_new] = lines.emplace(name, line_of(entry.first));
    if (!is_new) field.fail(fmt::format("field '{}' stands twice, first in line {}", name, first->second));
    if (std::ranges::find(known_, name) == known_.end()) field.fail(unknown_name("field", name, known_));
  }
}

std::string ConfigNode::field_name(const YAML::Node& key) const {
  if (!key.IsScalar()) ConfigNode(key, file_, path_, line_of(key)).fail("a field's name must be text");
  return key.Scalar();
}

}  // namespace threewe
