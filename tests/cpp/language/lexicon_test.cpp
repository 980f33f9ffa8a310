// Mistakes in lexicons are one error each, with file and line.
#include <doctest/doctest.h>

#include <string>

#include "core/config.hpp"
#include "threewe/core/assets.hpp"
#include "threewe/core/errors.hpp"
#include "threewe/language/command.hpp"

namespace threewe::language {
namespace {

std::string file() { return ConfigNode::read(find_asset("languages", "commands_english_v1")); }

// What is said of the file after a change.
std::string error_with(const std::string& old, const std::string& changed) {
  std::string text = file();
  const std::size_t at = text.find(old);
  REQUIRE(at != std::string::npos);
  text.replace(at, old.size(), changed);
  try {
    Lexicon::parse(text, "x.yaml");
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST_CASE("the lexicon that comes with the library is read") { CHECK_NOTHROW(Lexicon::parse(file(), "x.yaml")); }

TEST_CASE("mistakes are named with their place") {
  const std::string unknown_group = error_with("<reach> TARGET", "<raech> TARGET");
  CHECK(has(unknown_group, "x.yaml:"));
  CHECK(has(unknown_group, "did you mean 'reach'"));
  CHECK(has(error_with("<reach> TARGET", "<reach> TRAGET"), "unknown slot 'TRAGET'; did you mean 'TARGET'"));
  CHECK(has(error_with("<reach> TARGET", "<reach TARGET"), "expected '>'"));
  CHECK(has(error_with("<reach> TARGET", "<reach> (TARGET"), "expected ')'"));
  CHECK(has(error_with("<reach> TARGET", "<reach> TARGET)"), "closes nothing"));
  CHECK(has(error_with("<reach> TARGET", "( | TARGET)"), "is empty"));
  CHECK(has(error_with("  turn_around:\n", "  turn_aruond:\n"), "turn_aruond"));
  CHECK(has(error_with("fastest: 0.5", "fastest: fast"), "fastest: expected a number"));
  CHECK(has(error_with("version: 1", "version: one"), "x.yaml:"));
  CHECK(has(error_with("numbered: [room]", "numbered: [\"\"]"), "cannot be empty"));
  CHECK(has(error_with("groups:\n", "groups:\n  polite: [please]\n"), "has another meaning"));
  CHECK(has(error_with("  minus: [minus, negative]\n", ""), "missing field 'minus'"));
}

}  // namespace
}  // namespace threewe::language
