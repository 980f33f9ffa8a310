#include "task/interpreter.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "threewe/core/errors.hpp"

namespace threewe::task {
namespace {

constexpr double kPassedWithin = 2.0;       // [m]
constexpr double kCloseCall = 0.4;          // [m] between "nearest" things that differ too little to be distinguished
constexpr std::size_t kMostReadings = 256;  // at a time

// A walker together with what was said and is not yet done.
struct State {
  Walker walker;
  std::vector<const Clause*> passing;  // what must be passed on the way to what comes next
  std::vector<Vec2> way;
};

bool is_near(Vec2 a, Vec2 b) { return distance(a, b) < kAside; }

// Whether the straight way to a point agrees with what was said about it.
bool agrees(const SemanticMap& map, const State& state, Vec2 to) {
  const Walker& w = state.walker;
  if (w.turned && !is_near(w.at, to) && !lies_ahead(w.heading, to - w.at)) return false;
  return std::ranges::all_of(state.passing, [&](const Clause* pass) {
    return std::ranges::any_of(candidates(map, w, pass->thing), [&](std::size_t i) {
      return is_passed(w.at, to, map.landmarks()[i].center, pass->side);
    });
  });
}

// A walker who has done all that was said, and is now elsewhere.
State after(State state, const Walker& walker) {
  state.walker = walker;
  state.passing.clear();
  state.way.push_back(walker.at);
  return state;
}

void stop(const SemanticMap& map, const State& state, const Clause& clause, std::vector<Reading>& found) {
  const Walker& w = state.walker;
  const auto add = [&](std::optional<Vec2> end, Vec2 towards) {
    if (!end || !agrees(map, state, towards)) return;
    found.push_back({state.way, *end});
    found.back().way.push_back(*end);
  };
  const bool here = clause.room.empty() || clause.room == map.rooms()[w.room];
  if (clause.kind == Clause::Kind::stop_at) {
    for (const std::size_t i : candidates(map, w, clause.thing)) {
      add(map.place_at(i, w.since), map.landmarks()[i].center);
    }
  } else if (clause.kind == Clause::Kind::stop_in_middle && here) {
    const auto end = map.middle_of(w.room);
    if (end) add(end, *end);
  } else if (clause.kind == Clause::Kind::stop_here) {
    add(w.at, w.at);
  } else if (clause.kind == Clause::Kind::stop_inside && here && w.opening) {
    const auto end = map.just_inside(w.room, *w.opening);
    if (end) add(end, *end);
  }
}

// What becomes of a state by one clause.
void advance(const SemanticMap& map, State state, const Clause& clause, std::vector<State>& next) {
  switch (clause.kind) {
    case Clause::Kind::turn:
      state.walker.heading = turned(state.walker.heading, clause.side);
      state.walker.turned = true;
      next.push_back(std::move(state));
      break;
    case Clause::Kind::pass:
      state.passing.push_back(&clause);
      next.push_back(std::move(state));
      break;
    case Clause::Kind::approach:
      for (const std::size_t i : candidates(map, state.walker, clause.thing)) {
        if (!agrees(map, state, map.landmarks()[i].center)) continue;
        next.push_back(after(state, up_to(map, state.walker, i)));
      }
      break;
    case Clause::Kind::cross:
      for (const std::size_t i : candidates(map, state.walker, clause)) {
        if (!agrees(map, state, map.openings()[i].crossing(state.walker.at))) continue;
        next.push_back(after(state, through(map, state.walker, i)));
      }
      break;
    case Clause::Kind::stop_at:
    case Clause::Kind::stop_in_middle:
    case Clause::Kind::stop_inside:
    case Clause::Kind::stop_here: break;
  }
}

bool is_stop(const Clause& clause) { return clause.kind >= Clause::Kind::stop_at; }

}  // namespace

Instruction parse(std::string_view text, const SemanticMap& map) {
  language::RouteNames names{.rooms = map.rooms(), .things = {}};
  for (const Landmark& landmark : map.landmarks()) {
    for (const std::string& name : {landmark.noun, landmark.general}) names.things.push_back(name);
  }
  std::ranges::sort(names.things);
  names.things.erase(std::unique(names.things.begin(), names.things.end()), names.things.end());
  return language::parse_route(text, names);
}

std::optional<Walker> walker_at(const SemanticMap& map, const Pose2D& start) {
  const auto room = map.room_at(start.position());
  if (!room) return std::nullopt;
  return Walker{.at = start.position(),
                .heading = rotate({1.0, 0.0}, start.theta),
                .room = *room,
                .opening = std::nullopt,
                .since = start.position(),
                .turned = false};
}

Vec2 along_axis(Vec2 heading) {
  if (std::fabs(heading.x) >= std::fabs(heading.y)) return {heading.x >= 0.0 ? 1.0 : -1.0, 0.0};
  return {0.0, heading.y >= 0.0 ? 1.0 : -1.0};
}

Side side_of(Vec2 axis, Vec2 out) {
  if (dot(axis, out) > 0.5) return Side::ahead;
  if (dot(axis, out) < -0.5) return Side::behind;
  return cross(axis, out) > 0.0 ? Side::left : Side::right;
}

Vec2 turned(Vec2 heading, Side side) {
  switch (side) {
    case Side::left: return {-heading.y, heading.x};
    case Side::right: return {heading.y, -heading.x};
    case Side::behind: return {-heading.x, -heading.y};
    case Side::ahead: break;
  }
  return heading;
}

bool lies_ahead(Vec2 heading, Vec2 to) { return dot(heading, to) >= 0.5 * norm(to); }

bool is_passed(Vec2 a, Vec2 b, Vec2 thing, Side side) {
  const double length = distance(a, b);
  if (length < kAside) return false;
  const Vec2 along = (1.0 / length) * (b - a);
  const double ahead = dot(thing - a, along);
  const double left = cross(along, thing - a);
  return ahead > 0.0 && ahead < length && std::fabs(left) > kAside && std::fabs(left) <= kPassedWithin &&
         (side == Side::ahead || (left > 0.0) == (side == Side::left));
}

std::vector<std::size_t> candidates(const SemanticMap& map, const Walker& walker, const Thing& thing) {
  const auto& landmarks = map.landmarks();
  const Vec2 axis = along_axis(walker.heading);
  const auto ahead = [&](std::size_t i) { return dot(axis, landmarks[i].center - walker.at); };
  const auto left = [&](std::size_t i) { return cross(axis, landmarks[i].center - walker.at); };
  const auto far = [&](std::size_t i) { return distance(landmarks[i].center, walker.at); };

  // all that are called so, on that side, beside such a thing
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    if (landmarks[i].room != walker.room || !landmarks[i].is_called(thing.noun)) continue;
    if (thing.side && (*thing.side == Side::left ? left(i) : -left(i)) < -kAside) continue;
    const auto& others = map.beside(i);
    const auto is_meant = [&](std::size_t j) { return landmarks[j].is_called(thing.next_to); };
    if (!thing.next_to.empty() && std::ranges::none_of(others, is_meant)) continue;
    found.push_back(i);
  }

  // of those, the one that stands out
  if (thing.which == Thing::Which::nth) {
    std::erase_if(found, [&](std::size_t i) { return ahead(i) < 0.0; });
    std::ranges::stable_sort(found, {}, ahead);
    const auto n = static_cast<std::size_t>(thing.ordinal);
    if (found.size() < n) return {};
    // those that come almost at once may be counted the one way or the other
    const double here = ahead(found[n - 1]);
    std::erase_if(found, [&](std::size_t i) { return std::fabs(ahead(i) - here) > kCloseCall; });
  }
  if (thing.which == Thing::Which::nearest || thing.which == Thing::Which::farthest) {
    const double sign = thing.which == Thing::Which::nearest ? 1.0 : -1.0;
    double best = std::numeric_limits<double>::infinity();
    for (const std::size_t i : found) best = std::min(best, sign * far(i));
    std::erase_if(found, [&](std::size_t i) { return sign * far(i) > best + kCloseCall; });
  }
  return found;
}

std::vector<std::size_t> candidates(const SemanticMap& map, const Walker& walker, const Clause& cross) {
  if (!cross.from.empty() && cross.from != map.rooms()[walker.room]) return {};
  const auto& openings = map.openings();
  const Vec2 axis = along_axis(walker.heading);
  const auto ahead = [&](std::size_t i) { return dot(axis, openings[i].middle() - walker.at); };

  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < openings.size(); ++i) {
    const Opening& o = openings[i];
    if (!o.joins(walker.room) || walker.opening == i || (cross.door && !o.is_door)) continue;
    if (cross.door && cross.door->side && side_of(axis, o.out_of(walker.room)) != *cross.door->side) continue;
    found.push_back(i);
  }
  if (cross.door && cross.door->ordinal > 0) {
    std::erase_if(found, [&](std::size_t i) { return ahead(i) < 0.0; });
    std::ranges::stable_sort(found, {}, ahead);
    const auto n = static_cast<std::size_t>(cross.door->ordinal);
    found = found.size() < n ? std::vector<std::size_t>{} : std::vector<std::size_t>{found[n - 1]};
  }
  if (!cross.room.empty()) {
    std::erase_if(found, [&](std::size_t i) { return map.rooms()[openings[i].beyond(walker.room)] != cross.room; });
  }
  return found;
}

Walker through(const SemanticMap& map, Walker walker, std::size_t opening) {
  const Opening& o = map.openings()[opening];
  walker.at = o.crossing(walker.at);
  walker.heading = o.out_of(walker.room);
  walker.room = o.beyond(walker.room);
  walker.opening = opening;
  walker.since = o.middle();
  walker.turned = false;
  return walker;
}

Walker up_to(const SemanticMap& map, Walker walker, std::size_t landmark) {
  const Vec2 to = map.landmarks()[landmark].center;
  const double length = distance(walker.at, to);
  if (length > 0.0) walker.heading = (1.0 / length) * (to - walker.at);
  walker.at = to;
  walker.turned = false;
  return walker;
}

std::vector<Reading> readings(const Instruction& instruction, const SemanticMap& map, const Pose2D& start) {
  const auto walker = walker_at(map, start);
  if (!walker) return {};
  std::vector<State> states = {{.walker = *walker, .passing = {}, .way = {walker->at}}};
  for (const Clause& clause : instruction) {
    if (is_stop(clause)) {
      std::vector<Reading> found;
      for (const State& state : states) stop(map, state, clause, found);
      return found;
    }
    std::vector<State> next;
    for (State& state : states) advance(map, std::move(state), clause, next);
    if (next.size() > kMostReadings) next.resize(kMostReadings);
    states = std::move(next);
  }
  return {};
}

std::optional<Reading> follow(std::string_view text, const SemanticMap& map, const Pose2D& start) {
  try {
    std::vector<Reading> found = readings(parse(text, map), map, start);
    if (found.empty()) return std::nullopt;
    return std::move(found.front());
  } catch (const ConfigError&) {
    return std::nullopt;  // not understood
  }
}

}  // namespace threewe::task
