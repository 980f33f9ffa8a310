#include "language/route.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/names.hpp"
#include "language/vocabulary.hpp"

namespace threewe::language {
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

// More that is read.
constexpr std::array kTurn = {"turn to", "turn", "make a", "take a"};
constexpr std::array kAround = {"around", "back"};
constexpr std::array kMoreAhead = {"keep going straight", "go straight on", "go straight",         "walk straight on",
                                   "walk straight",       "keep straight",  "drive straight ahead"};
constexpr std::array kMorePass = {"drive past", "move past", "head past", "go by", "walk by", "drive by"};
constexpr std::array kMoreApproach = {"go up to", "head to", "drive to", "move to", "continue to", "walk towards"};
constexpr std::array kMoreThrough = {"drive through", "pass through", "move through", "continue through"};
constexpr std::array kMoreEnter = {"drive into", "step into", "move into"};
constexpr std::array kMoreLeave = {"go out of", "walk out of", "drive out of", "head out of"};
constexpr std::array kMoreAt = {"near", "in front of", "close to"};
constexpr std::array kIn = {"inside", "in"};
constexpr std::array kHere = {"here", "there"};
constexpr std::array kArticles = {"the", "a", "an", "your"};
constexpr std::array kLeftSide = {"on your left side", "on your left", "on the left side",
                                  "on the left",       "to your left", "to the left"};
constexpr std::array kRightSide = {"on your right side", "on your right", "on the right side",
                                   "on the right",       "to your right", "to the right"};

// Writes clauses, with synonyms drawn one after the other: never two in one call, whose order is the compiler's choice.
class Writer {
 public:
  explicit Writer(const RngKey& key) : key_(key) {}

  std::string sentences(const Route& route) {
    constexpr std::size_t kLong = 3;  // clauses in a sentence
    std::string text;
    Words sentence;
    for (std::size_t i = 0; i < route.size(); ++i) {
      sentence.push_back(clause(route[i]));
      const bool arrived = route[i].kind == Kind::cross || route[i].kind == Kind::approach;
      if (i + 1 == route.size() || (arrived && (sentence.size() >= kLong || chance(0.6)))) {
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
      case Kind::pass: {
        Thing passed = c.thing;
        if (c.side != Side::ahead) passed.side = c.side;
        const std::string past = pick(kPass);
        return past + " " + thing(passed);
      }
      case Kind::approach: return fmt::format("{} {}", pick(kApproach), thing(c.thing));
      case Kind::cross: return crossing(c);
      case Kind::stop_at: {
        const std::string at = pick(kAt);
        return fmt::format("{} {} {}", pick(kStop), at, thing(c.thing));
      }
      case Kind::stop_in_middle: return fmt::format("{} in the middle of {}", pick(kStop), room(c.room));
      case Kind::stop_here: return fmt::format("{} here", pick(kStop));
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
  Reader(std::string_view text, const RouteNames& names)
      : words_(words_of(text)), rooms_(names.rooms), things_(names.things) {}

  Route route() {
    Route clauses;
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
    if (turn(c)) return c;
    if (accept_any(kAhead) || accept_any(kMoreAhead)) {
      c.kind = Kind::turn;
      c.side = Side::ahead;
    } else if (accept_any(kMoreThrough) || accept_any(kThrough)) {  // "pass through" is no "pass"
      c.kind = Kind::cross;
      c.door = door();
      if (accept("into")) c.room = room();
    } else if (accept_any(kPass) || accept_any(kMorePass)) {
      c.kind = Kind::pass;
      c.thing = thing();
      c.side = std::exchange(c.thing.side, std::nullopt).value_or(Side::ahead);
    } else if (accept_any(kEnter) || accept_any(kMoreEnter)) {
      c.kind = Kind::cross;
      c.room = room();
      if (accept("through")) c.door = door();
    } else if (accept_any(kLeave) || accept_any(kMoreLeave)) {
      c.kind = Kind::cross;
      c.from = room();
      expect("through", "'through' and a door");
      c.door = door();
      if (accept("into")) c.room = room();
    } else if (accept_any(kMoreApproach) || accept_any(kApproach)) {
      c.kind = next_is_room() ? Kind::cross : Kind::approach;
      if (c.kind == Kind::cross) {
        c.room = room();
      } else {
        c.thing = thing();
      }
    } else if (accept_any(kStop)) {
      stop(c);
    } else {
      fail("something to do, such as 'turn', 'go', 'enter' or 'stop'");
    }
    return c;
  }

  // "turn left", "make a left turn"
  bool turn(Clause& c) {
    const std::size_t begun = at_;
    if (!accept_any(kTurn)) return false;
    const bool turns = words_[begun] == "turn";
    accept_any(kArticles);
    c.kind = Kind::turn;
    c.side = accept("left") ? Side::left : accept("right") ? Side::right : Side::behind;
    if (c.side == Side::behind && !accept_any(kAround)) {
      if (turns) fail("left, right or around");
      at_ = begun;  // "take a door"
      c = {};
      return false;
    }
    if (!turns) accept("turn");
    return true;
  }

  void stop(Clause& c) {
    if (accept("in the middle of")) {
      c.kind = Kind::stop_in_middle;
      c.room = room();
    } else if (accept("just inside")) {
      c.kind = Kind::stop_inside;
      if (!done()) c.room = room();
    } else if (accept_any(kMoreAt) || accept_any(kAt) || accept_any(kIn)) {
      c.kind = next_is_room() ? Kind::stop_inside : Kind::stop_at;
      if (c.kind == Kind::stop_inside) {
        c.room = room();
      } else {
        c.thing = thing();
      }
    } else if (accept_any(kHere) || at_ == words_.size()) {
      c.kind = Kind::stop_here;
    } else {
      fail("where to stop: 'at', 'in the middle of' or 'just inside'");
    }
  }

  Thing thing() {
    Thing t;
    if (!accept_any(kArticles)) fail("'the' and a thing");
    t.ordinal = ordinal();
    if (t.ordinal > 0) t.which = Thing::Which::nth;
    if (accept("nearest")) t.which = Thing::Which::nearest;
    if (accept("farthest")) t.which = Thing::Which::farthest;
    t.noun = thing_name();
    t.side = side();
    if (accept("next to")) {
      if (!accept_any(kArticles)) fail("'the' and a thing");
      t.next_to = thing_name();
    }
    return t;
  }

  DoorPhrase door() {
    DoorPhrase d;
    if (!accept_any(kArticles)) fail("'the' and a door");
    d.ordinal = ordinal();
    if (!accept_any(kDoor)) fail("'door'");
    d.side = side();
    if (accept_any(kDoorAhead)) d.side = Side::ahead;
    if (accept("behind you")) d.side = Side::behind;
    return d;
  }

  std::string room() {
    accept("the");
    const std::string* longest = longest_of(rooms_);
    if (longest == nullptr) fail<UnknownRoom>(wanted("room", rooms_));
    accept(*longest);
    return *longest;
  }

  std::string thing_name() {
    const std::string* longest = longest_of(things_);
    if (longest == nullptr) fail(wanted("thing", things_));
    accept(*longest);
    return *longest;
  }

  // Whether a room's name stands here, and no longer one of a thing.
  bool next_is_room() {
    const std::size_t begun = at_;
    accept("the");
    const std::string* room = longest_of(rooms_);
    const std::string* thing = longest_of(things_);
    at_ = begun;
    return room != nullptr && (thing == nullptr || thing->size() < room->size());
  }

  std::optional<Side> side() {
    if (accept_any(kLeftSide)) return Side::left;
    if (accept_any(kRightSide)) return Side::right;
    return std::nullopt;
  }

  int ordinal() {
    for (std::size_t i = 0; i < kOrdinals.size(); ++i) {
      if (accept(kOrdinals.at(i))) return static_cast<int>(i) + 1;
    }
    return 0;
  }

  // The longest of the names that stands here; null where there is none.
  const std::string* longest_of(const Words& names) const {
    const std::string* longest = nullptr;
    for (const std::string& candidate : names) {
      if (next_is(candidate) && (longest == nullptr || candidate.size() > longest->size())) longest = &candidate;
    }
    return longest;
  }
  std::string wanted(std::string_view kind, const Words& names) const {
    const std::string what = "a " + std::string(kind);
    return at_ < words_.size() ? what + "; " + unknown_name(kind, words_[at_], names) : what;
  }

  bool next_is(std::string_view phrase) const {
    const Words wanted = words_of(phrase);
    return wanted.size() <= words_.size() - at_ &&
           std::equal(wanted.begin(), wanted.end(), words_.begin() + static_cast<std::ptrdiff_t>(at_));
  }
  bool accept(std::string_view phrase) {
    if (!next_is(phrase)) return false;
    at_ += words_of(phrase).size();
    return true;
  }
  template <std::size_t N>
  bool accept_any(const std::array<const char*, N>& phrases) {
    return std::ranges::any_of(phrases, [this](const char* phrase) { return accept(phrase); });
  }
  void expect(std::string_view word, std::string_view wanted) {
    if (!accept(word)) fail(wanted);
  }
  template <class Error = ConfigError>
  [[noreturn]] void fail(std::string_view wanted) const {
    const std::string here = at_ < words_.size() ? fmt::format("at word {}, '{}'", at_ + 1, words_[at_]) : "at its end";
    throw Error(fmt::format("instruction not understood {}: wanted {}", here, wanted));
  }

  Words words_;
  std::size_t at_ = 0;
  Words rooms_;
  Words things_;
};

}  // namespace

std::string to_text(const Route& route, const RngKey& key) { return Writer(key).sentences(route); }

Route parse_route(std::string_view text, const RouteNames& names) { return Reader(text, names).route(); }

}  // namespace threewe::language
