// Commands in English.
#include "threewe/language/command.hpp"

#include <nanobind/stl/variant.h>

#include "bindings.hpp"
#include "named_enum.hpp"
#include "value.hpp"

using namespace threewe;
using language::Reading, language::ReadingOutcome, language::RefusalRule, language::Skill, language::Step,
    language::ThingPhrase;

namespace {

// The arguments that were said, by name, in canonical order.
nb::dict arguments_as_dict(const Step& step) {
  nb::dict arguments;
  for (const auto& [name, value] : language::arguments_of(step)) arguments[nb::str(name.data(), name.size())] = value;
  return arguments;
}

void add_enums(nb::module_& m) {
  NamedEnum<Skill>(m, "Skill", "What one step of a command does.")
      .value("move_to_place", Skill::move_to_place, "drives to `place`")
      .value("approach", Skill::approach, "drives to `thing`")
      .value("move_to", Skill::move_to, "drives to `x`, `y`, and turns to `theta` where given")
      .value("move_forward", Skill::move_forward, "drives `distance` straight on; backwards where negative")
      .value("rotate", Skill::rotate, "turns by `angle`")
      .value("search", Skill::search, "looks for `thing`")
      .value("explore", Skill::explore, "maps what is unknown; in `place` where given")
      .value("look", Skill::look, "turns once around to see")
      .value("list_things", Skill::list_things, "says which things are known; in `place` where given")
      .value("list_places", Skill::list_places, "says which places are known")
      .value("name_place", Skill::name_place, "calls the place where the robot is `name`")
      .value("answer", Skill::answer, "answers a question `about` `thing`, or about its own position")
      .value("wait", Skill::wait, "stands for `duration`")
      .value("follow", Skill::follow, "follows the instruction `route`, as of VLN")
      .value("done", Skill::done, "ends");
  NamedEnum<ReadingOutcome>(m, "ReadingOutcome", "What became of a text.")
      .value("understood", ReadingOutcome::understood, "`steps` say what to do")
      .value("ambiguous", ReadingOutcome::ambiguous, "it has several `meanings`: ask")
      .value("not_understood", ReadingOutcome::not_understood, "`word` could not be read")
      .value("refused", ReadingOutcome::refused, "it asks for what no robot does: `rule`");
  NamedEnum<RefusalRule>(m, "RefusalRule", "Why a command is refused.")
      .value("speed", RefusalRule::speed, "it asks to be faster than the operating limits")
      .value("obstacle", RefusalRule::obstacle, "it asks to drive through, over or against something")
      .value("emergency_stop", RefusalRule::emergency_stop, "it asks to release the emergency stop")
      .value("zone", RefusalRule::zone, "it asks to enter a keep-out zone");
}

}  // namespace

void init_language(nb::module_& m) {
  add_enums(m);
  nb::class_<ThingPhrase>(m, "ThingPhrase", "A thing as it is described. What is not said is empty.")
      .def(Value())
      .def_ro("kind", &ThingPhrase::kind, R"(category of objects, such as "chair"; empty: any thing)")
      .def_ro("color", &ThingPhrase::color, R"(one of the eleven basic color terms, such as "red")")
      .def_ro("which", &ThingPhrase::which, R"("nearest" or "farthest")")
      .def_ro("next_to", &ThingPhrase::next_to, R"(another thing beside it: "[color ]kind")")
      .def_ro("place", &ThingPhrase::place, "where it is")
      .def("__repr__", [](const ThingPhrase& thing) {
        return fmt::format("ThingPhrase(kind='{}', color='{}', which='{}', next_to='{}', place='{}')", thing.kind,
                           thing.color, thing.which, thing.next_to, thing.place);
      });
  nb::class_<Step>(m, "Step", "One step of a command: a skill and its arguments. What was not said is empty or None.")
      .def(Value())
      .def_ro("skill", &Step::skill, "what to do")
      .def_ro("about", &Step::about, R"(of `answer`: "exists", "where", "count" or "position")")
      .def_ro("place", &Step::place, "of `move_to_place`, `explore` and `list_things`")
      .def_ro("name", &Step::name, "of `name_place`")
      .def_ro("thing", &Step::thing, "of `approach`, `search` and `answer`")
      .def_ro("x", &Step::x, "[m] of `move_to`, in `map`")
      .def_ro("y", &Step::y, "[m] of `move_to`, in `map`")
      .def_ro("theta", &Step::theta, "[rad] of `move_to`, counter-clockwise from the x axis")
      .def_ro("distance", &Step::distance, "[m] of `move_forward`")
      .def_ro("angle", &Step::angle, "[rad] of `rotate`, counter-clockwise")
      .def_ro("duration", &Step::duration, "[s] of `wait`")
      .def_ro("route", &Step::route, "of `follow`: the instruction")
      .def_prop_ro("arguments", &arguments_as_dict, nb::sig("def arguments(self) -> dict[str, str | float]"),
                   "What was said, by name, in canonical order; those of `thing` and its `place` among them.")
      .def("__str__", [](const Step& step) { return language::to_text(step); })
      .def("__repr__", [](const Step& step) { return language::to_text(step); });
  nb::class_<Reading>(m, "Reading", "What a text was read as. Only what its outcome names is filled.")
      .def(Value())
      .def_ro("outcome", &Reading::outcome, "which of the others says more")
      .def_ro("steps", &Reading::steps, "what to do, in order, where understood")
      .def_ro("meanings", &Reading::meanings, "two or more where ambiguous, sorted: names of places, or plans as text")
      .def_ro("word", &Reading::word, "the first word that could not be read where not understood, lower case")
      .def_ro("rule", &Reading::rule, "why, where refused; else None")
      .def("__str__", [](const Reading& reading) { return language::to_text(reading); })
      .def("__repr__", [](const Reading& reading) { return fmt::format("Reading({})", language::to_text(reading)); });
  m.def(
      "read_command",
      [](std::string_view text, const std::vector<std::string>& places) {
        static const language::Lexicon lexicon = language::Lexicon::load();
        const nb::gil_scoped_release without_gil;
        return language::read(text, lexicon, places);
      },
      "text"_a, "places"_a, "Reads a command in English where these places are known.");
}
