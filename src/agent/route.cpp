// Route follower: the clauses of a VLN instruction one after the other, by the rooms that have names, the openings
// between them in the robot's map, and the things that it has seen. It keeps where the route has come to, as a person
// would who walks it: in the opening or at the thing of the last clause, in the direction of walking.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "agent/landmarks.hpp"
#include "agent/rooms.hpp"
#include "agent/skills.hpp"
#include "core/exact.hpp"
#include "language/route.hpp"

namespace threewe::agent {
namespace {

using language::Clause;
using language::Side;
using language::Thing;
using semantics::Place;
using semantics::SemanticMap;
using Kind = Clause::Kind;

constexpr double kBehind = 0.6;        // [m] behind an opening, to where the robot drives
constexpr double kInside = 0.7;        // [m] behind it, "just inside"
constexpr double kLookFrom = 2.5;      // [m] from a part of a border, to see whether it is open
constexpr double kBeforeBorder = 0.3;  // [m] of it, what must be in sight
constexpr double kSameBorder = 0.6;    // [m] around a point that was looked at
constexpr int kMostLooks = 10;         // at the border of one room
constexpr int kMostViewpoints = 6;     // in one room
constexpr int kMostStops = 4;          // tries to get nearer to a point
constexpr double kTolerance = 0.3;     // [m] of where it drives to
constexpr double kClear = 0.8;         // from which one is not looked for any more
constexpr double kSure = 0.85;         // from which it counts as seen

Vec2 turned(Vec2 heading, Side side) {
  switch (side) {
    case Side::left: return {-heading.y, heading.x};
    case Side::right: return {heading.y, -heading.x};
    case Side::behind: return -1.0 * heading;
    case Side::ahead: break;
  }
  return heading;
}

Side side_of(Vec2 axis, Vec2 out) {
  const double along = dot(axis, out);
  if (std::fabs(along) > 0.7) return along > 0.0 ? Side::ahead : Side::behind;
  return cross(axis, out) > 0.0 ? Side::left : Side::right;
}

double angle_of(Vec2 direction) { return exact::atan2(direction.y, direction.x); }

// An opening that may be meant, and how little it fits.
struct WayOut {
  Opening opening;
  double penalty = 0.0;
};

class FollowRoute : public SkillRun {
 public:
  FollowRoute(Body& body, language::Route route, Nouns nouns)
      : route_(std::move(route)), nouns_(std::move(nouns)), places_(body.map.places()) {}

  std::optional<Outcome> update(Body& body) override {
    if (!walker_.has_value()) {
      if (auto failed = begin(body)) return failed;
    }
    if (drive_.active()) {
      const auto moved = drive_.take();
      if (!moved) return {};
      moved_ = *moved;
    }
    switch (phase_) {
      case Phase::clause: return begin_clause(body);
      case Phase::looking: return go_through(body);
      case Phase::crossing: return crossed(body);
      case Phase::finding: return find(body);
      case Phase::going: return arrived(body);
      case Phase::ending: return ended(body);
    }
    return {};
  }
  void cancel() override { drive_.cancel(); }

 private:
  enum class Phase : std::uint8_t { clause, looking, crossing, finding, going, ending };

  const Clause& clause() const { return route_[next_]; }
  const Place& room() const { return places_[walker_->room]; }
  bool in_room(Vec2 point) const { return SemanticMap::contains(room(), point); }

  std::optional<Outcome> begin(Body& body) {
    const auto room = room_at(places_, body.position());
    if (!room) return Outcome{"not_found", "the robot is in none of the places that it knows the borders of"};
    const Vec2 here = body.position();
    walker_ = Walker{.at = here,
                     .heading = rotate({1.0, 0.0}, body.robot.pose().map_from_base().theta),
                     .room = *room,
                     .entered = {},
                     .from = *room,
                     .since = here,
                     .turned = false,
                     .passing = {}};
    return {};
  }

  std::optional<Outcome> next() {
    ++next_;
    phase_ = Phase::clause;
    looks_ = 0;
    stops_ = 0;
    looked_at_.clear();
    if (next_ < route_.size()) return {};
    return Outcome{"done", {}, answer_, thing_, verified_};
  }

  std::optional<Outcome> begin_clause(Body& body) {
    switch (clause().kind) {
      case Kind::turn:
        walker_->heading = turned(walker_->heading, clause().side);
        walker_->turned = true;
        if (clause().side != Side::ahead) {
          const double now = body.robot.pose().map_from_base().theta;
          drive_.begin(body, nav::Rotate{wrap_angle(angle_of(walker_->heading) - now), 0.1});
        }
        return next();
      case Kind::pass: walker_->passing.push_back(&clause()); return next();
      case Kind::cross: return go_through(body);
      case Kind::approach:
      case Kind::stop_at:
        phase_ = Phase::finding;
        viewpoints_ = -1;
        return find(body);
      case Kind::stop_in_middle: return stop_in(body, SemanticMap::center(room()));
      case Kind::stop_inside:
        if (!walker_->entered) return stop_in(body, body.position());
        return stop_in(body, walker_->entered->middle() + kInside * walker_->entered->normal);
      case Kind::stop_here: return next();
    }
    return {};
  }

  // Through openings

  std::optional<Outcome> go_through(Body& body) {
    const Border border = border_of(body.robot.map(), places_, walker_->room);
    const auto out = ways_out(body, border);
    while (looks_ < kMostLooks) {
      const auto unseen = worth_a_look(border, out);
      if (!unseen) break;
      if (look_at(body, *unseen)) return {};
    }
    if (out.empty() && !clause().room.empty()) {
      if (const auto seen = unseen_way(border)) return drive_through(body, *seen);
    }
    if (out.empty()) return Outcome{"not_found", fmt::format("there is no such way out of the {}", room().name)};
    return drive_through(body, out.front().opening);
  }

  // Somewhere on the border to the room that is said, where no map shows a way: the way is found on the drive.
  std::optional<Opening> unseen_way(const Border& border) const {
    const auto to = std::ranges::find_if(
        border.unseen, [&](const UnseenBorder& unseen) { return places_[unseen.to].name == clause().room; });
    if (to == border.unseen.end()) return {};
    return Opening{.is_door = false, .to = to->to, .a = to->point, .b = to->point, .normal = to->normal};
  }

  std::optional<Outcome> drive_through(Body& body, const Opening& opening) {
    chosen_ = opening;
    phase_ = Phase::crossing;
    beside_ = false;
    const Vec2 to = chosen_.crossing(walker_->at) + kBehind * chosen_.normal;
    drive_.begin(body, nav::MoveTo{to, angle_of(chosen_.normal), kTolerance, 0.3});
    return {};
  }

  // The openings that a clause may mean, the best first.
  std::vector<WayOut> ways_out(const Body& body, const Border& border) const {
    constexpr double kNoDoor = 2.0;
    constexpr double kWrongSide = 3.0;
    constexpr double kWrongRank = 1.5;
    constexpr double kPerMetre = 0.05;
    const auto& phrase = clause().door;
    if (!clause().from.empty() && clause().from != room().name) return {};
    const Vec2 axis = along_walls(room(), walker_->heading);
    const auto things = things_in(body.map, room());
    std::vector<Opening> sided;  // doors on the side that is said
    for (const Opening& o : border.openings) {
      if (phrase && o.is_door && !turns_back(o) && (!phrase->side || side_of(axis, o.normal) == *phrase->side))
        sided.push_back(o);
    }
    std::vector<WayOut> found;
    for (const Opening& o : border.openings) {
      if (turns_back(o) || (!clause().room.empty() && places_[o.to].name != clause().room)) continue;
      WayOut way{.opening = o, .penalty = disagreement(*walker_, things, nouns_, o.crossing(walker_->at))};
      way.penalty += kPerMetre * distance(o.middle(), walker_->at);
      bool fits = true;
      if (phrase && !o.is_door) way.penalty += kNoDoor;
      if (phrase && phrase->side && side_of(axis, o.normal) != *phrase->side) {
        way.penalty += kWrongSide;
        fits = false;
      }
      if (phrase && phrase->ordinal > 0) {
        const double here = dot(axis, o.middle() - walker_->at);
        const auto before = std::ranges::count_if(sided, [&](const Opening& other) {
          const double there = dot(axis, other.middle() - walker_->at);
          return there >= 0.0 && there < here - 0.01;
        });
        if (here < 0.0 || before + 1 != phrase->ordinal) {
          way.penalty += kWrongRank;
          fits = false;
        }
      }
      if (fits || !clause().room.empty()) found.push_back(way);
    }
    std::ranges::stable_sort(found, {}, &WayOut::penalty);
    return found;
  }

  bool turns_back(const Opening& o) const {
    return walker_->entered && o.to == walker_->from && distance(o.middle(), walker_->entered->middle()) < kSameBorder;
  }

  // A part of the border that must be seen before it is clear which opening is meant.
  std::optional<UnseenBorder> worth_a_look(const Border& border, const std::vector<WayOut>& out) const {
    const Vec2 axis = along_walls(room(), walker_->heading);
    const bool counts = clause().door && (clause().door->ordinal > 0 || clause().room.empty());
    if (!out.empty() && !counts) return {};
    const double far = out.empty() ? 1e9 : dot(axis, out.front().opening.middle() - walker_->at);
    std::optional<UnseenBorder> nearest;
    const auto& door = clause().door;
    for (const UnseenBorder& unseen : border.unseen) {
      const Vec2 point = unseen.point;
      if (std::ranges::any_of(looked_at_, [&](Vec2 seen) { return distance(seen, point) < kSameBorder; })) continue;
      if (out.empty() && !clause().room.empty() && places_[unseen.to].name != clause().room) continue;
      if (door && door->side && side_of(axis, unseen.normal) != *door->side) continue;
      const double ahead = dot(axis, point - walker_->at);
      if (counts && door->ordinal > 0 && (ahead < 0.0 || ahead > far)) continue;
      if (!nearest || distance(point, walker_->at) < distance(nearest->point, walker_->at)) nearest = unseen;
    }
    return nearest;
  }

  // Drives to where a part of the border can be seen from.
  bool look_at(Body& body, const UnseenBorder& unseen) {
    const Vec2 point = unseen.point;
    looked_at_.push_back(point);
    const auto& grid = body.robot.map();
    const Vec2 inside = point - kBeforeBorder * unseen.normal;
    const auto stand = body.reachable().nearest([&](Vec2 from) {
      return in_room(from) && distance(from, point) < kLookFrom &&
             dot(point - from, unseen.normal) >= 0.5 * distance(from, point) && in_sight(grid, from, inside);
    });
    phase_ = Phase::looking;
    if (!stand) return false;
    ++looks_;
    drive_.begin(body, nav::MoveTo{*stand, {}, kTolerance, 0.2});
    return true;
  }

  std::optional<Outcome> crossed(Body& body) {
    const bool through = SemanticMap::contains(places_[chosen_.to], body.position());
    if (!moved_.success && !through && !beside_) {  // something stands there: as near to it as it gets
      beside_ = true;
      const Place& to = places_[chosen_.to];
      const Vec2 goal = chosen_.middle() + kBehind * chosen_.normal;
      const auto floor = body.reachable().best(
          [&](Vec2 point) { return distance(point, goal) + (SemanticMap::contains(to, point) ? 0.0 : 10.0); });
      if (floor && SemanticMap::contains(to, *floor)) {
        drive_.begin(body, nav::MoveTo{*floor, angle_of(chosen_.normal), kTolerance, 0.3});
        return {};
      }
    }
    if (!moved_.success && !through) return Outcome{std::string(to_string(moved_.reason)), moved_.detail};
    walker_->at = chosen_.crossing(walker_->at);
    walker_->heading = chosen_.normal;
    walker_->from = std::exchange(walker_->room, chosen_.to);
    walker_->entered = chosen_;
    walker_->since = chosen_.middle();
    walker_->turned = false;
    walker_->passing.clear();
    return next();
  }

  // To things

  // Looks around, then from where the room has not been seen, until it is clear which thing is meant.
  std::optional<Outcome> find(Body& body) {
    const Thing& meant = clause().thing;
    const auto ranked = rank(*walker_, room(), things_in(body.map, room()), nouns_, meant);
    const auto clear = [&](const Candidate& one) { return one.probability >= kClear; };
    const bool unique = meant.which == Thing::Which::any && nouns_.is_kind(meant.noun) && !ranked.empty() &&
                        clear(ranked.front()) && std::ranges::count_if(ranked, clear) == 1;
    if (viewpoints_ < 0) {
      viewpoints_ = 0;
      drive_.begin(body, nav::Rotate{2.0 * std::numbers::pi, 0.2});
      return {};
    }
    if (!unique && viewpoints_ < kMostViewpoints) {
      const auto viewpoint =
          body.coverage.next(body.robot.map(), body.reachable(), [&](Vec2 point) { return in_room(point); });
      if (viewpoint) {
        ++viewpoints_;
        body.coverage.add(viewpoint->shows);
        drive_.begin(body, nav::MoveTo{viewpoint->stand, viewpoint->heading, kTolerance, 0.2});
        return {};
      }
    }
    if (ranked.empty()) return Outcome{"not_found", fmt::format("there is no {} in the {}", meant.noun, room().name)};
    found_ = ranked.front();
    phase_ = Phase::going;
    const auto& grid = body.robot.map();
    const Vec2 center = by_the_map(grid, walker_->at, found_.thing.position);
    const auto stand = place_at(grid, body.reachable(), room(), center, walker_->since);
    drive_.begin(body, nav::MoveTo{stand.value_or(center), {}, kTolerance, 0.2});
    return {};
  }

  std::optional<Outcome> arrived(Body& body) {
    if (!moved_.success) return Outcome{std::string(to_string(moved_.reason)), moved_.detail};
    const Vec2 center = found_.thing.position;
    if (distance(center, walker_->at) > 0.0)
      walker_->heading = (1.0 / distance(center, walker_->at)) * (center - walker_->at);
    walker_->at = center;
    walker_->turned = false;
    walker_->passing.clear();
    thing_ = found_.thing.id;
    verified_ = nouns_.has_kind(clause().thing.noun) && found_.probability >= kSure;
    answer_ = fmt::format("I am at the {}: a {}.", clause().thing.noun, in_words(body, found_.thing));
    return next();
  }

  // To the floor nearest to a point of the room
  std::optional<Outcome> stop_in(Body& body, Vec2 point) {
    if (!clause().room.empty() && clause().room != room().name)
      return Outcome{"not_found", fmt::format("this is the {}, not the {}", room().name, clause().room)};
    phase_ = Phase::ending;
    stop_ = point;
    const auto floor = body.reachable().best([&](Vec2 at) { return distance(at, point) + (in_room(at) ? 0.0 : 10.0); });
    drive_.begin(body, nav::MoveTo{floor.value_or(point), {}, kTolerance, 0.2});
    return {};
  }

  std::optional<Outcome> ended(Body& body) {
    // on the way more of the floor came to be known
    if (distance(stop_, body.position()) > kTolerance && ++stops_ < kMostStops) return stop_in(body, stop_);
    if (!moved_.success) return Outcome{std::string(to_string(moved_.reason)), moved_.detail};
    answer_ = fmt::format("I am in the {}.", room().name);
    verified_ = true;
    return next();
  }

  language::Route route_;
  Nouns nouns_;
  std::vector<Place> places_;
  std::size_t next_ = 0;
  Phase phase_ = Phase::clause;
  std::optional<Walker> walker_;
  Drive drive_;
  MoveResult moved_;
  Opening chosen_;
  bool beside_ = false;
  Vec2 stop_;
  int stops_ = 0;
  int looks_ = 0;
  std::vector<Vec2> looked_at_;
  int viewpoints_ = -1;
  Candidate found_;
  std::uint64_t thing_ = 0;
  bool verified_ = false;
  std::string answer_;
};

language::Route parse(const Body& body, const Nouns& nouns, const std::string& text) {
  language::RouteNames names{.rooms = {}, .things = nouns.all()};
  for (const Place& place : body.map.places()) names.rooms.push_back(place.name);
  return language::parse_route(text, names);
}

}  // namespace

bool names_things(const Body& body, const std::string& route) {
  try {
    return std::ranges::any_of(parse(body, Nouns(body.map.labels()), route),
                               [](const Clause& clause) { return !clause.thing.noun.empty(); });
  } catch (const ConfigError&) {
    return false;
  }
}

std::unique_ptr<SkillRun> begin_route(Body& body, const std::string& text) {
  Nouns nouns(body.map.labels());
  language::Route route = parse(body, nouns, text);
  return std::make_unique<FollowRoute>(body, std::move(route), std::move(nouns));
}

}  // namespace threewe::agent
