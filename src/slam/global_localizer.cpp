#include "slam/global_localizer.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace threewe::slam {
namespace {

constexpr std::size_t kMostGlimpses = 12;
constexpr std::size_t kMostHits = 800;  // that one search looks for

}  // namespace

// What is seen now and was seen before is looked for together; what is found must fit the scans to come.
std::optional<Pose2D> GlobalLocalizer::look(Time stamp, const Pose2D& odom_from_base,
                                            std::span<const map::Beam> beams) {
  stamp_ = stamp;
  if (remember(odom_from_base, beams))
    due_ = std::min(due_, stamp + params_->global_search.period), pause_ = params_->global_search.period;
  if (confirmed_ > 0) {
    const std::optional<Pose2D> place = search_near(map_from_odom_ * odom_from_base, beams);
    if (!place) {
      glimpses_.clear();  // what was seen before may be from where the robot no longer is
      give_up();
    } else {
      map_from_odom_ = *place * inverse(odom_from_base);
      if (++confirmed_ >= params_->global_search.confirmations) return place;
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
    if (!found && hunt_->least == params_->global_search.good_score) {
      hunt_again(params_->global_search.least_score);
    } else if (found && found->elsewhere == 0.0 && hunt_->least > found->score - params_->global_search.lead) {
      hunt_again(found->score - params_->global_search.lead);
    } else {
      end_hunt(found);
    }
  }
}

void GlobalLocalizer::begin_hunt(const Pose2D& odom_from_base, std::span<const map::Beam> beams) {
  const BranchAndBoundMatcher& map = map_->search();
  std::vector<map::Beam> seen = all_seen(odom_from_base, beams);
  BranchAndBoundMatcher::Search search(map, seen, map.everywhere(), params_->global_search.good_score);
  hunt_ = {odom_from_base,
           {beams.begin(), beams.end()},
           std::move(seen),
           params_->global_search.good_score,
           std::move(search)};
}

void GlobalLocalizer::hunt_again(double least) {
  hunt_->least = least;
  hunt_->search = BranchAndBoundMatcher::Search(map_->search(), hunt_->seen, map_->search().everywhere(), least);
}

bool GlobalLocalizer::found_best(const Pose2D& map_from_base, const Pose2D& odom_from_base) const {
  if (!best_) return false;
  const Pose2D off = inverse(*best_ * odom_from_base) * map_from_base;
  return norm(off.position()) < params_->global_search.elsewhere_position &&
         std::fabs(off.theta) < params_->global_search.elsewhere_heading;
}

void GlobalLocalizer::end_hunt(const std::optional<BranchAndBoundMatcher::Found>& found) {
  best_.reset();
  if (found) best_ = found->pose * inverse(hunt_->odom_from_base);
  // a wrong place may fit well too, but then others fit as well: of 168 scans, of each of seven scenes in the maps of
  // the six others, 17 scored 0.6 and more, all but a few of them at most 0.06 more than elsewhere in the same map; of
  // 48 scans in their own scenes' maps the right place came first each time, by 0.13 to 0.54
  const bool alone = found && found->elsewhere < found->score - params_->global_search.lead;
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
  pause_ = std::min(2 * pause_, params_->global_search.longest_pause);
}

bool GlobalLocalizer::is_same_view(const Pose2D& a_from_b) const {
  const Params::GlobalSearch& p = params_->global_search;
  return norm(a_from_b.position()) < p.view_distance && std::fabs(a_from_b.theta) < p.view_turn;
}

// Whether it was something new.
bool GlobalLocalizer::remember(const Pose2D& odom_from_base, std::span<const map::Beam> beams) {
  if (!glimpses_.empty()) driven_ += distance(odom_from_base.position(), last_.position());
  last_ = odom_from_base;
  std::erase_if(glimpses_, [this](const Glimpse& g) { return driven_ - g.driven > params_->loops.view_length; });
  if (!glimpses_.empty() && is_same_view(inverse(glimpses_.back().odom_from_base) * odom_from_base)) return false;
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
  for (const Glimpse& glimpse : glimpses_) {
    const Pose2D now_from_then = inverse(odom_from_base) * glimpse.odom_from_base;
    if (!is_same_view(now_from_then)) add(now_from_then, glimpse.beams);  // else the newest shows how it is there
  }

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
  const Params::GlobalSearch& p = params_->global_search;
  const auto found = map_->search().find(beams, {place, {p.confirm_position, p.confirm_position}, p.confirm_heading},
                                         params_->global_search.least_score);
  return found && fits(found->pose, beams) ? std::optional(found->pose) : std::nullopt;
}

bool GlobalLocalizer::fits(const Pose2D& place, std::span<const map::Beam> beams) const {
  const Resemblance seen = map_->compare(place, beams);
  // in their own maps scans agree by 0.92 and more, and 0.02 to 0.22 of their beams graze what they pass
  return seen.agreement() >= params_->registration.poor_agreement &&
         seen.contradiction() <= params_->registration.through_walls;
}

}  // namespace threewe::slam
