#include "core/config.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <fstream>
#include <map>
#include <sstream>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>

#include "core/names.hpp"
#include "threewe/core/errors.hpp"

namespace threewe {
namespace {

constexpr double kTurn = 6.2832;  // [rad], as files write it

// Where the first byte stands that cannot be part of UTF-8 text (RFC 3629), or is zero, for which yaml-cpp takes a text
// for UTF-16 or UTF-32; the text's size where there is none.
std::size_t find_not_utf8(std::string_view text) {
  for (std::size_t i = 0; i < text.size();) {
    const auto byte = [&](std::size_t k) { return k < text.size() ? static_cast<unsigned char>(text[k]) : 0U; };
    const auto first = byte(i);
    const std::size_t more = first == 0     ? 9
                             : first < 0x80 ? 0
                             : first < 0xC2 ? 9
                             : first < 0xE0 ? 1
                             : first < 0xF0 ? 2
                             : first < 0xF5 ? 3
                                            : 9;
    if (more == 9) return i;
    for (std::size_t k = 1; k <= more; ++k) {
      if ((byte(i + k) & 0xC0U) != 0x80U) return i;
    }
    const unsigned second = byte(i + 1);  // overlong, a surrogate, or beyond the last character
    if ((first == 0xE0 && second < 0xA0) || (first == 0xED && second > 0x9F) || (first == 0xF0 && second < 0x90) ||
        (first == 0xF4 && second > 0x8F)) {
      return i;
    }
    i += more + 1;
  }
  return text.size();
}

// An empty document stands nowhere.
int line_of(const YAML::Node& node) { return std::max(node.Mark().line, 0) + 1; }

// Where the first two documents of a text begin. YAML::LoadAll would never end on a text with a stray ',' or '}', each
// of which it takes for one document after the other, all empty.
class Documents final : public YAML::EventHandler {
 public:
  std::vector<YAML::Mark> beginnings;

  void OnDocumentStart(const YAML::Mark& mark) override { beginnings.push_back(mark); }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark&, YAML::anchor_t) override {}
  void OnAlias(const YAML::Mark&, YAML::anchor_t) override {}
  void OnScalar(const YAML::Mark&, const std::string&, YAML::anchor_t, const std::string&) override {}
  void OnSequenceStart(const YAML::Mark&, const std::string&, YAML::anchor_t, YAML::EmitterStyle::value) override {}
  void OnSequenceEnd() override {}
  void OnMapStart(const YAML::Mark&, const std::string&, YAML::anchor_t, YAML::EmitterStyle::value) override {}
  void OnMapEnd() override {}
};

std::vector<YAML::Mark> beginnings_of_documents(const std::string& text) {
  std::istringstream stream(text);
  YAML::Parser parser(stream);
  Documents documents;
  while (documents.beginnings.size() < 2 && parser.HandleNextDocument(documents)) {
  }
  return documents.beginnings;
}

}  // namespace

ConfigNode::ConfigNode(const YAML::Node& node, std::string file, std::string path, int line)
    : node_(node), file_(std::move(file)), path_(std::move(path)), line_(line) {}

ConfigNode ConfigNode::load(const std::filesystem::path& file) { return parse(read(file), file.string()); }

std::string ConfigNode::read(const std::filesystem::path& file) {
  std::error_code error;
  const bool is_file = std::filesystem::is_regular_file(file, error);
  const auto bytes = is_file ? std::filesystem::file_size(file, error) : 0;
  std::string text(std::min<std::uintmax_t>(bytes, kLargestFile + 1), '\0');
  if (!is_file || !std::ifstream(file).read(text.data(), static_cast<std::streamsize>(text.size()))) {
    throw ConfigError(fmt::format("{}: cannot be read", file.string()));
  }
  return text;
}

ConfigNode ConfigNode::parse(const std::string& text, const std::string& name) {
  const auto refuse = [&name](int line, std::string_view what) {
    throw ConfigError(fmt::format("{}:{}: {}", name, std::max(line, 0) + 1, what));
  };
  if (text.size() > kLargestFile) {
    refuse(0, fmt::format("the file is larger than {} bytes", kLargestFile));
  }
  if (const std::size_t at = find_not_utf8(text); at < text.size()) {
    const auto line = std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n');
    refuse(static_cast<int>(line), "expected UTF-8 text; save the file as that");
  }
  try {
    const std::vector<YAML::Mark> documents = beginnings_of_documents(text);
    if (documents.size() > 1) {
      const bool stuck = documents[0].pos == documents[1].pos;
      refuse(documents[1].line,
             stuck ? "malformed YAML: nothing can begin like this" : "expected one document; a second begins here");
    }
    const YAML::Node node = YAML::Load(text);
    return {node, name, "", line_of(node)};
  } catch (const YAML::Exception& error) {
    throw ConfigError(fmt::format("{}:{}: malformed YAML: {}", name, std::max(error.mark.line, 0) + 1, error.msg));
  }
}

std::string ConfigNode::place() const {
  return path_.empty() ? fmt::format("{}:{}", file_, line_) : fmt::format("{}:{}: {}", file_, line_, path_);
}

void ConfigNode::fail(const std::string& what) const { throw ConfigError(fmt::format("{}: {}", place(), what)); }

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

std::vector<ConfigNode> ConfigNode::items(std::size_t most) const {
  if (!node_.IsSequence()) fail("expected a list");
  if (node_.size() > most) fail(fmt::format("a list of {} items; at most {} are read", node_.size(), most));
  std::vector<ConfigNode> items;
  for (std::size_t i = 0; i < node_.size(); ++i) {
    const YAML::Node item = node_[i];
    items.push_back(ConfigNode(item, file_, fmt::format("{}[{}]", path_, i), line_of(item)));
  }
  return items;
}

std::vector<std::pair<std::string, ConfigNode>> ConfigNode::fields() const {
  refuse_repeated_fields();
  if (node_.size() > kMostItems) fail(fmt::format("{} fields; at most {} are read", node_.size(), kMostItems));
  ConfigNode reader = *this;
  std::vector<std::pair<std::string, ConfigNode>> fields;
  for (const auto& entry : node_) {
    const std::string name = field_name(entry.first);
    fields.emplace_back(name, reader.at(name));
  }
  return fields;
}

bool ConfigNode::is_number() const { return node_.IsScalar(); }
bool ConfigNode::is_list() const { return node_.IsSequence(); }
bool ConfigNode::is_map() const { return node_.IsMap(); }

double ConfigNode::number() const {
  double value = 0.0;
  if (!node_.IsScalar() || !YAML::convert<double>::decode(node_, value)) fail("expected a number");
  if (!std::isfinite(value)) fail("expected a finite number");
  return value;
}

double ConfigNode::number_in(double low, double high) const {
  const double value = number();
  if (value < low || value > high) fail(fmt::format("{} is outside [{}, {}]", value, low, high));
  return value;
}

int ConfigNode::integer_in(int low, int high) const {
  std::int64_t value = 0;
  if (!node_.IsScalar() || !YAML::convert<std::int64_t>::decode(node_, value)) fail("expected a whole number");
  if (value < low || value > high) fail(fmt::format("{} is outside [{}, {}]", value, low, high));
  return static_cast<int>(value);
}

bool ConfigNode::boolean() const {
  bool value = false;
  if (!node_.IsScalar() || !YAML::convert<bool>::decode(node_, value)) fail("expected true or false");
  return value;
}

std::string ConfigNode::text() const {
  if (!node_.IsScalar()) fail("expected text");
  if (!is_text(node_.Scalar())) fail("expected text without control characters");
  return node_.Scalar();
}

std::string ConfigNode::name() const {
  if (!node_.IsScalar() || !is_name(node_.Scalar())) fail(not_a_name(node_.IsScalar() ? node_.Scalar() : ""));
  return node_.Scalar();
}

Vec2 ConfigNode::vec2(double limit) const {
  const auto values = items();
  if (values.size() != 2) fail("expected [x, y]");
  return {values[0].number_in(-limit, limit), values[1].number_in(-limit, limit)};
}

Pose2D ConfigNode::pose(double limit) const {
  const auto values = items();
  if (values.size() != 2 && values.size() != 3) fail("expected [x, y, theta]");
  const Vec2 position{values[0].number_in(-limit, limit), values[1].number_in(-limit, limit)};
  // whole turns make no sense: such a heading is most likely in degrees
  const double theta = values.size() == 3 ? values[2].number_in(-kTurn, kTurn) : 0.0;
  return {position.x, position.y, wrap_angle(theta)};
}

std::string ConfigNode::choice(std::string_view field, const std::vector<std::string>& choices) {
  const ConfigNode node = at(field);
  const std::string value = node.text();
  if (std::ranges::find(choices, value) == choices.end()) node.fail(unknown_name(field, value, choices));
  return value;
}

void ConfigNode::finish() const {
  refuse_repeated_fields();
  for (const auto& entry : node_) {
    const std::string name = field_name(entry.first);
    if (std::ranges::find(known_, name) != known_.end()) continue;
    ConfigNode(entry.first, file_, path_, line_of(entry.first)).fail(unknown_name("field", name, known_));
  }
}

void ConfigNode::refuse_repeated_fields() const {
  if (!node_.IsMap()) fail("expected a mapping");
  std::map<std::string, int> lines;
  for (const auto& entry : node_) {
    const std::string name = field_name(entry.first);
    const auto [first, is_new] = lines.emplace(name, line_of(entry.first));
    if (is_new) continue;
    const ConfigNode again(entry.first, file_, path_, line_of(entry.first));
    again.fail(fmt::format("field '{}' stands twice, first in line {}", name, first->second));
  }
}

std::string ConfigNode::field_name(const YAML::Node& key) const {
  if (!key.IsScalar()) ConfigNode(key, file_, path_, line_of(key)).fail("a field's name must be text");
  return key.Scalar();
}

}  // namespace threewe
