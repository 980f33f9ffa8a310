#include "agent/landmarks.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/exact.hpp"
#include "language/vocabulary.hpp"

namespace threewe::agent {
namespace {

using language::Clause;
using language::Side;
using language::Thing;
using map::OccupancyGrid;
using semantics::MappedThing;
using semantics::Place;
using semantics::SemanticMap;

constexpr double kAside = 0.3;         // [m] from the line of walking, within which a thing is on both sides
constexpr double kPassedWithin = 2.0;  // [m] of the way, a thing that is passed
constexpr double kNextTo = 1.3;        // [m] between the centres of things next to each other
constexpr double kWallThings = 0.2;    // [m] outside of a room, where things at its walls may seem to be
constexpr double kUnknownKind = 0.1;   // probability of a kind that the detector does not have
constexpr double kLeastKind = 0.05;    // and the least of one that it has
constexpr double kPlausible = 0.3;     // probability of a kind from which a thing counts among others of that kind
constexpr double kEmpty = 0.3;         // [m] around a thing, where nothing may be occupied
constexpr double kTooNear = 1.5;       // [m] that a thing may seem nearer than it is
constexpr double kDepth = 0.2;         // [m] from its face to its middle
constexpr double kWall = 0.15;         // [m] from a room's border, what is of the wall
constexpr double kJoined = 0.16;       // [m] between parts of one thing
constexpr double kExtent = 1.2;        // [m] from a thing's middle to its ends, at most
constexpr double kAtThing = 0.5;       // [m] from it, where one stops
constexpr double kHalf = 0.35;         // [m] from the middle of a thing to its side, where the map does not show it

// Whether a thing is passed on a side on the straight way from `a` to `b`.
bool is_passed(Vec2 a, Vec2 b, Vec2 thing, Side side) {
  const double length = distance(a, b);
  if (length < kAside) return false;
  const Vec2 along = (1.0 / length) * (b - a);
  const double ahead = dot(thing - a, along);
  const double left = cross(along, thing - a);
  return ahead > 0.0 && ahead < length && std::fabs(left) <= kPassedWithin &&
         (side == Side::ahead || (side == Side::left ? left : -left) > 0.0);
}

bool occupied(const OccupancyGrid& grid, Vec2 point) {
  return grid.at(grid.cell(point)) >= OccupancyGrid::kOccupiedThreshold;
}

// The occupied cells around a point, within a room but for its walls.
std::vector<Vec2> occupied_around(const OccupancyGrid& grid, const Place& room, Vec2 middle, double radius) {
  std::vector<Vec2> found;
  const auto reach = static_cast<int>(radius / grid.resolution);
  const map::Cell here = grid.cell(middle);
  for (int dy = -reach; dy <= reach; ++dy) {
    for (int dx = -reach; dx <= reach; ++dx) {
      const Vec2 point = grid.center({here.x + dx, here.y + dy});
      if (!occupied(grid, point) || distance(point, middle) > radius) continue;
      bool inside = true;
      for (const Vec2 off : std::array<Vec2, 4>{{{kWall, 0}, {-kWall, 0}, {0, kWall}, {0, -kWall}}})
        inside = inside && SemanticMap::contains(room, point + off);
      if (inside) found.push_back(point);
    }
  }
  return found;
}

// Those that belong to what stands at a point: they hang together with one that is near to it.
std::vector<Vec2> body_of(const OccupancyGrid& grid, const Place& room, Vec2 thing) {
  std::vector<Vec2> others = occupied_around(grid, room, thing, kExtent);
  std::vector<Vec2> body;
  const auto take = [&](const auto& belongs) {
    const auto rest = std::stable_partition(others.begin(), others.end(), [&](Vec2 p) { return !belongs(p); });
    const bool any = rest != others.end();
    body.insert(body.end(), rest, others.end());
    others.erase(rest, others.end());
    return any;
  };
  take([&](Vec2 point) { return distance(point, thing) <= kHalf; });
  std::size_t next = 0;
  while (next < body.size()) {  // it grows
    const Vec2 here = body[next++];
    take([&](Vec2 point) { return distance(point, here) <= kJoined; });
  }
  return body;
}

}  // namespace

Nouns::Nouns(const std::vector<std::string>& labels) : labels_(labels) {
  for (std::size_t i = 1; i < labels.size(); ++i) kinds_[labels[i]] = i;
  const language::Language language = language::Language::load();
  for (const auto& [shape, noun] : language.nouns()) {
    const auto kind = std::ranges::find(labels, shape.first);
    kinds_.emplace(noun, static_cast<std::size_t>(kind - labels.begin()));
  }
}

std::vector<std::string> Nouns::all() const {
  std::vector<std::string> names;
  for (const auto& [noun, kind] : kinds_) names.push_back(noun);
  return names;
}

double Nouns::probability(const MappedThing& thing, const std::string& noun) const {
  const std::size_t kind = kinds_.at(noun);
  return kind < labels_.size() ? std::max(kLeastKind, thing.kinds[kind]) : kUnknownKind;
}

bool Nouns::is_kind(const std::string& noun) const { return has_kind(noun) && labels_[kinds_.at(noun)] == noun; }

std::vector<MappedThing> things_in(const SemanticMap& map, const Place& room) {
  std::vector<MappedThing> found;
  for (const MappedThing& thing : map.things()) {
    bool inside = SemanticMap::contains(room, thing.position);
    for (const Vec2 off :
         std::array<Vec2, 4>{{{kWallThings, 0}, {-kWallThings, 0}, {0, kWallThings}, {0, -kWallThings}}})
      inside = inside || SemanticMap::contains(room, thing.position + off);
    if (inside) found.push_back(thing);
  }
  return found;
}

double disagreement(const Walker& walker, const std::vector<MappedThing>& things, const Nouns& nouns, Vec2 to) {
  constexpr double kNotAhead = 2.0;
  constexpr double kNotPassed = 0.7;
  const Vec2 way = to - walker.at;
  double sum = 0.0;
  if (walker.turned && norm(way) > kAside && dot(walker.heading, way) < 0.5 * norm(way)) sum += kNotAhead;
  for (const Clause* pass : walker.passing) {
    double best = 0.0;
    for (const MappedThing& thing : things) {
      if (is_passed(walker.at, to, thing.position, pass->side))
        best = std::max(best, nouns.probability(thing, pass->thing.noun));
    }
    sum += kNotPassed * (1.0 - best);
  }
  return sum;
}

std::vector<Candidate> rank(const Walker& walker, const Place& room, const std::vector<MappedThing>& things,
                            const Nouns& nouns, const Thing& meant) {
  constexpr double kWrongSide = 3.0;
  constexpr double kNotBeside = 1.5;
  constexpr double kRank = 1.0;  // for each place in a row that it is off
  constexpr double kFar = 0.6;   // for each metre that it is not the nearest or farthest
  const Vec2 axis = along_walls(room, walker.heading);
  const auto ahead = [&](const MappedThing& t) { return dot(axis, t.position - walker.at); };
  const auto left = [&](const MappedThing& t) { return cross(axis, t.position - walker.at); };
  const auto is_beside = [&](const MappedThing& t) {
    double best = 0.0;
    for (const MappedThing& other : things) {
      if (other.id != t.id && distance(other.position, t.position) < kNextTo)
        best = std::max(best, nouns.probability(other, meant.next_to));
    }
    return best;
  };

  std::vector<Candidate> found;
  for (const MappedThing& thing : things) {
    Candidate one{.thing = thing, .probability = nouns.probability(thing, meant.noun), .score = 0.0};
    one.score = exact::log(one.probability) - disagreement(walker, things, nouns, thing.position);
    if (meant.side && (*meant.side == Side::left ? left(thing) : -left(thing)) < -kAside) one.score -= kWrongSide;
    if (!meant.next_to.empty()) one.score -= kNotBeside * (1.0 - is_beside(thing));
    found.push_back(one);
  }

  // of those that may well be meant, the one that stands out
  std::vector<MappedThing> plausible;
  for (const Candidate& one : found) {
    const bool right_side = !meant.side || (*meant.side == Side::left ? left(one.thing) : -left(one.thing)) >= -kAside;
    const bool counted = meant.which != Thing::Which::nth || ahead(one.thing) >= -kAside;
    if (one.probability >= kPlausible && right_side && counted) plausible.push_back(one.thing);
  }
  if (meant.which == Thing::Which::nth) {
    for (Candidate& one : found) {
      const auto before = std::ranges::count_if(
          plausible, [&](const MappedThing& t) { return t.id != one.thing.id && ahead(t) < ahead(one.thing); });
      one.score -= kRank * std::fabs(static_cast<double>(before + 1 - meant.ordinal));
      if (ahead(one.thing) < -kAside) one.score -= kWrongSide;
    }
  } else if (meant.which != Thing::Which::any) {
    const double sign = meant.which == Thing::Which::nearest ? 1.0 : -1.0;
    for (Candidate& one : found) {
      double best = sign * distance(one.thing.position, walker.at);
      for (const MappedThing& t : plausible) best = std::min(best, sign * distance(t.position, walker.at));
      one.score -= kFar * (sign * distance(one.thing.position, walker.at) - best);
    }
  }
  std::ranges::stable_sort(found, std::greater<>(), &Candidate::score);
  return found;
}

Vec2 by_the_map(const OccupancyGrid& grid, Vec2 from, Vec2 thing) {
  const double length = distance(from, thing);
  if (length < kEmpty) return thing;
  const Vec2 along = (1.0 / length) * (thing - from);
  const auto steps = static_cast<int>((kEmpty + kTooNear) / grid.resolution);
  for (int i = 0; i <= steps; ++i) {
    const double way = i * grid.resolution - kEmpty;
    const Vec2 point = thing + way * along;
    if (occupied(grid, point)) return way <= kEmpty ? thing : point + kDepth * along;
  }
  return thing;
}

std::optional<Vec2> place_at(const OccupancyGrid& grid, const Reachable& reachable, const Place& room, Vec2 thing,
                             Vec2 since) {
  constexpr double kTooFar = 20.0;  // weight of what is not at the thing, against the way there
  constexpr double kOutside = 5.0;  // [m]
  const std::vector<Vec2> body = body_of(grid, room, thing);
  return reachable.best([&](Vec2 point) {
    double away = std::max(0.0, distance(point, thing) - kHalf);
    for (const Vec2 part : body) away = std::min(away, distance(point, part));
    return kTooFar * std::max(0.0, away - kAtThing) + distance(point, since) +
           (SemanticMap::contains(room, point) ? 0.0 : kOutside);
  });
}

}  // namespace threewe::agent
