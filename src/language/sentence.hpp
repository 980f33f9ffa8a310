// Lattice of a text: the tokens with every phrase of the lexicon that begins at each.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "language/lexicon.hpp"
#include "language/spelling.hpp"
#include "language/text.hpp"

namespace threewe::language {

/// A word, number or mark of a text, with what it may be read as.
struct Word {
  Token token;
  std::string read;  ///< the word as the lexicon has it: typos mended
  std::string base;  ///< what it is a form of, as "going" of "go"; empty where it is none
};

/// A phrase of the lexicon in a text.
struct Edge {
  std::size_t end = 0;  ///< the word behind it
  const Phrase* phrase = nullptr;
};

/// The name of a known place, as words.
struct PlaceName {
  std::string name;
  std::vector<Token> words;
};

/// A text and the names of places, ready to be read. The lexicon must outlive it.
class Sentence {
 public:
  Sentence(std::string_view text, const Lexicon::Tables& lexicon, std::span<const std::string> places);

  const Lexicon::Tables& lexicon() const { return lexicon_; }
  std::size_t size() const { return words_.size(); }
  const Word& operator[](std::size_t at) const { return words_[at]; }
  bool is_mark(std::size_t at, std::string_view marks) const;
  bool is_number(std::size_t at) const;
  bool is_word(std::size_t at, std::string_view word) const;
  /// The phrases that begin at a word.
  std::span<const Edge> edges(std::size_t at) const { return edges_[at]; }
  /// Where the longest phrase of a group that begins here ends; `at` where there is none.
  std::size_t longest(std::size_t at, Group group) const;
  /// The word behind polite ones that begin here, with the commas around them.
  std::size_t behind_polite(std::size_t at) const { return behind_polite_[at]; }
  /// The text from one word to before another, as it was given, with single spaces.
  std::string slice(std::size_t begin, std::size_t end) const;
  const std::vector<PlaceName>& places() const { return places_; }

 private:
  void read_words(std::string_view text);
  void add_word(Token token, const Spelling& spelling);
  void find_edges();
  void follow(std::size_t from, std::size_t node, std::size_t at);
  void find_polite();

  std::string_view text_;
  const Lexicon::Tables& lexicon_;
  std::vector<PlaceName> places_;
  std::vector<Word> words_;
  std::vector<std::vector<Edge>> edges_;
  std::vector<std::size_t> behind_polite_;
};

}  // namespace threewe::language
