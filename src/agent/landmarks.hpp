// Landmarks: which of the things that the robot has seen in a room a route means, and where to stand at one.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "agent/coverage.hpp"
#include "agent/rooms.hpp"
#include "language/route.hpp"
#include "semantics/semantic_map.hpp"

namespace threewe::agent {

/// Where a route has come to: in the opening or at the thing of the last clause, in the direction of walking.
struct Walker {
  Vec2 at;       ///< [m]
  Vec2 heading;  ///< of length 1
  std::size_t room = 0;
  std::optional<Opening> entered{};                ///< through which the room was entered, seen from before
  std::size_t from = 0;                            ///< the room before
  Vec2 since;                                      ///< [m] the middle of that opening, or the start
  bool turned = false;                             ///< just now: what comes next is ahead
  std::vector<const language::Clause*> passing{};  ///< what must be passed on the way to what comes next
};

/// What things are called, and which kinds of the detector are meant by that.
class Nouns {
 public:
  /// Of a detector with these labels, in the words of assets/languages.
  explicit Nouns(const std::vector<std::string>& labels);
  std::vector<std::string> all() const;
  /// Probability that a thing is called so, as far as views can say that; never 0.
  double probability(const semantics::MappedThing& thing, const std::string& noun) const;
  /// Whether it is a kind of the detector, and no name of one shape among others.
  bool is_kind(const std::string& noun) const;
  /// Whether the detector has its kind.
  bool has_kind(const std::string& noun) const { return kinds_.at(noun) < labels_.size(); }

 private:
  std::vector<std::string> labels_;
  std::map<std::string, std::size_t> kinds_;
};

/// A thing that may be meant, and how well it fits: log-likelihoods and penalties of the same size.
struct Candidate {
  semantics::MappedThing thing;
  double probability = 0.0;  ///< that it is called so
  double score = 0.0;
};

/// The things that seem to be in a room.
std::vector<semantics::MappedThing> things_in(const semantics::SemanticMap& map, const semantics::Place& room);
/// How little a point agrees with what was said of the way to it.
double disagreement(const Walker& walker, const std::vector<semantics::MappedThing>& things, const Nouns& nouns,
                    Vec2 to);
/// The things of a room that a phrase may mean, the best first.
std::vector<Candidate> rank(const Walker& walker, const semantics::Place& room,
                            const std::vector<semantics::MappedThing>& things, const Nouns& nouns,
                            const language::Thing& meant);
/// Where a thing is by the map of what is occupied, that was seen from a point: farther away than it seemed, where
/// nothing stands.
Vec2 by_the_map(const map::OccupancyGrid& grid, Vec2 from, Vec2 thing);
/// Where to stop at a thing that is within a room: of the floor near it, the point that is nearest to `since`.
std::optional<Vec2> place_at(const map::OccupancyGrid& grid, const Reachable& reachable, const semantics::Place& room,
                             Vec2 thing, Vec2 since);

}  // namespace threewe::agent
