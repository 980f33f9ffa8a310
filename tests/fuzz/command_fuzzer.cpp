// Commands: the first line is a text, the others are known places.
#include <algorithm>
#include <string>
#include <vector>

#include "fuzz.hpp"
#include "threewe/core/errors.hpp"
#include "threewe/language/command.hpp"

THREEWE_FUZZER(command)(std::string_view input) {
  using namespace threewe;
  static const language::Lexicon lexicon = language::Lexicon::load();
  std::vector<std::string> lines(1);
  for (const char c : input) {
    if (c == '\n') lines.emplace_back();
    if (c != '\n') lines.back() += c;
  }
  const std::string text = lines.front();
  lines.erase(lines.begin());
  fuzz::read(text, [&] {
    try {
      (void)to_text(language::read(text, lexicon, lines));
    } catch (const ContractError& error) {  // too long, or no name
      throw ConfigError(std::string("fuzz.yaml:1: ") + error.what());
    }
  });
}
