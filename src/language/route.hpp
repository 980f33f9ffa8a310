// Route: a navigation instruction's clauses and their English. The two are made from one another by a grammar:
//
//   route        clauses, joined by "," "and" "then" "."
//   clause       "turn left|right|around" | "go straight ahead"
//                "walk past THING on your left|right"
//                "walk to THING"
//                "go through DOOR [into ROOM]" | "enter ROOM [through DOOR]" | "leave ROOM through DOOR"
//                "stop at THING" | "stop in the middle of ROOM" | "stop just inside [ROOM]"
//   THING        "the [first|second|third|fourth|nearest|farthest] NOUN [on your left|right] [next to the NOUN]"
//   DOOR         "the [first|second|third|fourth] door [on your left|right|straight ahead|behind you]"
//   ROOM         "the NAME", or "NAME" where it ends in a number
//
// Most words have synonyms: "take" for "go through", "doorway" for "door", "wait" for "stop", and so on. Read, but not
// written, are "make a left", "walk past THING" without a side, "walk to ROOM" and "stop at ROOM" for entering it,
// "stop here", and more synonyms.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/rng.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::language {

/// As seen in the direction of walking.
enum class Side : std::uint8_t { left, right, ahead, behind };

/// The lowest and the highest number that is said: "first" to "fourth".
inline constexpr int kLastOrdinal = 4;

/// Which thing is meant. What is not said is empty.
struct Thing {
  enum class Which : std::uint8_t { any, nth, nearest, farthest };
  Which which = Which::any;
  int ordinal = 0;  ///< 1 to 4, of those that lie ahead, for `nth`
  std::string noun = {};
  std::optional<Side> side = {};  ///< left or right
  std::string next_to = {};       ///< noun of another thing beside it
  friend bool operator==(const Thing&, const Thing&) = default;
};

/// Which door is meant.
struct DoorPhrase {
  int ordinal = 0;  ///< 1 to 4, of those that lie ahead on the side; 0 = not said
  std::optional<Side> side;
  friend bool operator==(const DoorPhrase&, const DoorPhrase&) = default;
};

/// One thing to do.
struct Clause {
  enum class Kind : std::uint8_t { turn, pass, approach, cross, stop_at, stop_in_middle, stop_inside, stop_here };
  Kind kind{};
  Side side{};  ///< turn: where to, ahead for "straight ahead"; pass: where the thing is, ahead where not said
  Thing thing;  ///< pass, approach, stop_at
  std::optional<DoorPhrase> door;  ///< cross
  std::string from;                ///< cross: the room that is left
  std::string room;                ///< cross: the room that is entered; stop_in_middle, stop_inside
  friend bool operator==(const Clause&, const Clause&) = default;
};

using Route = std::vector<Clause>;

/// The names that a route may use.
struct RouteNames {
  std::vector<std::string> rooms;   ///< such as "open office"
  std::vector<std::string> things;  ///< such as "office chair"
};

/// A route enters a room that has no such name.
class UnknownRoom : public ConfigError {
 public:
  using ConfigError::ConfigError;
};

/// The route in English; synonyms are drawn from `key`.
std::string to_text(const Route& route, const RngKey& key);

/// What a text says. Throws UnknownRoom naming the nearest known one, and ConfigError where the text cannot be
/// understood otherwise.
Route parse_route(std::string_view text, const RouteNames& names);

}  // namespace threewe::language
