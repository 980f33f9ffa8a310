// Chart parser of single clauses: which patterns of the lexicon begin at a word, where they end and what fills their
// slots. Every reading is kept.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "language/sentence.hpp"
#include "threewe/core/pose.hpp"

namespace threewe::language {

/// A thing as it stands in a sentence.
struct Noun {
  ThingPhrase phrase = {};
  bool refers = false;  ///< "it": the thing that was spoken of last
  friend bool operator==(const Noun&, const Noun&) = default;
};

/// What fills the slots of a pattern.
struct Slots {
  std::optional<Noun> thing = {};
  std::string place = {};
  std::vector<std::string> choices = {};  ///< known places that the place may be, where it may be several
  std::string other = {};                 ///< "[color ]kind"
  std::optional<Vec2> point = {};
  std::optional<double> theta = {};
  std::optional<double> length = {};
  std::optional<double> angle = {};
  std::optional<double> duration = {};
  std::optional<double> side = {};  ///< 1 left, -1 right
  std::string name = {};
  friend bool operator==(const Slots&, const Slots&) = default;
};

/// One way to read words: where it ends, and with what.
struct Match {
  std::size_t end = 0;
  Slots slots = {};
  friend bool operator==(const Match&, const Match&) = default;
};
using Matches = std::vector<Match>;

/// A number with its unit, or without.
struct Quantity {
  std::size_t end = 0;
  double value = 0.0;
};

/// Reads clauses of one sentence. What it has read of nouns it keeps.
class Chart {
 public:
  explicit Chart(const Sentence& sentence);

  /// Every way in which a pattern can be read from a word on.
  Matches match(const Pattern& pattern, std::size_t at);
  /// The farthest word at which something else was expected.
  std::size_t farthest() const { return farthest_; }
  /// Everything before a word has been read: what is wrong is there or behind it.
  void reach(std::size_t at) { fail(at); }
  /// Whether failures count for `farthest`.
  void watch(bool on) { watching_ = on; }

  /// Where phrases of a group that begin here end.
  std::vector<std::size_t> ends(std::size_t at, std::size_t group) const;

 private:
  Matches match_word(const Pattern& pattern, std::size_t at);
  Matches match_group(const Pattern& pattern, std::size_t at);
  Matches match_sequence(const Pattern& pattern, std::size_t at);
  Matches match_slot(Slot slot, std::size_t at);
  Matches fill(Slot slot, std::size_t at);

  // nouns.cpp
  const Matches& things(std::size_t at);
  Matches read_things(std::size_t at);
  void add_heads(std::size_t at, const ThingPhrase& thing, Matches& to);
  void add_details(const Match& head, Matches& to);
  Matches others(std::size_t at);
  Matches place(std::size_t at);
  std::optional<Match> place_without_determiner(std::size_t at);
  std::optional<Match> known_place(std::size_t at) const;
  std::optional<Match> lexicon_place(std::size_t at) const;
  Matches obstacle(std::size_t at);
  Matches landmark(std::size_t at);
  Matches name(std::size_t at);
  bool splits_this_place(std::size_t at) const;
  std::vector<std::size_t> behind_determiners(std::size_t at) const;

  // quantities.cpp
  std::optional<Quantity> number(std::size_t at) const;
  std::optional<Quantity> spelled_number(std::size_t at) const;
  std::optional<Quantity> unsigned_number(std::size_t at) const;
  std::optional<Quantity> simple_quantity(std::size_t at, Group unit) const;
  std::optional<Quantity> quantity(std::size_t at, Group unit) const;
  std::optional<Quantity> unit(std::size_t at, Group unit) const;
  Matches points(std::size_t at);
  std::optional<Match> coordinates(std::size_t at) const;
  std::optional<Quantity> coordinate(std::size_t at, std::size_t axis) const;
  void add_heading(const Match& point, Matches& to) const;
  Matches quantities(Slot slot, std::size_t at);

  void fail(std::size_t at) {
    if (watching_ && at > farthest_) farthest_ = at;
  }
  std::size_t longest(std::size_t at, std::size_t group) const;

  const Sentence& sentence_;
  std::map<std::size_t, Matches> things_;
  std::size_t farthest_ = 0;
  bool watching_ = true;
  struct Groups {
    std::size_t negation, point, x, y, is, facing, theta, minus, ordinal, side_of_you, wall, the, this_place, as;
  } groups_;
};

}  // namespace threewe::language
