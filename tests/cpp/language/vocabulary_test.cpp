// Words as numbers: what networks have learnt must not change behind their backs.
#include "language/vocabulary.hpp"

#include <doctest/doctest.h>

#include <cstdint>
#include <set>

#include "core/exact.hpp"
#include "draw.hpp"

namespace threewe::language {
namespace {

using Embedding = std::array<float, kEmbeddingSize>;

std::uint64_t fnv1a(const std::string& bytes) {
  std::uint64_t hash = 14695981039346656037ULL;
  for (const char c : bytes) {
    hash ^= static_cast<unsigned char>(c);
    hash *= 1099511628211ULL;
  }
  return hash;
}

TEST_CASE("words are lower case, without punctuation") {
  CHECK(words_of("Turn left, THEN enter the children's room 2.") ==
        std::vector<std::string>{"turn", "left", "then", "enter", "the", "children's", "room", "2"});
  CHECK(words_of(" ... ").empty());
  CHECK(words_of("").empty());
}

TEST_CASE("the numbers of version 1 never change") {
  const Language language = Language::load("english_v1");
  CHECK(language.version() == 1);
  std::string all;
  for (const std::string& word : language.words()) all += word + "\n";
  CHECK(fnv1a(all) == 9871982537445923641ULL);  // after a change on purpose: a new file with a new version
  CHECK(language.token(language.words().front()) == 2);
  CHECK(language.token(language.words().back()) == static_cast<std::int32_t>(language.words().size()) + 1);
}

TEST_CASE("tokens are padded, cut off, and 1 for unknown words") {
  const Language language = Language::load();
  const auto tokens = language.tokens("Go xyzzy left");
  CHECK(tokens[0] == language.token("go"));
  CHECK(tokens[1] == kUnknownWord);
  CHECK(tokens[2] == language.token("left"));
  for (std::size_t i = 3; i < tokens.size(); ++i) CHECK(tokens[i] == kPadding);
  std::string text;
  for (int i = 0; i < 60; ++i) text += "left ";
  CHECK(language.tokens(text).back() == language.token("left"));
}

TEST_CASE("names of rooms and things") {
  const Language language = Language::load();
  CHECK(language.room("living_room") == "living room");
  CHECK(language.room("children") == "children's room");
  CHECK(language.room("children_2") == "children's room 2");
  CHECK(language.room("room_101") == "room 101");
  CHECK(language.room("7") == "7");
  CHECK(language.thing("chair", "tub") == "armchair");
  CHECK(language.thing("chair", "of_my_own") == "chair");
  CHECK(language.thing("coat_rack") == "coat rack");
}

TEST_CASE("an embedding is a sum of hashed words and pairs of words, of length 1") {
  // FNV-1a of "a" is af63dc4c8601ec8c (Fowler, Noll & Vo): component 12, bit 32 clear
  Embedding expected{};
  expected[12] = 1.0F;
  CHECK(embedding_of("a") == expected);
  CHECK(embedding_of("A!") == expected);
  CHECK(embedding_of("") == Embedding{});
  CHECK(embedding_of("turn left") != embedding_of("left turn"));

  const std::vector<std::string> words = Language::load().words();
  for (std::uint64_t seed = 0; seed < cases(300); ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    std::vector<std::string> drawn;
    std::string text;
    for (int i = draw.whole(1, 48); i > 0; --i) {
      drawn.push_back(words[static_cast<std::size_t>(draw.whole(0, static_cast<int>(words.size()) - 1))]);
      text += drawn.back() + (i % 3 == 0 ? ", " : " ");
    }
    std::vector<std::string> grams = drawn;
    for (std::size_t i = 1; i < drawn.size(); ++i) grams.push_back(drawn[i - 1] + " " + drawn[i]);
    std::array<double, kEmbeddingSize> sums{};
    for (const std::string& gram : grams) sums.at(fnv1a(gram) % 64) += (fnv1a(gram) & 0x100000000ULL) != 0 ? -1 : 1;
    double squares = 0.0;
    for (const double s : sums) squares += s * s;
    double length = 0.0;
    const Embedding embedding = embedding_of(text);
    for (std::size_t i = 0; i < kEmbeddingSize; ++i) {
      if (squares > 0.0) CHECK(embedding[i] == doctest::Approx(sums[i] / exact::sqrt(squares)));
      length += static_cast<double>(embedding[i]) * static_cast<double>(embedding[i]);
    }
    if (squares > 0.0) CHECK(length == doctest::Approx(1.0));
  }
}

}  // namespace
}  // namespace threewe::language
