#include "threewe/language/command.hpp"

#include <array>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace threewe::language {
namespace {

// Four decimals at most, none that is not needed.
std::string shown(double number) {
  std::string text = fmt::format("{:.4f}", number);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text == "-0" ? "0" : text;
}

}  // namespace

std::string_view to_string(Skill skill) {
  constexpr std::array kNames = {"move_to_place", "approach", "move_to", "move_forward", "rotate",
                                 "search",        "explore",  "look",    "list_things",  "list_places",
                                 "name_place",    "answer",   "wait",    "follow",       "done"};
  return kNames.at(static_cast<std::size_t>(skill));
}

std::string_view to_string(ReadingOutcome outcome) {
  constexpr std::array kNames = {"understood", "ambiguous", "not_understood", "refused"};
  return kNames.at(static_cast<std::size_t>(outcome));
}

std::string_view to_string(RefusalRule rule) {
  constexpr std::array kNames = {"speed", "obstacle", "emergency_stop", "zone"};
  return kNames.at(static_cast<std::size_t>(rule));
}

std::string to_text(const Step& step) {
  std::vector<std::string> arguments;
  const auto say = [&](std::string_view key, const std::string& value) {
    if (!value.empty()) arguments.push_back(fmt::format("{}={}", key, value));
  };
  const auto number = [&](std::string_view key, std::optional<double> value) {
    if (value) arguments.push_back(fmt::format("{}={}", key, shown(*value)));
  };
  say("about", step.about);
  say("name", step.name);
  say("kind", step.thing.kind);
  say("color", step.thing.color);
  say("which", step.thing.which);
  say("next_to", step.thing.next_to);
  say("place", step.thing.place);
  say("place", step.place);
  number("x", step.x);
  number("y", step.y);
  number("theta", step.theta);
  number("distance", step.distance);
  number("angle", step.angle);
  number("duration", step.duration);
  say("route", step.route);
  return fmt::format("{}({})", to_string(step.skill), fmt::join(arguments, ", "));
}

std::string to_text(const Reading& reading) {
  switch (reading.outcome) {
    case ReadingOutcome::understood: break;
    case ReadingOutcome::ambiguous: return fmt::format("ambiguous({})", fmt::join(reading.meanings, " | "));
    case ReadingOutcome::not_understood: return fmt::format("not_understood({})", reading.word);
    case ReadingOutcome::refused: return fmt::format("refused({})", reading.rule ? to_string(*reading.rule) : "");
  }
  std::vector<std::string> steps;
  for (const Step& step : reading.steps) steps.push_back(to_text(step));
  return fmt::format("{}", fmt::join(steps, "; "));
}

}  // namespace threewe::language
