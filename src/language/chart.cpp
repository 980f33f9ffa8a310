#include "language/chart.hpp"

#include <algorithm>
#include <utility>

namespace threewe::language {
namespace {

// What a further part of a pattern adds.
Slots joined(Slots a, const Slots& b) {
  if (b.thing) a.thing = b.thing;
  if (!b.place.empty()) a.place = b.place;
  if (a.choices.empty()) a.choices = b.choices;
  if (!b.other.empty()) a.other = b.other;
  if (b.point) a.point = b.point;
  if (b.theta) a.theta = b.theta;
  if (b.length) a.length = b.length;
  if (b.angle) a.angle = b.angle;
  if (b.duration) a.duration = b.duration;
  if (b.side) a.side = b.side;
  if (!b.name.empty()) a.name = b.name;
  return a;
}

void add_new(Matches& to, Match match) {
  if (std::ranges::find(to, match) == to.end()) to.push_back(std::move(match));
}

}  // namespace

Chart::Chart(const Sentence& sentence) : sentence_(sentence) {
  const Lexicon::Tables& lexicon = sentence.lexicon();
  groups_ = {.negation = lexicon.group("not"),
             .point = lexicon.group("point"),
             .x = lexicon.group("x"),
             .y = lexicon.group("y"),
             .is = lexicon.group("is"),
             .facing = lexicon.group("facing"),
             .theta = lexicon.group("theta"),
             .minus = lexicon.group("minus"),
             .ordinal = lexicon.group("ordinal"),
             .side_of_you = lexicon.group("side_of_you"),
             .wall = lexicon.group("wall"),
             .the = lexicon.group("the"),
             .this_place = lexicon.group("this_place"),
             .as = lexicon.group("as")};
}

Matches Chart::match(const Pattern& pattern, std::size_t at) {
  switch (pattern.kind) {
    case Pattern::Kind::word: return match_word(pattern, at);
    case Pattern::Kind::group: return match_group(pattern, at);
    case Pattern::Kind::slot: return match_slot(pattern.slot, at);
    case Pattern::Kind::sequence: return match_sequence(pattern, at);
    case Pattern::Kind::choice:
    case Pattern::Kind::optional: break;
  }
  Matches all;
  for (const Pattern& part : pattern.parts) {
    for (Match& one : match(part, at)) add_new(all, std::move(one));
  }
  if (pattern.kind == Pattern::Kind::optional) add_new(all, {at, {}});
  return all;
}

Matches Chart::match_word(const Pattern& pattern, std::size_t at) {
  for (const std::size_t begin : {at, sentence_.behind_polite(at)}) {
    if (sentence_.is_word(begin, pattern.word)) return {{begin + 1, {}}};
  }
  fail(sentence_.behind_polite(at));
  return {};
}

Matches Chart::match_group(const Pattern& pattern, std::size_t at) {
  Matches all;
  for (const std::size_t begin : {at, sentence_.behind_polite(at)}) {
    for (const std::size_t end : ends(begin, pattern.group)) add_new(all, {end, {}});
  }
  if (all.empty()) fail(sentence_.behind_polite(at));
  return all;
}

Matches Chart::match_sequence(const Pattern& pattern, std::size_t at) {
  Matches so_far{{at, {}}};
  for (const Pattern& part : pattern.parts) {
    Matches further;
    for (const Match& one : so_far) {
      for (const Match& next : match(part, one.end)) add_new(further, {next.end, joined(one.slots, next.slots)});
    }
    so_far = std::move(further);
    if (so_far.empty()) break;
  }
  return so_far;
}

Matches Chart::match_slot(Slot slot, std::size_t at) {
  Matches all = fill(slot, at);
  if (const std::size_t behind = sentence_.behind_polite(at); behind > at) {
    for (Match& one : fill(slot, behind)) add_new(all, std::move(one));
  }
  if (all.empty()) fail(sentence_.behind_polite(at));
  return all;
}

Matches Chart::fill(Slot slot, std::size_t at) {
  switch (slot) {
    case Slot::target: {
      Matches all = points(at);
      for (Match& one : place(at)) add_new(all, std::move(one));
      for (const Match& one : things(at)) add_new(all, one);
      return all;
    }
    case Slot::place: return place(at);
    case Slot::thing: return things(at);
    case Slot::other: return others(at);
    case Slot::point: return points(at);
    case Slot::side: {
      Matches all;
      if (at >= sentence_.size()) return all;
      for (const Edge& edge : sentence_.edges(at)) {
        if (edge.phrase->group == index_of(Group::side)) all.push_back({edge.end, {.side = edge.phrase->number}});
      }
      return all;
    }
    case Slot::name: return name(at);
    case Slot::obstacle: return obstacle(at);
    case Slot::landmark: return landmark(at);
    case Slot::length:
    case Slot::angle:
    case Slot::duration:
    case Slot::speed: break;
  }
  return quantities(slot, at);
}

std::vector<std::size_t> Chart::ends(std::size_t at, std::size_t group) const {
  std::vector<std::size_t> all;
  if (at >= sentence_.size()) return all;
  for (const Edge& edge : sentence_.edges(at)) {
    if (edge.phrase->group == group && std::ranges::find(all, edge.end) == all.end()) all.push_back(edge.end);
  }
  return all;
}

std::size_t Chart::longest(std::size_t at, std::size_t group) const {
  const std::vector<std::size_t> all = ends(at, group);
  return all.empty() ? at : *std::ranges::max_element(all);
}

}  // namespace threewe::language
