// Things and places in sentences.
#include <algorithm>
#include <utility>

#include "language/chart.hpp"

namespace threewe::language {
namespace {

constexpr std::size_t kLongestName = 6;  // [words] what is given a name has a short one
constexpr std::string_view kEndOfClause = ".,;:!?";

// Whether a word is one of a name's, whose numbers may be spelled.
bool is_same(const Sentence& sentence, std::size_t at, const Token& wanted) {
  if (at >= sentence.size()) return false;
  const Word& word = sentence[at];
  if (wanted.kind != Token::Kind::number) return word.token.text == wanted.text || word.read == wanted.text;
  if (word.token.kind == Token::Kind::number) return word.token.value == wanted.value;
  return std::ranges::any_of(sentence.edges(at), [&](const Edge& edge) {
    return edge.phrase->group == index_of(Group::number) && edge.end == at + 1 && edge.phrase->number == wanted.value;
  });
}

// How many words of a name stand here, marks left out, and where they end.
struct Overlap {
  std::size_t end = 0;
  bool whole = false;
};
Overlap overlap(const Sentence& sentence, std::size_t at, const std::vector<Token>& name) {
  Overlap found{at, false};
  std::size_t next = at;
  for (const Token& token : name) {
    if (is_same(sentence, next, token)) {
      ++next;
      if (token.kind != Token::Kind::mark) found.end = next;
    } else if (token.kind == Token::Kind::number && (sentence.is_word(next, "number") || sentence.is_word(next, "#")) &&
               is_same(sentence, next + 1, token)) {
      next += 2;
      found.end = next;
    } else if (token.kind != Token::Kind::mark) {
      return found;
    }
  }
  found.whole = found.end > at;
  return found;
}

}  // namespace

std::vector<std::size_t> Chart::behind_determiners(std::size_t at) const {
  std::vector<std::size_t> all{at};
  for (const std::size_t end : ends(at, index_of(Group::determiner))) all.push_back(end);
  return all;
}

const Matches& Chart::things(std::size_t at) {
  const auto known = things_.find(at);
  if (known != things_.end()) return known->second;
  Matches read = read_things(at);
  return things_[at] = std::move(read);
}

Matches Chart::read_things(std::size_t at) {
  Matches all;
  for (const std::size_t end : ends(at, index_of(Group::it))) all.push_back({end, {.thing = Noun{.refers = true}}});
  Matches heads;
  for (const std::size_t begin : behind_determiners(at)) add_heads(begin, {}, heads);
  for (const Match& head : heads) add_details(head, all);
  return all;
}

// Adjectives, then a noun, or "something" with its color behind it.
void Chart::add_heads(std::size_t at, const ThingPhrase& thing, Matches& to) {
  bool noun = false;
  if (at < sentence_.size()) {
    for (const Edge& edge : sentence_.edges(at)) {
      const auto group = static_cast<Group>(std::min(edge.phrase->group, index_of(Group::others)));
      ThingPhrase more = thing;
      if (group == Group::color && thing.color.empty()) {
        more.color = edge.phrase->value;
        add_heads(edge.end, more, to);
        noun = true;
      } else if (group == Group::which && thing.which.empty()) {
        more.which = edge.phrase->value;
        add_heads(edge.end, more, to);
        noun = true;
      } else if (group == Group::kind || group == Group::anything) {
        if (group == Group::kind) more.kind = edge.phrase->value;
        to.push_back({edge.end, {.thing = Noun{.phrase = more}}});
        noun = true;
      }
    }
  }
  if (!noun) fail(at);
}

// "... that is red", "... next to the desk", "... in the lobby", "... closest to you", in any order.
void Chart::add_details(const Match& head, Matches& to) {
  if (std::ranges::find(to, head) != to.end()) return;
  to.push_back(head);
  std::vector<std::size_t> begins = ends(head.end, index_of(Group::relative));
  const bool plain = begins.empty();
  begins.push_back(head.end);
  const ThingPhrase& thing = head.slots.thing->phrase;
  for (const std::size_t begin : begins) {
    if (begin >= sentence_.size()) continue;
    for (const Edge& edge : sentence_.edges(begin)) {
      const auto group = static_cast<Group>(std::min(edge.phrase->group, index_of(Group::others)));
      Match more = head;
      more.end = edge.end;
      if (group == Group::color && thing.color.empty() && (!plain || thing.kind.empty())) {
        more.slots.thing->phrase.color = edge.phrase->value;
        add_details(more, to);
      } else if (group == Group::which && thing.which.empty()) {
        more.slots.thing->phrase.which = edge.phrase->value;
        add_details(more, to);
      } else if (group == Group::next_to && thing.next_to.empty()) {
        for (const Match& other : others(edge.end)) {
          more.end = other.end;
          more.slots.thing->phrase.next_to = other.slots.other;
          add_details(more, to);
        }
      } else if (group == Group::inside && thing.place.empty()) {
        for (const Match& where : place(edge.end)) {
          more.end = where.end;
          more.slots.thing->phrase.place = where.slots.place;
          more.slots.choices = where.slots.choices;
          add_details(more, to);
        }
      }
    }
  }
  fail(head.end);
}

// "the white desk"
Matches Chart::others(std::size_t at) {
  Matches all;
  Matches heads;
  for (const std::size_t begin : behind_determiners(at)) add_heads(begin, {}, heads);
  for (const Match& head : heads) {
    const ThingPhrase& thing = head.slots.thing->phrase;
    if (thing.kind.empty() || !thing.which.empty()) continue;
    all.push_back({head.end, {.other = thing.color.empty() ? thing.kind : thing.color + " " + thing.kind}});
  }
  return all;
}

Matches Chart::place(std::size_t at) {
  std::optional<Match> best;
  for (const std::size_t begin : behind_determiners(at)) {
    const bool quoted = sentence_.is_mark(begin, "\"");
    std::optional<Match> one = place_without_determiner(begin + (quoted ? 1 : 0));
    if (!one) {
      fail(begin);
      continue;
    }
    if (quoted && !sentence_.is_mark(one->end++, "\"")) continue;
    if (!best || one->end > best->end) best = one;
  }
  return best ? Matches{*best} : Matches{};
}

// What has more words wins; of two alike a known place before the lexicon's.
std::optional<Match> Chart::place_without_determiner(std::size_t at) {
  const std::optional<Match> known = known_place(at);
  const std::optional<Match> other = lexicon_place(at);
  return known && (!other || known->end >= other->end) ? known : other;
}

// A known place by its whole name, or by the words with which the names of one or more begin.
std::optional<Match> Chart::known_place(std::size_t at) const {
  Overlap best{at, false};
  std::vector<std::string> names;
  for (const PlaceName& place : sentence_.places()) {
    const Overlap found = overlap(sentence_, at, place.words);
    if (found.end <= at || found.end < best.end || (found.end == best.end && best.whole && !found.whole)) continue;
    if (found.end > best.end || (found.whole && !best.whole)) names.clear();
    best = found;
    names.push_back(place.name);
  }
  if (names.empty()) return std::nullopt;
  std::ranges::sort(names);
  names.erase(std::unique(names.begin(), names.end()), names.end());
  Match match{best.end, {.place = names.front()}};
  if (names.size() > 1) match.slots.choices = std::move(names);
  return match;
}

std::optional<Match> Chart::lexicon_place(std::size_t at) const {
  if (at >= sentence_.size()) return std::nullopt;
  std::optional<Match> best;
  for (const Edge& edge : sentence_.edges(at)) {
    const std::size_t group = edge.phrase->group;
    const bool place = group == index_of(Group::place) || group == index_of(Group::start);
    const auto digits = group == index_of(Group::start) ? Quantity{} : unsigned_number(edge.end).value_or(Quantity{});
    const bool numbered = digits.end > 0 && digits.value == static_cast<double>(static_cast<int>(digits.value));
    if (!place && (group != index_of(Group::numbered) || !numbered)) continue;
    Match one{edge.end, {.place = edge.phrase->value}};
    if (!best || one.end > best->end) best = one;
    if (!numbered || digits.end != edge.end + 1) continue;
    one = {digits.end, {.place = edge.phrase->value + " " + std::to_string(static_cast<int>(digits.value))}};
    if (one.end > best->end) best = one;
  }
  return best;
}

// What no robot drives through or over; doors it does.
Matches Chart::obstacle(std::size_t at) {
  Matches all;
  for (const std::size_t begin : behind_determiners(at)) {
    if (const std::size_t end = longest(begin, groups_.wall); end > begin) all.push_back({end, {}});
  }
  for (const Match& one : things(at)) {
    if (one.slots.thing->phrase.kind != "door" && !one.slots.thing->refers) all.push_back({one.end, {}});
  }
  return all;
}

// "the second door on your left", "the chair next to the desk", "office 2"
Matches Chart::landmark(std::size_t at) {
  Matches all;
  const auto add = [&](std::size_t end) {
    all.push_back({end, {}});
    const std::size_t side = longest(end, groups_.side_of_you);
    if (side > end) all.push_back({side, {}});
    for (const std::size_t near : ends(side, index_of(Group::next_to))) {
      for (const Match& other : others(near)) all.push_back({other.end, {}});
    }
  };
  for (const std::size_t begin : behind_determiners(at)) {
    for (const std::size_t noun : {begin, longest(begin, groups_.ordinal)}) {
      for (const Match& one : things(noun)) add(one.end);
      for (const std::size_t end : ends(noun, index_of(Group::numbered))) add(end);
      for (const Match& one : place(noun)) add(one.end);
    }
  }
  return all;
}

// Whether a word is in the middle of "this place", which is no name.
bool Chart::splits_this_place(std::size_t at) const {
  for (std::size_t back = 1; back <= std::min(at, kLongestName); ++back) {
    if (longest(at - back, groups_.this_place) > at) return true;
  }
  return false;
}

// In quotes, or the words up to a mark or to what joins clauses. A known place keeps the name by which it is known.
Matches Chart::name(std::size_t at) {
  if (splits_this_place(at)) return {};
  const std::size_t article = longest(at, groups_.the);
  const bool quoted = sentence_.is_mark(article, "\"");
  const std::size_t begin = article + (quoted ? 1 : 0);
  std::size_t end = begin;
  const auto ends_here = [&](std::size_t word) {
    if (quoted) return sentence_.is_mark(word, "\"");
    return sentence_.is_mark(word, kEndOfClause) || sentence_.longest(word, Group::join) > word ||
           sentence_.longest(word, Group::polite) > word;
  };
  while (end < sentence_.size() && !ends_here(end)) ++end;
  const bool open = quoted && end == sentence_.size();
  if (end == begin || open || (!quoted && end - begin > kLongestName)) return {};
  const bool other_word = longest(begin, groups_.negation) > begin || longest(begin, groups_.as) > begin;
  if (!quoted && (other_word || sentence_.is_mark(begin, "\"()-/="))) return {};
  std::string name = sentence_.slice(begin, end);
  const std::optional<Match> known = place_without_determiner(begin);
  if (known && known->end == end && known->slots.choices.empty()) {
    const bool whole = overlap(sentence_, begin, tokens_of(known->slots.place)).whole;
    if (whole) name = known->slots.place;
  }
  return {{end + (quoted ? 1 : 0), {.name = name}}};
}

}  // namespace threewe::language
