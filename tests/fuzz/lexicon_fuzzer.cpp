// The words of a language, by which one instruction is read.
#include "fuzz.hpp"
#include "language/lexicon.hpp"
#include "threewe/language/command.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace threewe;
  const std::string text(reinterpret_cast<const char*>(data), size);
  fuzz::read(text, [&] {
    const language::Lexicon lexicon = language::Lexicon::parse(text, "fuzz.yaml");
    (void)language::read("go to the kitchen, then find the red chair", lexicon, {});
  });
  return 0;
}
