// Plans, said in drawn words, are read as themselves.
#include <doctest/doctest.h>

#include <cstdint>
#include <string>

#include "draw.hpp"
#include "language/command_draws.hpp"
#include "threewe/language/command.hpp"

namespace threewe::language {
namespace {

TEST_CASE("drawn commands are read as the plans that they say") {
  const testing::CommandPhrases phrases;
  const Lexicon lexicon = Lexicon::load();
  for (std::uint64_t seed = 0; seed < cases(600); ++seed) {
    testing::CommandDraws draws(phrases, seed);
    const testing::DrawnCommand command = draws.draw();
    CAPTURE(seed);
    CAPTURE(command.text);
    CHECK(to_text(read(command.text, lexicon, testing::CommandDraws::places())) == command.meant);
  }
}

}  // namespace
}  // namespace threewe::language
