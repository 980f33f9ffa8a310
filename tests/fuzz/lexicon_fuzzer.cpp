// The words of a language, by which one instruction is read.
#include "fuzz.hpp"
#include "language/lexicon.hpp"
#include "threewe/language/command.hpp"

THREEWE_FUZZER(lexicon)(std::string_view input) {
  using namespace threewe;
  const std::string text(input);
  fuzz::read(text, [&] {
    const language::Lexicon lexicon = language::Lexicon::parse(text, "fuzz.yaml");
    (void)language::read("go to the kitchen, then find the red chair", lexicon, {});
  });
}
