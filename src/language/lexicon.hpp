// Lexicon of commands: a trie of phrases with their groups, the vocabulary, and the patterns of sentences.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "threewe/language/command.hpp"

namespace threewe::language {

/// Groups of phrases that the reader itself asks for. Those of the file's `groups` follow them.
enum class Group : std::uint8_t {
  kind,
  anything,
  color,
  which,
  place,
  numbered,
  start,
  number,
  hundred,
  fraction,
  length,
  angle,
  duration,
  speed,
  side,
  determiner,
  next_to,
  inside,
  relative,
  it,
  polite,
  join,
  after,
  before,
  others
};

/// What a clause asks for.
enum class Meaning : std::uint8_t {
  go,
  back_to_start,
  forward,
  backward,
  sideways,
  turn,
  turn_around,
  search,
  explore,
  look,
  see,
  list_things,
  list_places,
  name,
  wait,
  exists,
  where,
  count,
  position,
  done,
  route
};

/// What a pattern has a place for, see the file.
enum class Slot : std::uint8_t {
  target,
  place,
  thing,
  other,
  point,
  length,
  angle,
  duration,
  speed,
  side,
  name,
  obstacle,
  landmark
};

/// A sentence pattern, as a tree.
struct Pattern {
  enum class Kind : std::uint8_t { word, group, slot, sequence, choice, optional };
  Kind kind = Kind::sequence;
  std::string word = {};
  std::size_t group = 0;
  Slot slot{};
  std::vector<Pattern> parts = {};
};

/// A phrase that ends at a node of the trie.
struct Phrase {
  std::size_t group = 0;
  std::string value;    ///< what it stands for: the kind of "sofa" is "couch"
  double number = 0.0;  ///< of numbers and units, in SI units
};

struct Lexicon::Tables {
  struct Node {
    std::map<std::string, std::size_t, std::less<>> next;
    std::vector<Phrase> phrases;
  };
  struct Clause {
    Meaning meaning{};
    Pattern pattern;
  };
  struct Refusal {
    RefusalRule rule{};
    Pattern pattern;
  };

  std::vector<Node> trie = std::vector<Node>(1);
  std::map<std::string, std::size_t, std::less<>> groups;
  std::map<std::string, std::string, std::less<>> forms;                      ///< "going" is "go"
  std::map<std::string, std::vector<std::string>, std::less<>> contractions;  ///< "what's" is "what is"
  std::map<std::string, std::string, std::less<>> vocabulary;  ///< every word, and what it is a form of or stands for
  std::set<std::string, std::less<>> rare;                     ///< words to which no typo is mended
  std::vector<Clause> clauses;
  std::vector<Clause> continued;
  std::vector<Pattern> route;
  std::vector<Refusal> refusals;
  double fastest = 0.0;  ///< [m/s]

  /// The number of a group of the file. Throws ConfigError where it has none of that name.
  std::size_t group(std::string_view name) const;
};

constexpr std::size_t index_of(Group group) { return static_cast<std::size_t>(group); }

/// Reads one pattern. Throws ConfigError saying what is wrong with it, without its place.
Pattern parse_pattern(std::string_view text, const std::map<std::string, std::size_t, std::less<>>& groups);
/// Calls `visit` with every word of a pattern that stands for itself.
template <class Visit>
void for_each_word(const Pattern& pattern, const Visit& visit) {
  if (pattern.kind == Pattern::Kind::word) visit(pattern.word);
  for (const Pattern& part : pattern.parts) for_each_word(part, visit);
}

}  // namespace threewe::language
