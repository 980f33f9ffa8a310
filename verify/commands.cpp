// Draws commands and counts how they are read: verify_commands SEED COUNT.
#include <cstdint>
#include <cstdio>
#include <string>

#include "language/command_draws.hpp"
#include "number.hpp"
#include "threewe/language/command.hpp"

using namespace threewe;

int main(int argc, char** argv) {
  const auto seed = parse_number(argc == 3 ? argv[1] : "");
  const auto count = parse_number(argc == 3 ? argv[2] : "");
  if (!seed || !count) {
    std::fputs("usage: verify_commands SEED COUNT\n", stderr);
    return 2;
  }
  const testing::CommandPhrases phrases;
  const language::Lexicon lexicon = language::Lexicon::load();
  testing::CommandDraws draws(phrases, *seed);
  int right = 0;
  int wrong_plan = 0;
  for (std::uint64_t i = 0; i < *count; ++i) {
    const testing::DrawnCommand command = draws.draw();
    const language::Reading reading = language::read(command.text, lexicon, testing::CommandDraws::places());
    const std::string read = to_text(reading);
    if (read == command.meant) {
      ++right;
      continue;
    }
    wrong_plan += reading.outcome == language::ReadingOutcome::understood ? 1 : 0;
    std::printf("lost %s => %s, not %s\n", command.text.c_str(), read.c_str(), command.meant.c_str());
  }
  std::printf("right %d\nwrong_plan %d\n", right, wrong_plan);
}
