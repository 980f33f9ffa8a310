#include "slam/global_localizer.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace threewe::slam {
namespace {

constexpr double kGlimpseDistance = 0.3;  // [m] what is seen is remembered after so much motion ...
constexpr double kGlimpseTurn = 0.5;      // [rad] ... or turning ...
constexpr double kGlimpseAge = 4.0;       // [m] ... until the robot has driven on so far
constexpr std::size_t kMostGlimpses = 12;
constexpr std::size_t kMostHits = 800;  // that one search looks for
constexpr double kGoodScore = 0.65;     // most places score so much: searching for that is quick
constexpr double kLeastScore = 0.50;    // in a place that has changed
constexpr Duration kPeriod = 200ms;     // between searches ...
constexpr Duration kLongestPause = 4s;  // ... and where nothing new is to be seen
constexpr int kConfirmations = 3;       // scans in a row that fit

// A wrong place may fit well too, but then others fit as well. Of 168 scans, of each of seven scenes in the maps of the
// six others, 17 scored 0.6 and more, all but a few of them at most 0.06 more than elsewhere in the same map. Of 48
// scans in their own scenes' maps the right place came first each time, by 0.13 to 0.54.
constexpr double kLead = 0.10;
constexpr double kLeastAgreement = 0.60;     // of hits: in their own maps 0.92 and more
constexpr double kMostContradiction = 0.35;  // of beams: in their own maps 0.02 to 0.22, that graze what they pass

}  // namespace

// What is seen now and was seen before is looked for together; what is found must fit the scans to come.
std::optional<Pose2D> GlobalLocalizer::look(Time stamp, const Pose2D& odom_from_base,
                                            std::span<const map::Beam> beams) {
  stamp_ = stamp;
  if (remember(odom_from_base, beams)) due_ = std::min(due_, stamp + kPeriod), pause_ = kPeriod;
  if (confirmed_ > 0) {
    const std::optional<Pose2D> place = search_near(map_from_odom_ * odom_from_base, beams);
    if (!place) {
      give_up();
    } else {
      map_from_odom_ = *place * inverse(odom_from_base);
      if (++confirmed_ >= kConfirmations) return place;
    }
  } else if (!hunt_ && stamp >= due_) {
    begin_hunt(odom_from_base, beams);
  }
  return {};
}

// Searches that expect much are quick. Nothing elsewhere may only mean that nothing scores the least that was asked
// for.
void GlobalLocalizer::go_on(std::int64_t work) {
  while (hunt_ && work > 0) {
    if (!hunt_->search.go_on(work)) return;
    const std::optional<BranchAndBoundMatcher::Found> found = hunt_->search.found();
    if (!found && hunt_->least == kGoodScore) {
      hunt_again(kLeastScore);
    } else if (found && found->elsewhere == 0.0 && hunt_->least > found->score - kLead) {
      hunt_again(found->score - kLead);
    } else {
      end_hunt(found);
    }
  }
}

void GlobalLocalizer::begin_hunt(const Pose2D& odom_from_base, std::span<const map::Beam> beams) {
  const BranchAndBoundMatcher& map = map_->search();
  std::vector<map::Beam> seen = all_seen(odom_from_base, beams);
  BranchAndBoundMatcher::Search search(map, seen, map.everywhere(), kGoodScore);
  hunt_ = {odom_from_base, {beams.begin(), beams.end()}, std::move(seen), kGoodScore, std::move(search)};
}

void GlobalLocalizer::hunt_again(double least) {
  hunt_->least = least;
  hunt_->search = BranchAndBoundMatcher::Search(map_->search(), hunt_->seen, map_->search().everywhere(), least);
}

void GlobalLocalizer::end_hunt(const std::optional<BranchAndBoundMatcher::Found>& found) {
  const bool alone = found && found->elsewhere < found->score - kLead;
  if (alone && fits(found->pose, hunt_->beams)) {
    map_from_odom_ = found->pose * inverse(hunt_->odom_from_base);
    confirmed_ = 1;
  } else {
    give_up();
  }
  hunt_.reset();
}

void GlobalLocalizer::give_up() {
  confirmed_ = 0;
  due_ = stamp_ + pause_;
  pause_ = std::min(2 * pause_, kLongestPause);
}

// Whether it was something new.
bool GlobalLocalizer::remember(const Pose2D& odom_from_base, std::span<const map::Beam> beams) {
  if (!glimpses_.empty()) driven_ += distance(odom_from_base.position(), last_.position());
  last_ = odom_from_base;
  std::erase_if(glimpses_, [this](const Glimpse& g) { return driven_ - g.driven > kGlimpseAge; });
  if (!glimpses_.empty()) {
    const Pose2D since = inverse(glimpses_.back().odom_from_base) * odom_from_base;
    if (norm(since.position()) < kGlimpseDistance && std::fabs(since.theta) < kGlimpseTurn) return false;
  }
  glimpses_.push_back({odom_from_base, {beams.begin(), beams.end()}, driven_});
  if (glimpses_.size() > kMostGlimpses) glimpses_.erase(glimpses_.begin());
  return true;
}

// In the frame of the base as it is now: each cell that was hit, once, as a beam from the base. The newest first.
std::vector<map::Beam> GlobalLocalizer::all_seen(const Pose2D& odom_from_base, std::span<const map::Beam> beams) const {
  std::vector<map::Beam> hits;
  const auto add = [&](const Pose2D& now_from_then, std::span<const map::Beam> scan) {
    for (map::Beam beam : scan) {
      if (!beam.hit) continue;
      beam.origin = now_from_then * beam.origin;
      beam.direction = rotate(beam.direction, now_from_then.theta);
      hits.push_back(beam);
    }
  };
  add({}, beams);
  for (const Glimpse& glimpse : glimpses_) add(inverse(odom_from_base) * glimpse.odom_from_base, glimpse.beams);

  // one hit a cell, in order of cells
  const double resolution = map_->surfaces().grid().resolution;
  struct Placed {
    map::Cell cell;
    std::size_t index;
  };
  std::vector<Placed> placed;
  for (std::size_t i = 0; i < hits.size(); ++i) {
    const Vec2 p = hits[i].origin + hits[i].range * hits[i].direction;
    placed.push_back({{map::to_cell(p.x / resolution), map::to_cell(p.y / resolution)}, i});
  }
  std::ranges::sort(placed, [](const Placed& a, const Placed& b) {
    return std::tuple(a.cell.y, a.cell.x, a.index) < std::tuple(b.cell.y, b.cell.x, b.index);
  });
  const auto same = [](const Placed& a, const Placed& b) { return a.cell == b.cell; };
  placed.erase(std::unique(placed.begin(), placed.end(), same), placed.end());

  const std::size_t every = (placed.size() + kMostHits - 1) / kMostHits;
  std::vector<map::Beam> seen;
  for (std::size_t i = 0; i < placed.size(); i += every) seen.push_back(hits[placed[i].index]);
  return seen;
}

std::optional<Pose2D> GlobalLocalizer::search_near(const Pose2D& place, std::span<const map::Beam> beams) const {
  const auto found = map_->search().find(beams, {place, {0.2, 0.2}, 0.1}, kLeastScore);
  return found && fits(found->pose, beams) ? std::optional(found->pose) : std::nullopt;
}

bool GlobalLocalizer::fits(const Pose2D& place, std::span<const map::Beam> beams) const {
  const Resemblance seen = map_->compare(place, beams);
  return seen.agreement() >= kLeastAgreement && seen.contradiction() <= kMostContradiction;
}

}  // namespace threewe::slam
