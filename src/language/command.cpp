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

std::vector<std::pair<std::string_view, std::variant<std::string, double>>> arguments_of(const Step& step) {
  std::vector<std::pair<std::string_view, std::variant<std::string, double>>> arguments;
  const auto text = [&](std::string_view name, const std::string& value) {
    if (!value.empty()) arguments.emplace_back(name, value);
  };
  const auto number = [&](std::string_view name, std::optional<double> value) {
    if (value) arguments.emplace_back(name, *value);
  };
  text("about", step.about);
  text("name", step.name);
  text("kind", step.thing.kind);
  text("color", step.thing.color);
  text("which", step.thing.which);
  text("next_to", step.thing.next_to);
  text("place", step.thing.place);
  text("place", step.place);
  number("x", step.x);
  number("y", step.y);
  number("theta", step.theta);
  number("distance", step.distance);
  number("angle", step.angle);
  number("duration", step.duration);
  text("route", step.route);
  return arguments;
}

std::string to_text(const Step& step) {
  std::vector<std::string> texts;
  for (const auto& [name, value] : arguments_of(step)) {
    const auto* text = std::get_if<std::string>(&value);
    texts.push_back(fmt::format("{}={}", name, text != nullptr ? *text : shown(std::get<double>(value))));
  }
  return fmt::format("{}({})", to_string(step.skill), fmt::join(texts, ", "));
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
