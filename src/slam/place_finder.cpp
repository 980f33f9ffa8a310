#include "slam/place_finder.hpp"

#include <algorithm>
#include <cmath>

namespace threewe::slam {
namespace {

constexpr double kGlimpseDistance = 0.3;  // [m] what is seen is remembered after so much motion ...
constexpr double kGlimpseTurn = 0.5;      // [rad] ... or turning ...
constexpr double kGlimpseAge = 4.0;       // [m] ... until the robot has driven on so far
constexpr std::size_t kMostGlimpses = 12;
constexpr std::size_t kMostHits = 800;         // that one search looks for
constexpr double kLeastScore = 0.50;           // of a place
constexpr double kLead = 0.12;                 // that it must have over every other place
constexpr double kLeastAgreement = 0.60;       // of the newest scan's hits
constexpr double kMostContradiction = 0.15;    // of its beams
constexpr double kSamePosition = 0.2;          // [m] searches led to the same place ...
constexpr double kSameHeading = 0.1;           // [rad]
constexpr int kConfirmations = 3;              // ... so often
constexpr Duration kPeriod = 180ms;            // between searches ...
constexpr Duration kLongestPause = 2s;         // ... and where nothing new is to be seen

}  // namespace

// What is seen now and was seen before is looked for together; a place must be found again and again.
std::optional<Pose2D> PlaceFinder::look(Time stamp, const Pose2D& odom_from_base, std::span<const map::Beam> beams) {
  const std::size_t known = glimpses_.size();
  remember(odom_from_base, beams);
  if (known != glimpses_.size()) due_ = std::min(due_, stamp), pause_ = kPeriod;
  if (stamp < due_) return {};

  confirm(search(odom_from_base, beams), odom_from_base);
  pause_ = confirmed_ > 0 ? kPeriod : std::min(2 * pause_, kLongestPause);
  due_ = stamp + pause_;
  if (confirmed_ < kConfirmations) return {};
  return map_from_odom_ * odom_from_base;
}

void PlaceFinder::remember(const Pose2D& odom_from_base, std::span<const map::Beam> beams) {
  if (!glimpses_.empty()) driven_ += distance(odom_from_base.position(), last_.position());
  last_ = odom_from_base;
  std::erase_if(glimpses_, [this](const Glimpse& g) { return driven_ - g.driven > kGlimpseAge; });
  if (!glimpses_.empty()) {
    const Pose2D since = inverse(glimpses_.back().odom_from_base) * odom_from_base;
    if (norm(since.position()) < kGlimpseDistance && std::fabs(since.theta) < kGlimpseTurn) return;
  }
  Glimpse glimpse{odom_from_base, {}, driven_};
  for (const map::Beam& beam : beams) {
    if (beam.hit) glimpse.hits.push_back(beam);
  }
  glimpses_.push_back(std::move(glimpse));
  if (glimpses_.size() > kMostGlimpses) glimpses_.erase(glimpses_.begin());
}

// In the frame of the base as it is now: each cell that was hit, once, as a beam from the base.
std::vector<map::Beam> PlaceFinder::all_seen(const Pose2D& odom_from_base, std::span<const map::Beam> beams) const {
  std::vector<map::Beam> hits;
  for (const map::Beam& beam : beams) {
    if (beam.hit) hits.push_back(beam);
  }
  for (const Glimpse& glimpse : glimpses_) {
    const Pose2D now_from_then = inverse(odom_from_base) * glimpse.odom_from_base;
    for (map::Beam beam : glimpse.hits) {
      beam.origin = now_from_then * beam.origin;
      beam.direction = rotate(beam.direction, now_from_then.theta);
      hits.push_back(beam);
    }
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
  const auto rest = std::ranges::unique(placed, [](const Placed& a, const Placed& b) { return a.cell == b.cell; });
  placed.erase(rest.begin(), rest.end());

  const std::size_t every = (placed.size() + kMostHits - 1) / kMostHits;
  std::vector<map::Beam> seen;
  for (std::size_t i = 0; i < placed.size(); i += every) seen.push_back(hits[placed[i].index]);
  return seen;
}

std::optional<Pose2D> PlaceFinder::search(const Pose2D& odom_from_base, std::span<const map::Beam> beams) const {
  const ScanSearch& search = map_->search();
  const auto found = search.find(all_seen(odom_from_base, beams), search.everywhere(), kLeastScore);
  if (!found || found->score - found->elsewhere < kLead) return {};
  const Resemblance fit = map_->compare(found->pose, beams);
  if (fit.agreement() < kLeastAgreement || fit.contradiction() > kMostContradiction) return {};
  return found->pose;
}

void PlaceFinder::confirm(const std::optional<Pose2D>& found, const Pose2D& odom_from_base) {
  if (!found) {
    confirmed_ = 0;
    return;
  }
  const Pose2D off = inverse(map_from_odom_ * odom_from_base) * *found;
  const bool same = norm(off.position()) < kSamePosition && std::fabs(off.theta) < kSameHeading;
  confirmed_ = confirmed_ > 0 && same ? confirmed_ + 1 : 1;
  map_from_odom_ = *found * inverse(odom_from_base);
}

}  // namespace threewe::slam
