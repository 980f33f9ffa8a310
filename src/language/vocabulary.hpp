// Vocabulary and word embeddings of instructions. Read from assets/languages/english_v1.yaml.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace threewe::language {

inline constexpr std::size_t kMostTokens = 48;     ///< of an instruction
inline constexpr std::size_t kEmbeddingSize = 64;  ///< of an instruction's embedding
inline constexpr std::int32_t kPadding = 0;        ///< the token behind the last word
inline constexpr std::int32_t kUnknownWord = 1;    ///< the token of a word that is not in the vocabulary

/// The words of a text in lower case, as they follow one another: letters, digits and apostrophes. The rest is left
/// out.
std::vector<std::string> words_of(std::string_view text);

/// A text as a vector of length 1, whatever its words: signed feature hashing (Weinberger et al. 2009). For every word,
/// and every two words in a row joined by a space, h is the 64-bit FNV-1a hash of the bytes; -1 is added where bit 32
/// of h is set, else +1, to component h mod 64. A text without words is the zero vector.
std::array<float, kEmbeddingSize> embedding_of(std::string_view text);

/// A versioned vocabulary and names. Const once read.
class Language {
 public:
  /// Reads assets/languages/NAME.yaml. Throws ConfigError with file:line.
  static Language load(std::string_view name = "english_v1");

  int version() const { return version_; }
  /// All words; word i has the number i + 2.
  const std::vector<std::string>& words() const { return words_; }
  /// The number of a word, or `kUnknownWord`.
  std::int32_t token(std::string_view word) const;
  /// The first 48 words of a text as numbers, `kPadding` behind the last.
  std::array<std::int32_t, kMostTokens> tokens(std::string_view text) const;

  /// What a room is called, by its name in the scene: "living_room" is the "living room".
  std::string room(std::string_view name) const;
  /// What a thing is called by its category: "chair".
  std::string thing(std::string_view category) const;
  /// What it is called by its shape, as in "armchair"; where that has no name of its own, by its category.
  std::string thing(std::string_view category, std::string_view shape) const;
  /// What things are called by their shape, by (category, shape).
  const std::map<std::pair<std::string, std::string>, std::string>& nouns() const { return nouns_; }

 private:
  int version_ = 0;
  std::vector<std::string> words_;
  std::map<std::string, std::int32_t, std::less<>> tokens_;
  std::map<std::string, std::string, std::less<>> rooms_;
  std::map<std::pair<std::string, std::string>, std::string> nouns_;
};

}  // namespace threewe::language
