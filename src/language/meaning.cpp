#include "language/meaning.hpp"

#include <numbers>
#include <string>
#include <utility>

namespace threewe::language {
namespace {

using Steps = std::vector<Step>;

Step to_place(const std::string& place) { return {.skill = Skill::move_to_place, .place = place}; }
Step drive(double distance) { return {.skill = Skill::move_forward, .distance = distance}; }
Step rotate(double angle) { return {.skill = Skill::rotate, .angle = angle}; }
Step answer(const char* about, const ThingPhrase& thing = {}) {
  return {.skill = Skill::answer, .about = about, .thing = thing};
}

Steps go(const Slots& slots, const ThingPhrase& thing) {
  if (slots.point) {
    return {{.skill = Skill::move_to, .x = slots.point->x, .y = slots.point->y, .theta = slots.theta}};
  }
  if (slots.thing) return {{.skill = Skill::approach, .thing = thing}};
  return {to_place(slots.place)};
}

Steps look(const std::string& place) {
  Steps steps;
  if (!place.empty()) steps.push_back(to_place(place));
  steps.push_back({.skill = Skill::look});
  return steps;
}

Steps see(const std::string& place) {
  Steps steps = look(place);
  steps.push_back({.skill = Skill::list_things, .place = place});
  return steps;
}

Steps turn(const Slots& slots) {
  constexpr double kQuarter = std::numbers::pi / 2;
  return {rotate(slots.side.value_or(1.0) * slots.angle.value_or(kQuarter))};
}

// Where a place is said the robot looks there; else it searches, or sees everything, before it answers.
Steps question(Meaning meaning, const ThingPhrase& thing) {
  const bool there = !thing.place.empty();
  switch (meaning) {
    case Meaning::where: return {{.skill = Skill::search, .thing = thing}, answer("where", thing)};
    case Meaning::exists:
      if (!there) return {{.skill = Skill::search, .thing = thing}, answer("exists", thing)};
      break;
    default:
      if (!there) return {{.skill = Skill::explore}, answer("count", thing)};
      break;
  }
  Steps steps = look(thing.place);
  steps.push_back(answer(meaning == Meaning::exists ? "exists" : "count", thing));
  return steps;
}

}  // namespace

Meaning family_of(Meaning meaning) {
  switch (meaning) {
    case Meaning::back_to_start: return Meaning::go;
    case Meaning::backward:
    case Meaning::sideways: return Meaning::forward;
    case Meaning::turn_around: return Meaning::turn;
    default: return meaning;
  }
}

Steps steps_of(Meaning meaning, const Slots& slots, const std::optional<ThingPhrase>& last) {
  ThingPhrase thing;
  if (slots.thing) {
    if (slots.thing->refers && !last) return {};
    thing = slots.thing->refers ? *last : slots.thing->phrase;
    if (thing.place.empty()) thing.place = slots.place;
    if (thing.next_to.empty()) thing.next_to = slots.other;
  }
  switch (meaning) {
    case Meaning::go: return go(slots, thing);
    case Meaning::back_to_start: return {to_place(std::string(kStart))};
    case Meaning::forward: return {drive(*slots.length)};
    case Meaning::backward: return {drive(-*slots.length)};
    case Meaning::sideways: return {rotate(*slots.side * std::numbers::pi / 2), drive(*slots.length)};
    case Meaning::turn: return turn(slots);
    case Meaning::turn_around: return {rotate(std::numbers::pi)};
    case Meaning::search: return {{.skill = Skill::search, .thing = thing}};
    case Meaning::explore: return {{.skill = Skill::explore, .place = slots.place}};
    case Meaning::look: return look(slots.place);
    case Meaning::see: return see(slots.place);
    case Meaning::list_things: return {{.skill = Skill::list_things}};
    case Meaning::list_places: return {{.skill = Skill::list_places}};
    case Meaning::name: return {{.skill = Skill::name_place, .name = slots.name.empty() ? slots.place : slots.name}};
    case Meaning::wait:
      if (*slots.duration < 0.0) return {};
      return {{.skill = Skill::wait, .duration = slots.duration}};
    case Meaning::exists:
    case Meaning::where:
    case Meaning::count: return question(meaning, thing);
    case Meaning::position: return {answer("position")};
    case Meaning::done: return {{.skill = Skill::done}};
    case Meaning::route: break;
  }
  return {};
}

}  // namespace threewe::language
