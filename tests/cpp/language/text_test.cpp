// The tokenizer of commands.
#include "language/text.hpp"

#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "draw.hpp"

namespace threewe::language {
namespace {

std::string tokens(const std::string& text) {
  std::string all;
  for (const Token& token : tokens_of(text)) {
    const char kind = token.kind == Token::Kind::word ? 'w' : token.kind == Token::Kind::number ? 'n' : 'm';
    all += kind + token.text + " ";
  }
  return all;
}

TEST_CASE("words, numbers and marks") {
  CHECK(tokens("Go to the Kitchen!") == "wgo wto wthe wkitchen m! ");
  CHECK(tokens("75cm, 0.5 m.") == "n75 wcm m, n0.5 wm m. ");
  CHECK(tokens("(2,-1.5)") == "m( n2 m, m- n1.5 m) ");
  CHECK(tokens("keep-out office-2 x-1") == "wkeep wout woffice n2 wx m- n1 ");
  CHECK(tokens("don’t 'copy room'") == "wdon't m\" wcopy wroom m\" ");
  CHECK(tokens("room101 living_room") == "wroom101 wliving wroom ");
  CHECK(tokens("3 m/s 90°") == "n3 wm m/ ws n90 w° ");
  CHECK(tokens("ÄÖÜ Кухня ΩΣ") == "wäöü wкухня wωσ ");
  CHECK(tokens("a\x01\xff") == "wa w\xEF\xBF\xBD w\xEF\xBF\xBD ");
  CHECK(tokens("").empty());
}

TEST_CASE("numbers are what they say") {
  for (std::uint64_t seed = 0; seed < cases(300); ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    const int hundredths = draw.whole(0, 99999);
    const std::string text =
        std::to_string(hundredths / 100) + "." + (hundredths % 100 < 10 ? "0" : "") + std::to_string(hundredths % 100);
    CHECK(tokens_of(text).at(0).value == std::stod(text));
  }
}

TEST_CASE("tokens cover what they were read from, whatever the bytes") {
  for (std::uint64_t seed = 0; seed < cases(2000); ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    std::string text;
    for (int i = draw.whole(0, 40); i > 0; --i) text += static_cast<char>(draw.whole(0, 255));
    std::size_t end = 0;
    for (const Token& token : tokens_of(text)) {
      CHECK(token.begin >= end);
      CHECK(token.end > token.begin);
      CHECK(is_utf8(token.text));
      end = token.end;
    }
    CHECK(end <= text.size());
    CHECK(is_utf8(lower_case(text)));
    CHECK(count_characters(text) <= text.size());
  }
}

}  // namespace
}  // namespace threewe::language
