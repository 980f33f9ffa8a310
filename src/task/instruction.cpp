#include "task/instruction.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/names.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::task {
namespace {

using Kind = Clause::Kind;
using Words = std::vector<std::string>;

constexpr std::array<const char*, kLastOrdinal> kOrdinals = {"first", "second", "third", "fourth"};

// The synonyms of the grammar, which are written and read alike.
constexpr std::array kAhead = {"go straight ahead", "walk straight ahead", "continue straight ahead"};
constexpr std::array kPass = {"walk past", "pass", "go past"};
constexpr std::array kApproach = {"walk to", "go to", "head for", "walk up to"};
constexpr std::array kThrough = {"go through", "walk through", "take", "head through"};
constexpr std::array kEnter = {"enter", "walk into", "go into", "continue into", "head into"};
constexpr std::array kLeave = {"leave", "exit"};
constexpr std::array kDoor = {"door", "doorway"};
constexpr std::array kDoorAhead = {"straight ahead", "ahead of you"};
constexpr std::array kStop = {"stop", "wait"};
constexpr std::array kAt = {"at", "next to", "by", "beside"};

// Writes clauses, with synonyms drawn one after the other: never two in one call, whose order is the compiler's choice.
class Writer {
 public:
  explicit Writer(const RngKey& key) : key_(key) {}

  std::string sentences(const Instruction& instruction) {
    constexpr std::size_t kLong = 3;  // clauses in a sentence
    std::string text;
    Words sentence;
    for (std::size_t i = 0; i < instruction.size(); ++i) {
      sentence.push_back(clause(instruction[i]));
      const bool arrived = instruction[i].kind == Kind::cross || instruction[i].kind == Kind::approach;
      if (i + 1 == instruction.size() || (arrived && (sentence.size() >= kLong || chance(0.6)))) {
        text += finished(std::exchange(sentence, {}), !text.empty());
      }
    }
    return text;
  }

 private:
  // "A, b and c." or "A, b, then c."
  std::string finished(const Words& clauses, bool follows) {
    const bool then = follows && chance(0.15);
    std::string sentence = then ? "then " : "";
    for (std::size_t i = 0; i < clauses.size(); ++i) {
      const bool last = i + 1 == clauses.size();
      if (i > 0) sentence += !last ? ", " : then || chance(0.5) ? " and " : ", then ";
      sentence += clauses[i];
    }
    sentence.front() = static_cast<char>(sentence.front() - 'a' + 'A');
    return (follows ? " " : "") + sentence + ".";
  }

  std::string clause(const Clause& c) {
    switch (c.kind) {
      case Kind::turn: return turn(c.side);
      case Kind::pass: return fmt::format("{} {} on your {}", pick(kPass), thing(c.thing), word(c.side));
      case Kind::approach: return fmt::format("{} {}", pick(kApproach), thing(c.thing));
      case Kind::cross: return crossing(c);
      case Kind::stop_at: {
        const std::string at = pick(kAt);
        return fmt::format("{} {} {}", pick(kStop), at, thing(c.thing));
      }
      case Kind::stop_in_middle: return fmt::format("{} in the middle of {}", pick(kStop), room(c.room));
      case Kind::stop_inside: break;
    }
    return fmt::format("{} just inside{}{}", pick(kStop), c.room.empty() ? "" : " ", room(c.room));
  }

  // "the kitchen", but "office 2"
  static std::string room(const std::string& name) {
    const bool numbered = !name.empty() && name.back() >= '0' && name.back() <= '9';
    return name.empty() || numbered ? name : "the " + name;
  }

  std::string turn(Side side) {
    if (side == Side::ahead) return pick(kAhead);
    return fmt::format("turn {}", side == Side::behind ? "around" : word(side));
  }

  std::string crossing(const Clause& c) {
    if (!c.door) return fmt::format("{} {}", pick(kEnter), room(c.room));
    const std::string into = c.room.empty() ? "" : fmt::format(" into {}", room(c.room));
    const bool leaving = !c.from.empty();
    const bool plain = !leaving && (c.room.empty() || chance(0.5));
    const std::string through = door(*c.door);
    if (leaving) return fmt::format("{} {} through {}{}", pick(kLeave), room(c.from), through, into);
    if (plain) return fmt::format("{} {}{}", pick(kThrough), through, into);
    return fmt::format("{} {} through {}", pick(kEnter), room(c.room), through);
  }

  std::string thing(const Thing& t) {
    std::string text = "the ";
    if (t.which == Thing::Which::nth) text += fmt::format("{} ", kOrdinals.at(static_cast<std::size_t>(t.ordinal - 1)));
    if (t.which == Thing::Which::nearest) text += "nearest ";
    if (t.which == Thing::Which::farthest) text += "farthest ";
    text += t.noun;
    if (t.side) text += fmt::format(" on your {}", word(*t.side));
    if (!t.next_to.empty()) text += fmt::format(" next to the {}", t.next_to);
    return text;
  }

  std::string door(const DoorPhrase& d) {
    std::string text = "the ";
    if (d.ordinal > 0) text += fmt::format("{} ", kOrdinals.at(static_cast<std::size_t>(d.ordinal - 1)));
    text += pick(kDoor);
    if (d.side == Side::ahead) return text + " " + pick(kDoorAhead);
    if (d.side == Side::behind) return text + " behind you";
    return d.side ? fmt::format("{} on your {}", text, word(*d.side)) : text;
  }

  static const char* word(Side side) { return side == Side::left ? "left" : "right"; }
  template <std::size_t N>
  std::string pick(const std::array<const char*, N>& of) {
    return of.at(static_cast<std::size_t>(uniform(key_, sample_++) * static_cast<double>(N)));
  }
  bool chance(double probability) { return uniform(key_, sample_++) < probability; }

  RngKey key_;
  std::uint64_t sample_ = 0;
};

// Reads clauses, word by word.
class Reader {
 public:
  Reader(std::string_view text, const SemanticMap& map) : words_(language::words_of(text)) {
    for (const std::string& room : map.rooms()) rooms_.push_back(room);
    for (const Landmark& landmark : map.landmarks()) {
      things_.push_back(landmark.noun);
      things_.push_back(landmark.general);
    }
    for (Words* names : {&rooms_, &things_}) {
      std::ranges::sort(*names);
      names->erase(std::unique(names->begin(), names->end()), names->end());
    }
  }

  Instruction instruction() {
    Instruction clauses;
    while (!done()) clauses.push_back(clause());
    return clauses;
  }

 private:
  // Whether the text ends here, but for what joins clauses.
  bool done() {
    while (accept("and") || accept("then")) {
    }
    return at_ == words_.size();
  }

  Clause clause() {
    Clause c;
    if (accept("turn")) {
      c.kind = Kind::turn;
      c.side = accept("left") ? Side::left : accept("right") ? Side::right : Side::behind;
      if (c.side == Side::behind) expect("around", "left, right or around");
    } else if (accept_any(kAhead)) {
      c.kind = Kind::turn;
      c.side = Side::ahead;
    } else if (accept_any(kPass)) {
      c.kind = Kind::pass;
      c.thing = thing();
      if (!c.thing.side) fail("on which side it is passed, as in 'on your left'");
      c.side = *std::exchange(c.thing.side, std::nullopt);
    } else if (accept_any(kThrough)) {
      c.kind = Kind::cross;
      c.door = door();
      if (accept("into")) c.room = room();
    } else if (accept_any(kEnter)) {
      c.kind = Kind::cross;
      c.room = room();
      if (accept("through")) c.door = door();
    } else if (accept_any(kLeave)) {
      c.kind = Kind::cross;
      c.from = room();
      expect("through", "'through' and a door");
      c.door = door();
      if (accept("into")) c.room = room();
    } else if (accept_any(kApproach)) {
      c.kind = Kind::approach;
      c.thing = thing();
    } else if (accept_any(kStop)) {
      stop(c);
    } else {
      fail("something to do, such as 'turn', 'go', 'enter' or 'stop'");
    }
    return c;
  }

  void stop(Clause& c) {
    if (accept("in the middle of")) {
      c.kind = Kind::stop_in_middle;
      c.room = room();
    } else if (accept("just inside")) {
      c.kind = Kind::stop_inside;
      if (!done()) c.room = room();
    } else if (accept_any(kAt)) {
      c.kind = Kind::stop_at;
      c.thing = thing();
    } else {
      fail("where to stop: 'at', 'in the middle of' or 'just inside'");
    }
  }

  Thing thing() {
    Thing t;
    expect("the", "'the' and a thing");
    t.ordinal = ordinal();
    if (t.ordinal > 0) t.which = Thing::Which::nth;
    if (accept("nearest")) t.which = Thing::Which::nearest;
    if (accept("farthest")) t.which = Thing::Which::farthest;
    t.noun = name("thing", things_);
    t.side = side();
    if (accept("next to")) {
      expect("the", "'the' and a thing");
      t.next_to = name("thing", things_);
    }
    return t;
  }

  DoorPhrase door() {
    DoorPhrase d;
    expect("the", "'the' and a door");
    d.ordinal = ordinal();
    if (!accept_any(kDoor)) fail("'door'");
    d.side = side();
    if (accept_any(kDoorAhead)) d.side = Side::ahead;
    if (accept("behind you")) d.side = Side::behind;
    return d;
  }

  std::string room() {
    accept("the");
    return name("room", rooms_);
  }

  std::optional<Side> side() {
    if (accept("on your left")) return Side::left;
    if (accept("on your right")) return Side::right;
    return std::nullopt;
  }

  int ordinal() {
    for (std::size_t i = 0; i < kOrdinals.size(); ++i) {
      if (accept(kOrdinals.at(i))) return static_cast<int>(i) + 1;
    }
    return 0;
  }

  // The longest of the names that stands here.
  std::string name(std::string_view kind, const Words& names) {
    const std::string* longest = nullptr;
    for (const std::string& candidate : names) {
      if (next_is(candidate) && (longest == nullptr || candidate.size() > longest->size())) longest = &candidate;
    }
    if (longest == nullptr) {
      fail(at_ < words_.size() ? "a " + std::string(kind) + "; " + unknown_name(kind, words_[at_], names)
                               : "a " + std::string(kind));
    }
    accept(*longest);
    return *longest;
  }

  bool next_is(std::string_view phrase) const {
    const Words wanted = language::words_of(phrase);
    return wanted.size() <= words_.size() - at_ &&
           std::equal(wanted.begin(), wanted.end(), words_.begin() + static_cast<std::ptrdiff_t>(at_));
  }
  bool accept(std::string_view phrase) {
    if (!next_is(phrase)) return false;
    at_ += language::words_of(phrase).size();
    return true;
  }
  template <std::size_t N>
  bool accept_any(const std::array<const char*, N>& phrases) {
    return std::ranges::any_of(phrases, [this](const char* phrase) { return accept(phrase); });
  }
  void expect(std::string_view word, std::string_view wanted) {
    if (!accept(word)) fail(wanted);
  }
  [[noreturn]] void fail(std::string_view wanted) const {
    const std::string here = at_ < words_.size() ? fmt::format("at word {}, '{}'", at_ + 1, words_[at_]) : "at its end";
    throw ConfigError(fmt::format("instruction not understood {}: wanted {}", here, wanted));
  }

  Words words_;
  std::size_t at_ = 0;
  Words rooms_;
  Words things_;
};

}  // namespace

std::string to_text(const Instruction& instruction, const RngKey& key) { return Writer(key).sentences(instruction); }

Instruction parse(std::string_view text, const SemanticMap& map) { return Reader(text, map).instruction(); }

}  // namespace threewe::task
