// Search: drive to the most probable of the things that are known; look around; map what is unknown; look where the
// camera has not looked. A thing is looked at from some way off, from another side as long as that leaves it uncertain
// what it is, and gone up to once it is certain. What turns out to be something else is not tried again.
#include <numbers>

#include <fmt/format.h>

#include "agent/skills.hpp"
#include "core/exact.hpp"
#include "semantics/probable_place.hpp"

namespace threewe::agent {
namespace {

constexpr double kBesides = 0.15;       // [m] from a thing's centre at least, where the robot stands to look at it
constexpr double kLookFrom = 1.9;       // [m] from it, where a low camera sees all of tall things too
constexpr double kNear = 0.75;          // [m] from it, where a search ends
constexpr double kWorthLook = 0.3;      // probability of the kind from which a thing is looked at from near by
constexpr double kWorthAnother = 0.35;  // and from which it is looked at again, from another side
constexpr double kSure = 0.85;          // and from which it is of that kind
constexpr double kSureColor = 0.55;     // share of the color, likewise
constexpr double kOtherSide = 1.0;      // [rad] between the sides from which a thing is looked at
constexpr std::uint64_t kLooks = 2;     // pictures from there, before it is judged
constexpr int kMostSides = 3;           // from which one thing is looked at
constexpr int kMostStands = 2;          // that are tried to come near to it
constexpr double kReach = 0.9;          // [m] to what is seen of it, from where a search ends
constexpr double kFarthestStand = 2.5;  // [m] from a thing's centre
constexpr int kMostViewpoints = 60;     // of one search
constexpr double kTolerance = 0.4;      // [m] of a viewpoint
constexpr double kDetour = 4.0;         // [m] to where it most probably is, by what stands around there

// [m] on the straight way from a point to a thing, up to where the map shows it.
double gap_to(const map::OccupancyGrid& grid, Vec2 from, Vec2 thing) {
  const double length = norm(thing - from);
  const auto steps = static_cast<int>(std::ceil(length / grid.resolution));
  for (int step = 0; step < steps; ++step) {
    const double way = step * grid.resolution;
    if (grid.at(grid.cell(from + (way / length) * (thing - from))) >= map::OccupancyGrid::kOccupiedThreshold)
      return way;
  }
  return length;
}

class Search : public SkillRun {
 public:
  explicit Search(language::ThingPhrase thing) : thing_(std::move(thing)) {}

  std::optional<Outcome> update(Body& body) override {
    if (hinted_at_ != body.looks) {
      *hints_ = semantics::hints(body.map, thing_.kind);
      hinted_at_ = body.looks;
    }
    if (phase_ >= Phase::going_to_look) return attend(body);
    auto known = things_meant(body, thing_, left_, kSure);
    if (known.empty()) known = things_meant(body, thing_, tried_, kWorthLook);
    if (!known.empty()) {
      cancel();
      target_ = known.front().id;
      sides_.clear();
      stands_ = 0;
      go_to(body, known.front(), kLookFrom);
      return {};
    }
    if (to_place_) {
      if (!to_place_->update(body)) return {};
      to_place_.reset();
    }
    if (drive_.active() && !drive_.take()) return {};
    return go_on(body);
  }
  void cancel() override {
    drive_.cancel();
    if (to_place_) to_place_->cancel();
    to_place_.reset();
  }

 private:
  // In the last four, one thing is attended to: looked at from some way off, then gone up to.
  enum class Phase : std::uint8_t {
    begun,
    to_place,
    turning,
    exploring,
    viewing,
    going_to_look,
    looking,
    closing,
    near
  };

  // What comes next where nothing fit is known.
  std::optional<Outcome> go_on(Body& body) {
    if (phase_ == Phase::begun && !thing_.place.empty()) {
      phase_ = Phase::to_place;
      to_place_ = begin_skill(body, {.skill = language::Skill::move_to_place, .place = thing_.place});
    } else if (phase_ == Phase::begun || phase_ == Phase::to_place) {
      phase_ = Phase::turning;
      drive_.begin(body, nav::Rotate{2.0 * std::numbers::pi, 0.2});
    } else if (phase_ == Phase::turning && thing_.place.empty()) {
      phase_ = Phase::exploring;
      drive_.begin(body, nav::Explore{.worth = worth_of_places(), .most_worth = kDetour});
    } else {
      phase_ = Phase::viewing;
      return view_next(body);
    }
    return {};
  }

  std::optional<Outcome> view_next(Body& body) {
    std::function<bool(Vec2)> area;
    if (!thing_.place.empty()) {
      const semantics::Place place = body.map.place(thing_.place);
      area = [place](Vec2 point) { return semantics::SemanticMap::contains(place, point); };
    }
    const auto viewpoint = body.coverage.next(body.robot.map(), body.reachable(), area, worth_of_places());
    if (!viewpoint || ++viewpoints_ > kMostViewpoints) return Outcome{"not_found", not_found()};
    body.coverage.add(viewpoint->shows);  // seen from there, or hidden: not to be gone to again
    drive_.begin(body, nav::MoveTo{viewpoint->stand, viewpoint->heading, kTolerance, 0.2});
    return {};
  }

  // [m] of way that a place is worth, by what stands near it: by the newest hints, as long as a motion asks.
  std::function<double(Vec2)> worth_of_places() const {
    return [hints = hints_](Vec2 place) { return kDetour * semantics::share_at(*hints, place); };
  }

  std::string not_found() const {
    const std::string meant = in_words(thing_);
    if (best_ == 0.0) return fmt::format("there is no {} where it has looked", meant);
    return fmt::format(
        "it is certain of no {} where it has looked; most like one is the {}, with a probability of {:.2f}", meant,
        best_in_words_, best_);
  }

  // To a place to stand so far from a thing, from which it is in sight; not on a side that it was looked at from.
  void go_to(Body& body, const semantics::MappedThing& thing, double away) {
    phase_ = away == kNear ? Phase::closing : Phase::going_to_look;
    const auto stand = stand_for(body, thing, away);
    const Vec2 look = thing.position - stand.value_or(thing.position);
    if (stand && norm(look) < std::max(away, kFarthestStand)) {
      drive_.begin(body, nav::MoveTo{*stand, exact::atan2(look.y, look.x), 0.25, 0.1});
    } else {  // what lies between is not known yet: as near as it gets
      drive_.begin(body, nav::MoveTo{thing.position, {}, away, 0.1});
    }
  }

  std::optional<Vec2> stand_for(Body& body, const semantics::MappedThing& thing, double away) const {
    const auto& grid = body.robot.map();
    const Vec2 here = body.position();
    return body.reachable().best([&](Vec2 point) {
      const Vec2 off = point - thing.position;
      const double range = norm(off);
      const double seen_to = 1.0 - 0.45 / std::max(range, 0.5);
      double cost = std::fabs(range - away) + 0.02 * norm(point - here) + (range < kBesides ? 10.0 : 0.0);
      if (!in_sight(grid, point, point - seen_to * off)) cost += 1.0;
      for (const double side : sides_) {
        if (std::fabs(wrap_angle(exact::atan2(off.y, off.x) - side)) < kOtherSide) cost += 3.0;
      }
      return cost;
    });
  }

  // Goes to the thing that it attends to, looks at it, and decides what comes next.
  std::optional<Outcome> attend(Body& body) {
    const auto thing = body.map.thing(target_);
    const bool going = phase_ == Phase::going_to_look || phase_ == Phase::closing;
    if (drive_.active()) {
      if (!thing && going) {  // forgotten on the way
        drive_.cancel();
        return leave();
      }
      if (!drive_.take()) return {};
      if (going && thing) {
        const double turn = wrap_angle(body.heading_to(thing->position) - body.robot.pose().map_from_base().theta);
        drive_.begin(body, nav::Rotate{turn, 0.05});
      }
      phase_ = phase_ <= Phase::looking ? Phase::looking : Phase::near;
      judged_at_ = body.looks + kLooks;
      return {};
    }
    if (body.looks < judged_at_) return {};
    if (!thing) return leave();
    return phase_ == Phase::looking ? judge(body, *thing) : arrive(body, *thing);
  }

  std::optional<Outcome> judge(Body& body, const semantics::MappedThing& thing) {
    const double probability = probability_of(body, thing);
    const Vec2 off = body.position() - thing.position;
    sides_.push_back(exact::atan2(off.y, off.x));
    const bool colored = thing_.color.empty() || thing.colors[index_of_color()] >= kSureColor;
    if (probability >= kSure && colored) {
      sides_.clear();
      go_to(body, thing, kNear);
    } else if (probability >= kWorthAnother && sides_.size() < kMostSides) {
      go_to(body, thing, kLookFrom);
    } else {
      remember(body, thing, probability);
      return probability >= kSure ? leave() : give_up();
    }
    return {};
  }

  // It is what was meant: what counts now is that it is at hand, and in the picture.
  std::optional<Outcome> arrive(Body& body, const semantics::MappedThing& thing) {
    const bool seen = thing.last_seen == body.looked;
    const bool near = gap_to(body.robot.map(), body.position(), thing.position) <= kReach;
    const double probability = probability_of(body, thing);
    if (probability < kSure) {
      remember(body, thing, probability);
      return leave();
    }
    if ((!seen || !near) && ++stands_ < kMostStands) {
      const Vec2 off = body.position() - thing.position;
      sides_.assign({exact::atan2(off.y, off.x)});
      go_to(body, thing, kNear);
      return {};
    }
    return Outcome{"done", {}, fmt::format("There is a {}.", in_words(body, thing)), thing.id, seen && near};
  }

  void remember(const Body& body, const semantics::MappedThing& thing, double probability) {
    if (probability <= best_) return;
    best_ = probability;
    best_in_words_ = in_words(body, thing);
  }

  std::optional<Outcome> give_up() {
    tried_.push_back(target_);
    phase_ = Phase::to_place;  // looks around here, then goes on
    if (thing_.place.empty() && viewpoints_ > 0) phase_ = Phase::viewing;
    return {};
  }

  std::optional<Outcome> leave() {
    left_.push_back(target_);
    return give_up();
  }

  // That a thing is of the kind that is meant.
  double probability_of(const Body& body, const semantics::MappedThing& thing) const {
    return thing_.kind.empty() ? 1.0 : thing.kinds[index_of_kind(body)];
  }

  std::size_t index_of_kind(const Body& body) const {
    const auto& labels = body.map.labels();
    return static_cast<std::size_t>(std::ranges::find(labels, thing_.kind) - labels.begin());
  }

  std::size_t index_of_color() const {
    const auto names = vision::color_names();
    return static_cast<std::size_t>(std::ranges::find(names, thing_.color) - names.begin());
  }

  language::ThingPhrase thing_;
  std::shared_ptr<std::vector<semantics::Hint>> hints_ = std::make_shared<std::vector<semantics::Hint>>();
  std::uint64_t hinted_at_ = 0;
  Phase phase_ = Phase::begun;
  std::unique_ptr<SkillRun> to_place_;
  Drive drive_;
  std::uint64_t target_ = 0;
  std::uint64_t judged_at_ = 0;
  std::vector<double> sides_;  // [rad] of a thing, from which it was looked at
  int stands_ = 0;
  std::vector<std::uint64_t> tried_;  // that were looked at, and are gone to once they are certain
  std::vector<std::uint64_t> left_;   // that are not, by their color or by what was seen on arrival
  double best_ = 0.0;                 // probability of the most probable thing that was given up
  std::string best_in_words_;
  int viewpoints_ = 0;
};

}  // namespace

std::unique_ptr<SkillRun> begin_search(const language::ThingPhrase& thing) { return std::make_unique<Search>(thing); }

}  // namespace threewe::agent
