// Numbers, lengths, angles, durations and points in sentences.
#include <array>
#include <cmath>
#include <utility>

#include "language/chart.hpp"

namespace threewe::language {
namespace {

constexpr double kLargest = 1e6;  // [m, s, turns] nothing that is said of a robot is larger
constexpr double kDegree = 0.017453292519943295;

}  // namespace

std::optional<Quantity> Chart::number(std::size_t at) const {
  const bool minus = sentence_.is_mark(at, "-") || longest(at, groups_.minus) > at;
  std::optional<Quantity> found = unsigned_number(minus ? at + 1 : at);
  if (found && minus) found->value = -found->value;
  return found;
}

std::optional<Quantity> Chart::unsigned_number(std::size_t at) const {
  if (!sentence_.is_number(at)) return spelled_number(at);
  Quantity found{at + 1, sentence_[at].token.value};
  if (sentence_.is_mark(at + 1, "/") && sentence_.is_number(at + 2) && sentence_[at + 2].token.value > 0.0) {
    found = {at + 3, found.value / sentence_[at + 2].token.value};
  }
  if (!(found.value <= kLargest)) return std::nullopt;
  return found;
}

// "seventy-five", "a hundred and eighty", "zero point five"
std::optional<Quantity> Chart::spelled_number(std::size_t at) const {
  const auto word_at = [this](std::size_t from) -> std::optional<Quantity> {
    if (from >= sentence_.size()) return std::nullopt;
    std::optional<Quantity> best;
    for (const Edge& edge : sentence_.edges(from)) {
      if (edge.phrase->group == index_of(Group::number) && (!best || edge.end > best->end)) {
        best = Quantity{edge.end, edge.phrase->number};
      }
    }
    return best;
  };
  const auto below_hundred = [&](std::size_t from) {
    std::optional<Quantity> tens = word_at(from);
    const std::optional<Quantity> ones = tens && tens->value >= 20.0 ? word_at(tens->end) : std::nullopt;
    if (ones && ones->value >= 1.0 && ones->value <= 9.0) tens = Quantity{ones->end, tens->value + ones->value};
    return tens;
  };
  std::optional<Quantity> whole = below_hundred(at);
  const std::size_t hundred_at = whole ? whole->end : sentence_.is_word(at, "a") ? at + 1 : at;
  if (const std::size_t end = sentence_.longest(hundred_at, Group::hundred); end > hundred_at) {
    whole = Quantity{end, 100.0 * (whole ? whole->value : 1.0)};
    const std::optional<Quantity> rest = below_hundred(sentence_.is_word(end, "and") ? end + 1 : end);
    if (rest) whole = Quantity{rest->end, whole->value + rest->value};
  }
  const std::size_t point = whole ? whole->end : at;
  if (!sentence_.is_word(point, "point")) return whole;
  double scale = 0.1;
  Quantity found{point + 1, whole ? whole->value : 0.0};
  for (auto digit = word_at(found.end); digit && digit->value <= 9.0; digit = word_at(found.end)) {
    found = {digit->end, found.value + scale * digit->value};
    scale *= 0.1;
  }
  return found.end > point + 1 ? std::optional(found) : whole;
}

// The longest unit that stands here; its value is what one of it is in SI units.
std::optional<Quantity> Chart::unit(std::size_t at, Group unit) const {
  std::optional<Quantity> best;
  if (at >= sentence_.size()) return best;
  for (const Edge& edge : sentence_.edges(at)) {
    if (edge.phrase->group == index_of(unit) && (!best || edge.end > best->end)) {
      best = Quantity{edge.end, edge.phrase->number};
    }
  }
  return best;
}

// "2 m", "a meter", "half a meter", "two and a half meters", "a meter and a half"
std::optional<Quantity> Chart::simple_quantity(std::size_t at, Group wanted) const {
  const auto article = [this](std::size_t from) {
    return sentence_.is_word(from, "a") || sentence_.is_word(from, "an") || sentence_.is_word(from, "the");
  };
  const auto fraction = [this](std::size_t from) { return unit(from, Group::fraction); };
  std::optional<Quantity> best;
  const auto offer = [&](double count, const std::optional<Quantity>& of) {
    if (!of || (best && best->end >= of->end)) return;
    best = Quantity{of->end, count * of->value};
    if (!sentence_.is_word(of->end, "and")) return;
    const std::optional<Quantity> more = fraction(of->end + 1);
    if (more) best = Quantity{more->end, (count + more->value) * of->value};
  };
  if (const auto count = number(at)) {
    offer(count->value, unit(count->end, wanted));
    const auto part = sentence_.is_word(count->end, "and") ? fraction(count->end + 1) : std::nullopt;
    if (part) offer(count->value + part->value, unit(part->end, wanted));
    const bool glued = sentence_.is_number(count->end) && sentence_[count->end].token.value < 1.0;  // "1½"
    if (glued) offer(count->value + sentence_[count->end].token.value, unit(count->end + 1, wanted));
  }
  if (article(at)) offer(1.0, unit(at + 1, wanted));
  if (const auto part = fraction(at)) {
    std::size_t next = sentence_.is_word(part->end, "of") ? part->end + 1 : part->end;
    if (article(next)) ++next;
    offer(part->value, unit(next, wanted));
  }
  return best;
}

// "1 meter 50 centimeters", "a minute and 30 seconds": the smaller unit follows.
std::optional<Quantity> Chart::quantity(std::size_t at, Group wanted) const {
  std::optional<Quantity> found = simple_quantity(at, wanted);
  if (!found) return found;
  const std::size_t next = sentence_.is_word(found->end, "and") ? found->end + 1 : found->end;
  const std::optional<Quantity> more = simple_quantity(next, wanted);
  if (!more || !(more->value < std::abs(found->value)) || more->value < 0.0) return found;
  const std::optional<Quantity> first = unit(found->end - 1, wanted);
  const std::optional<Quantity> second = unit(more->end - 1, wanted);
  if (!first || !second || !(second->value < first->value)) return found;
  return Quantity{more->end, found->value + more->value};
}

Matches Chart::quantities(Slot slot, std::size_t at) {
  if (slot == Slot::speed) {
    const std::optional<Quantity> speed = quantity(at, Group::speed);
    return speed && std::abs(speed->value) > sentence_.lexicon().fastest ? Matches{{speed->end, {}}} : Matches{};
  }
  const Group wanted = slot == Slot::length ? Group::length : slot == Slot::angle ? Group::angle : Group::duration;
  std::optional<Quantity> found = quantity(at, wanted);
  if (!found && slot == Slot::angle) {  // a bare number is never meant as radians
    found = number(at);
    if (found) found->value *= kDegree;
  }
  if (!found) {
    if (const auto count = number(at)) fail(count->end);
    return {};
  }
  Match match{found->end, {}};
  (slot == Slot::length  ? match.slots.length
   : slot == Slot::angle ? match.slots.angle
                         : match.slots.duration) = found->value;
  return {match};
}

Matches Chart::points(std::size_t at) {
  Matches all;
  for (const std::size_t named : behind_determiners(at)) {
    const std::size_t begin = longest(named, groups_.point);
    if (named > at && begin == named) continue;
    if (const std::optional<Match> point = coordinates(begin)) add_heading(*point, all);
  }
  return all;
}

// "(2, 1)", "2, 1", "x 2 y -1.5", "x = 2 m and y = 1 m"
std::optional<Match> Chart::coordinates(std::size_t at) const {
  const bool open = sentence_.is_mark(at, "(");
  const std::optional<Quantity> x = coordinate(open ? at + 1 : at, groups_.x);
  if (!x) return std::nullopt;
  const bool comma = sentence_.is_mark(x->end, ",;");
  const std::size_t behind = comma ? x->end + 1 : x->end;
  const std::size_t next = sentence_.is_word(behind, "and") ? behind + 1 : behind;
  const bool bare = next == x->end && longest(next, groups_.y) == next;
  if (bare && sentence_.is_mark(next, "-") && !open) return std::nullopt;  // "2-1" is no point
  const std::optional<Quantity> y = coordinate(next, groups_.y);
  if (!y) return std::nullopt;
  Match match{y->end, {.point = Vec2{x->value, y->value}}};
  if (!open) return match;
  if (sentence_.is_mark(match.end, ",")) {
    const std::optional<Quantity> theta = number(match.end + 1);
    if (!theta) return std::nullopt;
    match.end = theta->end;
    match.slots.theta = theta->value;
  }
  if (!sentence_.is_mark(match.end, ")")) return std::nullopt;
  ++match.end;
  return match;
}

// [m], with the name of its axis or without
std::optional<Quantity> Chart::coordinate(std::size_t at, std::size_t axis) const {
  std::size_t begin = longest(at, axis);
  if (begin > at) begin = sentence_.is_mark(begin, "=:") ? begin + 1 : longest(begin, groups_.is);
  std::optional<Quantity> found = simple_quantity(begin, Group::length);
  return found ? found : number(begin);
}

void Chart::add_heading(const Match& point, Matches& to) const {
  to.push_back(point);
  if (point.slots.theta) return;
  const std::size_t begin = sentence_.is_mark(point.end, ",") ? point.end + 1 : point.end;
  for (const bool radians : {false, true}) {
    std::size_t next = longest(begin, radians ? groups_.theta : groups_.facing);
    if (next == begin) continue;
    if (sentence_.is_mark(next, "=:")) ++next;
    const std::optional<Quantity> angle = quantity(next, Group::angle);
    const std::optional<Quantity> bare = number(next);
    Match match = point;
    if (angle) {
      match.end = angle->end;
      match.slots.theta = angle->value;
    } else if (bare) {
      match.end = bare->end;
      match.slots.theta = radians ? bare->value : bare->value * kDegree;
    } else {
      continue;
    }
    to.push_back(match);
  }
}

}  // namespace threewe::language
