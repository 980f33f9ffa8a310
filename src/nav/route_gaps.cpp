// Gaps on a route: where they are, and what became of them.
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "core/exact.hpp"
#include "nav/polyline.hpp"
#include "nav/route.hpp"

namespace threewe::nav {
namespace {

constexpr double kWhole = std::numeric_limits<double>::infinity();  // of a path, looked at for the nearest place

}  // namespace

// About the tightest place of a part of the path that is narrow all along, as far as it is straight there.
template <class Narrow>
Bottleneck Route::bottleneck_about(Vec2 place, Narrow narrow) const {
  constexpr double kStep = 0.2;  // of a cell
  constexpr int kBeside = 10;    // steps before and after, between which it has a direction
  const double step = kStep * clear_.costmap.resolution();
  const double length = path_length(path_);
  const auto point_at = [&](int i) { return point_after(path_, {0, path_.front()}, step * i); };
  const int steps = static_cast<int>(length / step);
  const int here = static_cast<int>((length - length_after(path_, nearest_on_path(path_, place, kWhole))) / step);
  int first = here;
  while (first > 0 && narrow(point_at(first - 1))) --first;
  int last = here;
  while (last < steps && narrow(point_at(last + 1))) ++last;

  int from = first;
  int to = first;
  for (int i = first; i <= last; ++i) {
    if (clearance(point_at(i)) < clearance(point_at(from))) from = i;
    if (clearance(point_at(i)) <= clearance(point_at(from))) to = i;
  }
  const int tightest = (from + to) / 2;
  const Vec2 way = point_at(tightest + kBeside) - point_at(std::max(tightest - kBeside, 0));
  const Vec2 middle = point_at(tightest);
  const Pose2D map_from_middle{middle.x, middle.y, exact::atan2(way.y, way.x)};
  const Pose2D middle_from_map = inverse(map_from_middle);
  const auto is_straight = [&](int i) {
    return std::fabs((middle_from_map * point_at(i)).y) < bottleneck_params_.straight;
  };
  const auto length_to = [&](int direction, int end) {
    int i = tightest;
    while (i != end && is_straight(i + direction)) i += direction;
    return std::fabs((middle_from_map * point_at(i)).x);
  };
  return {map_from_middle, std::max({length_to(-1, first), length_to(1, last), bottleneck_params_.shortest})};
}

bool Route::plan_through_gaps(const Observation& seen, double tolerance, double longest) {
  return squeeze(seen, longest, [&] { return try_plan(squeezed_, seen, tolerance); });
}

bool Route::plan_to_frontier_through_gaps(const Observation& seen, const Explore& goal, double detour) {
  if (!memory_.movers().empty()) return false;  // who moves around makes gaps where none are
  return squeeze(seen, kWhole, [&] { return try_frontier(squeezed_, seen, goal, detour); });
}

// Plans until none of the bottlenecks on the way has been given up.
template <class Plan>
bool Route::squeeze(const Observation& seen, double longest, Plan plan) {
  constexpr int kMostAtOnce = 3;  // that are given up
  if (memory_.has(Outcome::tried) && seen.now > bottlenecks_until_) return false;
  for (int i = 0; i < kMostAtOnce; ++i) {
    squeezed_path_ = plan();
    if (!squeezed_path_) return false;
    if (path_length(path_) > longest) return false;
    // what the robot has been able to drive into it can drive out of
    const std::optional<Vec2> place = first_lethal();
    bottleneck_ =
        place ? std::optional(bottleneck_about(*place, [&](Vec2 p) { return is_lethal(p); })) : known_bottleneck();
    if (!bottleneck_ || seen.now < patience_with(*bottleneck_, seen.now)) return true;
    close_bottleneck(true);
  }
  return false;
}

// What a mover has closed it will open.
bool Route::is_detour(double detour) const {
  if (std::ranges::all_of(memory_.places(Outcome::closed), [&](Vec2 p) { return is_near_mover(p); })) return false;
  return path_length(path_) - detour >= distance(path_.front(), waypoints_.back());
}

// What is avoided is tried again until it has failed often.
bool Route::plan_shortcut(const Observation& seen, double tolerance, double detour) {
  if (!is_detour(detour)) return false;
  const double longest = path_length(path_) - detour;
  std::vector<Vec2> path = std::exchange(path_, {});
  memory_.suspend_avoiding();
  std::vector<std::size_t> corners_from = corners_from_;
  const double gap = gap_;
  if (plan_through_gaps(seen, tolerance, longest)) return true;
  squeezed_path_ = false;
  path_ = std::move(path);
  memory_.resume_avoiding();
  corners_from_ = std::move(corners_from);
  gap_ = gap;
  bottleneck_ = known_bottleneck();
  return false;
}

// Until when a gap is tried: for long enough to drive there, and for a while.
Time Route::patience_with(const Bottleneck& neck, Time now) {
  const Vec2 place = neck.map_from_middle.position();
  if (const std::optional<Time> until = memory_.tried_until(place)) return *until;
  if (!memory_.has(Outcome::tried)) bottlenecks_until_ = now + bottleneck_params_.patience;
  const Time until = now + bottleneck_params_.first_patience + from_seconds(path_length(path_) / approach_speed_);
  memory_.note_tried(place, until);
  return until;
}

std::optional<Bottleneck> Route::tight_place_ahead(Vec2 robot) const {
  const auto is_tight = [&](Vec2 p) { return clearance(p) < tight_clearance(); };
  const std::optional<Vec2> place = first_along(path_, clear_.costmap.resolution(), is_tight);
  if (!place || distance(*place, robot) > bottleneck_params_.ahead) return {};
  const Bottleneck found = bottleneck_about(*place, is_tight);
  const Vec2 middle = found.map_from_middle.position();
  if (memory_.has(Outcome::stuck, middle) || memory_.has(Outcome::exhausted, middle)) return {};
  return found;
}

bool Route::squeeze_ahead(Vec2 robot) {
  const std::optional<Bottleneck> found = tight_place_ahead(robot);
  if (!found) return false;
  memory_.note(Outcome::stuck, found->map_from_middle.position());
  memory_.stop_avoiding(found->map_from_middle.position());
  return true;
}

// The path through a gap in which the robot got stuck.
std::optional<Bottleneck> Route::known_bottleneck() const {
  constexpr double kOffPath = 2.0;  // [cells] a gap lies on the path so near to it
  for (const Vec2 gap : memory_.places(Outcome::stuck)) {
    const PathPoint nearest = nearest_on_path(path_, gap, kWhole);
    if (distance(nearest.point, gap) > kOffPath * clear_.costmap.resolution()) continue;
    return bottleneck_about(nearest.point, [&](Vec2 p) { return clearance(p) < tight_clearance(); });
  }
  return {};
}

void Route::leave_bottleneck(Vec2 robot) {
  if (!memory_.has(Outcome::passed, robot)) {
    memory_.note(Outcome::passed, robot);
    bottlenecks_until_ = std::max(bottlenecks_until_, planned_ + bottleneck_params_.patience);
  }
  const bool is_tight = clearance(robot) < tight_clearance();
  if (is_tight && !memory_.has(Outcome::exhausted, robot)) memory_.note(Outcome::stuck, robot);
  drop();
}

void Route::clear_bottleneck() {
  memory_.forget(Outcome::stuck, bottleneck_->map_from_middle.position());
  drop();
}

void Route::close_bottleneck(bool too_narrow) {
  const double spacing = 0.8 * clear_.costmap.resolution();  // [m] of a row of points from side to side
  const Pose2D middle = bottleneck_->map_from_middle;
  memory_.forget(Outcome::stuck, middle.position());
  if (is_near_mover(middle.position())) return drop();
  memory_.note(Outcome::exhausted, middle.position());
  avoid(middle.position());
  if (too_narrow || memory_.failed_often(middle.position())) {
    const int beside = 1 + static_cast<int>((clear_.costmap.resolution() + tight_clearance()) / spacing);
    for (int i = -beside; i <= beside; ++i) memory_.note(Outcome::barred, middle * Vec2{0.0, spacing * i});
  }
  drop();
}

// [m] Where paths may need care: so near that the gate keeps its margin, as far as cells can tell.
double Route::tight_clearance() const {
  const map::Costmap& costmap = clear_.costmap;
  return costmap.settings().lethal_radius + margin_ + 0.5 * costmap.resolution();
}

double Route::clearance(Vec2 place) const { return clear_.costmap.clearance(clear_.costmap.cell(place)); }

}  // namespace threewe::nav
