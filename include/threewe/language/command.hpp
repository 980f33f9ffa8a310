// Offline command grammar: what a sentence such as "go to the kitchen and find the red chair" asks of a robot. A
// lexicon (assets/languages/commands_english_v1.yaml) has the phrases; reading needs no network and no model, and the
// same sentence always has the same meaning. What is not understood is said to be so: nothing is guessed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace threewe::language {

inline constexpr std::size_t kLongestCommand = 1000;  ///< [characters] of one text
inline constexpr std::size_t kMostPlaces = 1000;      ///< known places
/// The place that is always known: where the robot began.
inline constexpr std::string_view kStart = "start";

/// What one step of a plan does. The name of each is what `to_text` writes.
enum class Skill : std::uint8_t {
  move_to_place,  ///< drives to `place`
  approach,       ///< drives to `thing`
  move_to,        ///< drives to `x`, `y`, and turns to `theta` where given
  move_forward,   ///< drives `distance` straight on; backwards where negative
  rotate,         ///< turns by `angle`
  search,         ///< looks for `thing`
  explore,        ///< maps what is unknown; in `place` where given
  look,           ///< turns once around to see
  list_things,    ///< says which things are known; in `place` where given
  list_places,    ///< says which places are known
  name_place,     ///< calls the place where the robot is `name`
  answer,         ///< answers a question `about` `thing`, or about its own position
  wait,           ///< stands for `duration`
  follow,         ///< follows the instruction `route`, as of VLN
  done            ///< ends
};
/// Its name, such as "move_to_place".
std::string_view to_string(Skill skill);

/// A thing as it is described. What is not said is empty.
struct ThingPhrase {
  std::string kind = {};     ///< category of objects, such as "chair"; empty: any thing
  std::string color = {};    ///< one of the eleven basic color terms, such as "red"
  std::string which = {};    ///< "nearest" or "farthest"
  std::string next_to = {};  ///< another thing beside it: "[color ]kind"
  std::string place = {};    ///< where it is
  friend bool operator==(const ThingPhrase&, const ThingPhrase&) = default;
};

/// One step of a plan: a skill and its arguments. What a skill does not take, or was not said, is empty.
struct Step {
  Skill skill = Skill::done;            ///< what to do
  std::string about = {};               ///< answer: "exists", "where", "count" or "position"
  std::string place = {};               ///< move_to_place, explore, list_things
  std::string name = {};                ///< name_place
  ThingPhrase thing = {};               ///< approach, search, answer
  std::optional<double> x = {};         ///< [m] move_to, in `map`
  std::optional<double> y = {};         ///< [m] move_to, in `map`
  std::optional<double> theta = {};     ///< [rad] move_to, counter-clockwise from the x axis
  std::optional<double> distance = {};  ///< [m] move_forward
  std::optional<double> angle = {};     ///< [rad] rotate, counter-clockwise
  std::optional<double> duration = {};  ///< [s] wait
  std::string route = {};               ///< follow: the instruction
  friend bool operator==(const Step&, const Step&) = default;
};

/// What became of a text.
enum class ReadingOutcome : std::uint8_t {
  understood,      ///< `steps` say what to do
  ambiguous,       ///< it has several `meanings`: ask
  not_understood,  ///< `word` could not be read
  refused          ///< it asks for what no robot of ours does: `rule`
};
/// Its name, such as "understood".
std::string_view to_string(ReadingOutcome outcome);

/// Why a command is refused.
enum class RefusalRule : std::uint8_t {
  speed,           ///< it asks to be faster than the operating limits
  obstacle,        ///< it asks to drive through, over or against something
  emergency_stop,  ///< it asks to release the emergency stop, which people do by hand
  zone             ///< it asks to enter a keep-out zone
};
/// Its name, such as "obstacle".
std::string_view to_string(RefusalRule rule);

/// What a text was read as. Only what its outcome names is filled.
struct Reading {
  ReadingOutcome outcome = ReadingOutcome::not_understood;  ///< which of the fields below says more
  std::vector<Step> steps = {};                             ///< understood: what to do, in order
  std::vector<std::string> meanings = {};  ///< ambiguous: two or more, sorted: names of places, or plans as text
  std::string word = {};                   ///< not_understood: the first word that could not be read, lower case
  std::optional<RefusalRule> rule = {};    ///< refused: why
  friend bool operator==(const Reading&, const Reading&) = default;
};

/// A step's arguments that were said, by their names, in the order of its text.
std::vector<std::pair<std::string_view, std::variant<std::string, double>>> arguments_of(const Step& step);
/// A step as text: "search(kind=chair, color=red)". Numbers have at most four decimals.
std::string to_text(const Step& step);
/// Canonical text of a reading: steps joined by "; ", or "ambiguous(a | b)", "not_understood(word)", "refused(rule)".
std::string to_text(const Reading& reading);

/// The words, phrases and sentence patterns that are read. Const once loaded; copies share it.
class Lexicon {
 public:
  /// Reads assets/languages/NAME.yaml. Throws ConfigError with file:line.
  static Lexicon load(std::string_view name = "commands_english_v1");
  /// Reads the text of such a file; `name` stands for the file in messages. Throws ConfigError with file:line.
  static Lexicon parse(const std::string& text, const std::string& name);

  /// What the reader sees of it.
  struct Tables;
  const Tables& tables() const { return *tables_; }  ///< of this lexicon

 private:
  std::shared_ptr<const Tables> tables_;
};

/// Reads a command where these places are known, besides `start`. A pure function. Throws ContractError where the text
/// is longer than kLongestCommand, or where a place has no name, one longer than 200 bytes, or one that is not UTF-8.
Reading read(std::string_view text, const Lexicon& lexicon, std::span<const std::string> known_places = {});

}  // namespace threewe::language
