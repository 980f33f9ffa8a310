#include "narrator.hpp"
#include "core/numbers.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "task/path_score.hpp"

namespace threewe::task {
namespace {

using Kind = Clause::Kind;

constexpr double kStep = 0.05;           // [m] between the points at which a path is looked at
constexpr double kShortVisit = 0.3;      // [m] in a room: less is cutting its corner
constexpr double kBesideOpening = 0.35;  // [m] off an opening where a path crosses it
constexpr double kPassedClose = 1.5;     // [m] from the path to a thing that is worth a word
constexpr double kDetour = 1.25;         // times the straight line, and a glance: a path that goes a long way round
constexpr double kAtThing = 0.8;         // [m] from a path to a thing that it goes by
constexpr double kGlance = 1.0;          // [m] of a path that show which way it goes

// A stretch of a path within one room, and how it is left.
struct Leg {
  std::size_t room = 0;
  std::vector<Vec2> points;
  std::optional<std::size_t> opening;
};

double length(const Leg& leg) { return kStep * static_cast<double>(leg.points.size()); }

// The opening that a path goes through at a point.
std::optional<std::size_t> opening_at(const SemanticMap& map, std::size_t from, std::size_t to, Vec2 point) {
  std::optional<std::size_t> nearest;
  double best = kBesideOpening;
  for (std::size_t i = 0; i < map.openings().size(); ++i) {
    const Opening& o = map.openings()[i];
    if (!o.joins(from) || !o.joins(to)) continue;
    const double d = distance_to_segment(point, o.a, o.b);
    if (d <= best) {
      best = d;
      nearest = i;
    }
  }
  return nearest;
}

// The path room by room; nothing where it leaves all rooms, or goes from one to another by no known opening.
std::optional<std::vector<Leg>> legs_of(const SemanticMap& map, const std::vector<Vec2>& path) {
  std::vector<Leg> legs;
  for (const Vec2 point : points_along(path, kStep)) {
    const auto room = map.room_at(point);
    if (!room) return std::nullopt;
    if (legs.empty() || legs.back().room != *room) legs.push_back({.room = *room, .points = {}, .opening = {}});
    legs.back().points.push_back(point);
  }
  // a short visit between two stretches in one room is part of them
  for (std::size_t i = 1; i + 1 < legs.size();) {
    if (length(legs[i]) >= kShortVisit || legs[i - 1].room != legs[i + 1].room) {
      ++i;
      continue;
    }
    for (const std::size_t k : {i, i + 1}) {
      legs[i - 1].points.insert(legs[i - 1].points.end(), legs[k].points.begin(), legs[k].points.end());
    }
    legs.erase(legs.begin() + static_cast<std::ptrdiff_t>(i), legs.begin() + static_cast<std::ptrdiff_t>(i) + 2);
  }
  for (std::size_t i = 0; i + 1 < legs.size(); ++i) {
    legs[i].opening = opening_at(map, legs[i].room, legs[i + 1].room, legs[i + 1].points.front());
    if (!legs[i].opening) return std::nullopt;
  }
  return legs;
}

class Narrator {
 public:
  Narrator(const SemanticMap& map, const Walker& walker, const RngKey& key) : map_(map), walker_(walker), key_(key) {}

  // Says how to go along a leg, up to and through its opening.
  bool cross(const Leg& leg, bool first) {
    const Opening& o = map_.openings()[*leg.opening];
    if (walker_.opening == leg.opening || !set_out(leg, o.crossing(walker_.at))) return false;
    Clause c = empty(Kind::cross);
    const std::string& there = map_.rooms()[o.beyond(leg.room)];
    // by the room's name, by the door, or by both
    const double how = draw();
    if (o.is_door && how < 0.7) c.door = door_phrase(*leg.opening);
    if (!c.door || how > 0.35) c.room = there;
    if (c.door && first && chance(0.5)) c.from = map_.rooms()[leg.room];
    said_.push_back(std::move(c));
    walker_ = through(map_, walker_, *leg.opening);
    return true;
  }

  // Says where to stop.
  bool stop(const Leg& leg, const Ending& ending) {
    Clause c = empty(ending.kind);
    Vec2 to = ending.place;
    if (ending.kind == Kind::stop_at) {
      to = map_.landmarks()[ending.landmark].center;
      if (walker_.opening != ending.opening) return false;
    }
    if (ending.kind == Kind::stop_inside) {
      if (walker_.opening != ending.opening) return false;
      c.room = chance(0.5) ? map_.rooms()[ending.room] : "";
      said_.push_back(std::move(c));
      return true;
    }
    if (!set_out(leg, to)) return false;
    if (ending.kind == Kind::stop_in_middle) c.room = map_.rooms()[ending.room];
    if (ending.kind == Kind::stop_at) {
      const auto thing = thing_phrase(ending.landmark);
      if (!thing) return false;
      c.thing = *thing;
    }
    said_.push_back(std::move(c));
    return true;
  }

  Instruction said() && { return std::move(said_); }

 private:
  // Says which way to turn for a point, and what is passed on the way there; false where that would be misleading.
  bool set_out(const Leg& leg, Vec2 to) {
    Leg rest = leg;
    return go_by_a_thing(rest, to) && set_out_straight(rest, to);
  }

  bool set_out_straight(const Leg& leg, Vec2 to) {
    const Vec2 line = to - walker_.at;
    const double ahead = dot(walker_.heading, line);
    const double left = threewe::cross(walker_.heading, line);
    if (norm(line) > 0.5) {
      // no instruction turns for less than an eighth of a turn, nor around for less than three
      Side side = Side::ahead;
      if (std::fabs(left) > ahead) side = left > 0.0 ? Side::left : Side::right;
      if (-ahead > std::fabs(left)) side = Side::behind;
      if (side != Side::ahead || (2.0 * std::fabs(left) < ahead && chance(0.3))) turn(side);
      if (!truly_goes(leg)) return false;
    }
    if (chance(0.6)) pass_something(leg, to);
    return true;
  }

  // Where a leg goes a long way round, names a thing at its outermost point, if there is one, and goes there first.
  bool go_by_a_thing(Leg& leg, Vec2 to) {
    if (length(leg) <= kDetour * distance(walker_.at, to) + kGlance) return true;
    const auto off = [&](Vec2 p) { return distance_to_segment(p, walker_.at, to); };
    const auto outermost = std::ranges::max_element(leg.points, {}, off);
    std::optional<std::size_t> nearest;
    double best = kAtThing;
    for (std::size_t i = 0; i < map_.landmarks().size(); ++i) {
      if (map_.landmarks()[i].room != leg.room) continue;
      for (const scene::Solid& solid : map_.landmarks()[i].solids) {
        if (distance_to(solid, *outermost) >= best) continue;
        best = distance_to(solid, *outermost);
        nearest = i;
      }
    }
    if (!nearest) return true;
    Leg there = leg;
    there.points.assign(leg.points.begin(), outermost + 1);
    leg.points.erase(leg.points.begin(), outermost);
    if (!set_out_straight(there, map_.landmarks()[*nearest].center)) return false;
    const auto thing = thing_phrase(*nearest);
    if (!thing) return false;
    Clause c = empty(Kind::approach);
    c.thing = *thing;
    said_.push_back(std::move(c));
    walker_ = up_to(map_, walker_, *nearest);
    return true;
  }

  void turn(Side side) {
    Clause c = empty(Kind::turn);
    c.side = side;
    said_.push_back(std::move(c));
    walker_.heading = turned(walker_.heading, side);
    walker_.turned = true;
  }

  // Whether the path itself goes the way that was said: not more than 80 degrees off.
  bool truly_goes(const Leg& leg) const {
    const std::size_t i = std::min(leg.points.size() - 1, static_cast<std::size_t>(kGlance / kStep));
    const Vec2 way = leg.points[i] - leg.points.front();
    return !walker_.turned || dot(walker_.heading, way) >= 0.17 * norm(way);
  }

  // Names something that is passed by the straight line as well as by the path, the nearest to it.
  void pass_something(const Leg& leg, Vec2 to) {
    std::optional<std::size_t> nearest;
    Side nearest_side{};
    double best = kPassedClose;
    for (std::size_t i = 0; i < map_.landmarks().size(); ++i) {
      const Landmark& thing = map_.landmarks()[i];
      if (thing.room != leg.room) continue;
      for (const Side side : {Side::left, Side::right}) {
        if (!is_passed(walker_.at, to, thing.center, side)) continue;
        const double d = passing_distance(leg.points, thing.center, side);
        if (d >= best) continue;
        best = d;
        nearest = i;
        nearest_side = side;
      }
    }
    if (!nearest) return;
    Clause c = empty(Kind::pass);
    c.side = nearest_side;
    c.thing.noun = chance(0.7) ? map_.landmarks()[*nearest].noun : map_.landmarks()[*nearest].general;
    said_.push_back(std::move(c));
  }

  // How near a path comes to a point that it passes on a side; infinity if it doesn't.
  static double passing_distance(const std::vector<Vec2>& points, Vec2 thing, Side side) {
    const auto nearest = std::ranges::min_element(points, {}, [&](Vec2 p) { return distance(p, thing); });
    if (nearest == points.begin() || nearest + 1 >= points.end()) return kInfinity;
    const double left = threewe::cross(*(nearest + 1) - *(nearest - 1), thing - *nearest);
    return (left > 0.0) == (side == Side::left) ? distance(*nearest, thing) : kInfinity;
  }

  // Says which door, if that can be said.
  std::optional<DoorPhrase> door_phrase(std::size_t opening) {
    Clause c = empty(Kind::cross);
    const Side side = side_of(along_axis(walker_.heading), map_.openings()[opening].out_of(walker_.room));
    std::vector<DoorPhrase> phrases = {{.ordinal = 0, .side = std::nullopt}};
    if (is_along_an_axis()) {
      phrases.push_back({.ordinal = 0, .side = side});
      for (int n = 1; n <= kLastOrdinal && (side == Side::left || side == Side::right); ++n) {
        phrases.push_back({.ordinal = n, .side = side});
      }
    }
    const std::vector<Walker> walkers = wherever_entered();
    std::erase_if(phrases, [&](const DoorPhrase& phrase) {
      c.door = phrase;
      return std::ranges::any_of(walkers,
                                 [&](const Walker& w) { return candidates(map_, w, c) != std::vector{opening}; });
    });
    if (phrases.empty()) return std::nullopt;
    return phrases[pick(phrases.size())];
  }

  // Says which thing, if that can be said: simply, or by its side, place in a row, neighbour or distance.
  std::optional<Thing> thing_phrase(std::size_t landmark) {
    const Landmark& meant = map_.landmarks()[landmark];
    std::vector<Thing> simple;
    std::vector<Thing> other;
    for (const std::string& noun : {meant.noun, meant.general}) {
      const Thing plain{.which = Thing::Which::any, .ordinal = 0, .noun = noun, .side = std::nullopt, .next_to = ""};
      simple.push_back(plain);
      for (const std::size_t i : map_.beside(landmark)) {
        if (map_.landmarks()[i].general == meant.general) continue;
        other.push_back(plain);
        other.back().next_to = chance(0.5) ? map_.landmarks()[i].noun : map_.landmarks()[i].general;
      }
      if (candidates(map_, walker_, plain).size() == 1) continue;  // one needs no telling apart
      for (const Thing::Which which : {Thing::Which::nearest, Thing::Which::farthest}) {
        other.push_back(plain);
        other.back().which = which;
      }
      if (!is_along_an_axis()) continue;
      const double left = threewe::cross(along_axis(walker_.heading), meant.center - walker_.at);
      for (const Side side : {Side::left, Side::right}) {
        if ((side == Side::left ? left : -left) <= kAside) continue;
        other.push_back(plain);
        other.back().side = side;
        for (int n = 1; n <= kLastOrdinal; ++n) {
          other.push_back({.which = Thing::Which::nth, .ordinal = n, .noun = noun, .side = side, .next_to = ""});
        }
      }
    }
    const std::vector<Walker> walkers = wherever_entered();
    const auto fails = [&](const Thing& t) {
      return std::ranges::any_of(walkers,
                                 [&](const Walker& w) { return candidates(map_, w, t) != std::vector{landmark}; });
    };
    std::erase_if(simple, fails);
    std::erase_if(other, fails);
    if (!simple.empty() && (other.empty() || chance(0.6))) return simple[pick(simple.size())];
    if (other.empty()) return std::nullopt;
    return other[pick(other.size())];
  }

  // The walker, and others who have just crossed the same border near its ends: what is said must be right for them
  // too.
  std::vector<Walker> wherever_entered() const {
    std::vector<Walker> walkers = {walker_};
    if (!walker_.opening) return walkers;
    const Opening& o = map_.openings()[*walker_.opening];
    if (distance_to_segment(walker_.at, o.a, o.b) > kStep) return walkers;
    for (const Vec2 end : {o.a, o.b}) {
      walkers.push_back(walker_);
      walkers.back().at = o.crossing(end);
    }
    return walkers;
  }

  // Left and right of a room's axes mean something to a walker who looks along one, give or take 25 degrees.
  bool is_along_an_axis() const {
    return std::max(std::fabs(walker_.heading.x), std::fabs(walker_.heading.y)) >= 0.906;
  }

  static Clause empty(Kind kind) {
    return {.kind = kind, .side = {}, .thing = {}, .door = std::nullopt, .from = "", .room = ""};
  }
  double draw() { return uniform(key_, sample_++); }
  bool chance(double probability) { return draw() < probability; }
  std::size_t pick(std::size_t count) { return static_cast<std::size_t>(draw() * static_cast<double>(count)); }

  const SemanticMap& map_;
  Walker walker_;
  RngKey key_;
  std::uint64_t sample_ = 0;
  Instruction said_;
};

}  // namespace

std::optional<Instruction> describe(const SemanticMap& map, const Pose2D& start, const std::vector<Vec2>& path,
                                    const Ending& ending, const RngKey& key) {
  const auto legs = legs_of(map, path);
  const auto walker = walker_at(map, start);
  if (!legs || !walker || legs->back().room != ending.room) return std::nullopt;
  Narrator narrator(map, *walker, key);
  for (std::size_t i = 0; i + 1 < legs->size(); ++i) {
    if (!narrator.cross((*legs)[i], i == 0)) return std::nullopt;
  }
  if (!narrator.stop(legs->back(), ending)) return std::nullopt;
  return std::move(narrator).said();
}

}  // namespace threewe::task
