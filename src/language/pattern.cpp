// Patterns: "<go> [<way>] <to> TARGET" as a tree.
#include <algorithm>
#include <array>
#include <cctype>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/names.hpp"
#include "language/lexicon.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::language {
namespace {

using Groups = std::map<std::string, std::size_t, std::less<>>;

constexpr std::array<std::pair<std::string_view, Slot>, 13> kSlots = {{{"TARGET", Slot::target},
                                                                       {"PLACE", Slot::place},
                                                                       {"THING", Slot::thing},
                                                                       {"OTHER", Slot::other},
                                                                       {"POINT", Slot::point},
                                                                       {"LENGTH", Slot::length},
                                                                       {"ANGLE", Slot::angle},
                                                                       {"DURATION", Slot::duration},
                                                                       {"SPEED", Slot::speed},
                                                                       {"SIDE", Slot::side},
                                                                       {"NAME", Slot::name},
                                                                       {"OBSTACLE", Slot::obstacle},
                                                                       {"LANDMARK", Slot::landmark}}};

class PatternReader {
 public:
  PatternReader(std::string_view text, const Groups& groups) : text_(text), groups_(groups) {}

  Pattern whole() {
    Pattern pattern = sequence();
    if (at_ < text_.size()) fail(fmt::format("'{}' closes nothing", text_[at_]));
    return pattern;
  }

 private:
  // What stands between two of ( | ) [ ].
  Pattern sequence() {
    Pattern all;
    for (skip_spaces(); at_ < text_.size() && !is_end(text_[at_]); skip_spaces()) all.parts.push_back(part());
    if (all.parts.empty()) fail("something is empty");
    return all;
  }

  Pattern part() {
    if (accept('[')) {
      Pattern optional{.kind = Pattern::Kind::optional};
      optional.parts.push_back(choice());
      expect(']');
      return optional;
    }
    if (accept('(')) {
      Pattern one = choice();
      expect(')');
      return one;
    }
    if (accept('<')) {
      Pattern group{.kind = Pattern::Kind::group, .word = std::string(until(" >"))};
      expect('>');
      const auto found = groups_.find(group.word);
      if (found == groups_.end()) fail(unknown_name("group", group.word, names()));
      group.group = found->second;
      return group;
    }
    return word(std::string(until(" []()<>|")));
  }

  Pattern choice() {
    Pattern one{.kind = Pattern::Kind::choice};
    do one.parts.push_back(sequence());
    while (accept('|'));
    return one;
  }

  Pattern word(const std::string& text) const {
    if (text.empty()) fail("a word is missing");
    const bool is_slot = std::ranges::all_of(text, [](char c) { return c >= 'A' && c <= 'Z'; });
    if (!is_slot) return {.kind = Pattern::Kind::word, .word = text};
    const auto* found = std::ranges::find(kSlots, text, &std::pair<std::string_view, Slot>::first);
    if (found == kSlots.end()) {
      std::vector<std::string> known;
      for (const auto& [name, slot] : kSlots) known.emplace_back(name);
      fail(unknown_name("slot", text, known));
    }
    return {.kind = Pattern::Kind::slot, .slot = found->second};
  }

  std::vector<std::string> names() const {
    std::vector<std::string> known;
    for (const auto& [name, number] : groups_) known.push_back(name);
    return known;
  }

  static bool is_end(char c) { return c == ')' || c == ']' || c == '|'; }
  void skip_spaces() {
    while (at_ < text_.size() && text_[at_] == ' ') ++at_;
  }
  std::string_view until(std::string_view ends) {
    const std::size_t begin = at_;
    const std::size_t end = std::min(text_.find_first_of(ends, at_), text_.size());
    at_ = end;
    return text_.substr(begin, end - begin);
  }
  bool accept(char c) {
    skip_spaces();
    if (at_ >= text_.size() || text_[at_] != c) return false;
    ++at_;
    return true;
  }
  void expect(char c) {
    if (!accept(c)) fail(fmt::format("expected '{}'", c));
  }
  [[noreturn]] void fail(std::string_view what) const {
    throw ConfigError(fmt::format("pattern '{}': {}", text_, what));
  }

  std::string_view text_;
  const Groups& groups_;
  std::size_t at_ = 0;
};

}  // namespace

Pattern parse_pattern(std::string_view text, const Groups& groups) { return PatternReader(text, groups).whole(); }

}  // namespace threewe::language
