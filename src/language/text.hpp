// Tokenizer of commands: tokens in lower case, numbers and punctuation, each with its place in the text.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace threewe::language {

/// One word, number or mark of a text.
struct Token {
  enum class Kind : std::uint8_t { word, number, mark };
  Kind kind = Kind::mark;
  std::string text;          ///< a word in lower case; a mark is one of , . ; : ! ? ( ) " - / =
  double value = 0.0;        ///< of a number
  std::size_t begin = 0;     ///< [bytes] where it stands in the text
  std::size_t end = 0;       ///< [bytes] behind its last byte
  std::u32string letters{};  ///< of a word, for edit distances
};

/// The tokens of a text. Hyphens within words separate them, apostrophes belong to them; digits before letters are a
/// number and a unit. What is no letter, digit or mark, such as a control character, is a word of its own that no
/// lexicon has; bytes that are no UTF-8 are U+FFFD.
std::vector<Token> tokens_of(std::string_view text);

/// Characters of a text; each byte that is not part of UTF-8 counts as one.
std::size_t count_characters(std::string_view text);
/// Whether a text is UTF-8.
bool is_utf8(std::string_view text);
/// In lower case: Latin, Greek and Cyrillic letters.
std::string lower_case(std::string_view text);

}  // namespace threewe::language
