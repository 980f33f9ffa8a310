#include "nav/route.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <ranges>
#include <utility>

#include "map/change_log.hpp"
#include "nav/frontier_worth.hpp"
#include "nav/frontiers.hpp"
#include "nav/polyline.hpp"
#include "nav/shared_map.hpp"
#include "safety/params.hpp"

namespace threewe::nav {
namespace {

constexpr int kRim = 20;          // [cells] unknown all around the map
constexpr double kOpenCells = 2;  // around the body, in which the robot may leave lethal cells

// What the search calls a cell of way through free space: each costs 5 times the weight at both of its ends.
constexpr double kPerCell = 5.0 * 2.0 * map::Costmap::kFree;

// The point itself or, for one far outside of the map, the nearest within the horizon: beyond it nothing is in the way.
Vec2 within_horizon(const map::OccupancyGrid& map, Vec2 point, double horizon) {
  const Vec2 low = map.origin - Vec2{horizon, horizon};
  const Vec2 high = map.origin + Vec2{map.width * map.resolution + horizon, map.height * map.resolution + horizon};
  return {std::clamp(point.x, low.x, high.x), std::clamp(point.y, low.y, high.y)};
}

Vec2 robot_in(const Observation& seen) { return seen.pose.map_from_base().position(); }

// Through gaps that cells cannot tell from closed ones, since the wall's cell, the path's and the map may each be off
// by half a cell; but not where a wall has hardly been seen yet.
map::Costmap::Settings through_gaps(map::Costmap::Settings settings, const Params::Bottleneck& params) {
  settings.unknown_radius = settings.lethal_radius;
  settings.lethal_radius = std::max(settings.lethal_radius - params.coarseness, params.coarseness);
  return settings;
}

}  // namespace

Route::Route(const map::Costmap::Settings& costmap, const RobotProfile& profile, const Params& params)
    : params_(params.route),
      frontier_params_(params.frontier),
      bottleneck_params_(params.bottleneck),
      clear_{map::Costmap(costmap), {}, {}},
      squeezed_{map::Costmap(through_gaps(costmap, params.bottleneck)), {}, {}},
      body_radius_(profile.body.footprint.circumscribed_radius()),
      margin_(safety::margin_of(profile)),
      approach_speed_(params.progress.mean_speed * profile.operating_limits.linear),
      path_end_(params.motion.path_end),
      people_blur_(params.mppi.people_blur),
      creep_speed_(params.creep.speed),
      memory_(params) {}

void Route::set_zones(const std::vector<map::Zone>& zones, double speed) {
  clear_.costmap.set_zones(zones, speed);
  squeezed_.costmap.set_zones(zones, speed);
  drop();
}

void Route::begin(std::vector<Vec2> waypoints, bool drawn) {
  waypoints_ = std::move(waypoints);
  drawn_ = drawn;
  drop();
  frontier_.reset();
  gap_ = 0.0;
  memory_.clear();
}

// As near as a robot comes that waits for it, or meets it in a doorway.
bool Route::is_near_mover(Vec2 place) const {
  return mover_near(place, memory_.movers(), body_radius_ + params_.mover_distance) != nullptr;
}

bool Route::plan_to_goal(const Observation& seen, double tolerance) {
  if (squeezed_path_) drop();  // a path that keeps its distance is better, wherever it leads
  bool found = try_plan(clear_, seen, tolerance);
  if (!found && memory_.avoids_any()) {
    // what is avoided may have closed the only way
    memory_.stop_avoiding();
    found = try_plan(clear_, seen, tolerance);
  }
  if (found) bottleneck_ = known_bottleneck();
  return found;
}

bool Route::try_plan(Layer& layer, const Observation& seen, double tolerance) {
  renew(layer, seen);
  const map::Costmap& costmap = layer.costmap;

  // leg by leg; straight where the user drew a line that is free
  std::vector<Vec2> path = {robot_in(seen)};
  std::vector<std::size_t> ends;  // how many corners lead to each waypoint
  double gap = 0.0;
  for (const Vec2 ordered : waypoints_) {
    const Vec2 waypoint = within_horizon(seen.map, ordered, params_.horizon);
    if (drawn_ && std::isfinite(costmap.line_cost(path.back(), waypoint))) {
      path.push_back(waypoint);
    } else {
      const PlannedPath leg = layer.planner.plan(costmap, path.back(), waypoint, tolerance);
      gap = leg.gap;
      if (leg.points.empty() || (gap > 0.0 && gap > tolerance - path_end_)) {
        path_.clear();
        return false;
      }
      path.insert(path.end(), leg.points.begin() + 1, leg.points.end());
    }
    ends.push_back(path.size());
  }

  if (has_path()) {
    const double rest = path_cost(costmap, path_);
    if (!std::isfinite(rest)) note_closure();
    const bool same_end = path_.back() == path.back();
    if (std::isfinite(rest) && same_end && path_cost(costmap, path) > params_.better * rest) return true;
  }
  gap_ = gap;
  corners_from_.clear();
  for (const std::size_t end : ends) corners_from_.push_back(path.size() - end + 1);
  path_ = std::move(path);
  return true;
}

// Plans in a map from which they have been erased. Who is met is said to be where it was last seen.
std::optional<Mover> Route::mover_in_the_way(const Observation& seen, double tolerance) const {
  if (memory_.movers().empty()) return {};
  const std::vector<Mover> movers = gone_on(memory_.movers(), seen.now, creep_speed_);
  map::OccupancyGrid grid = seen.map;
  if (!seen.peers.empty()) merge_maps(seen.map, seen.peers, grid);
  const double blur = people_blur_ + grid.resolution;  // [m] that hits in cells may be off
  erase_movers(grid, movers, blur);
  std::vector<Vec2> obstacles = memory_.places(Outcome::barred);
  for (const Vec2 p : seen.obstacles) {
    const Vec2 in_map = seen.pose.map_from_odom * p;
    if (mover_near(in_map, movers, blur) == nullptr) obstacles.push_back(in_map);
  }
  map::Costmap costmap(clear_.costmap.settings());
  costmap.update(grid, obstacles, relevant_places(seen), kRim);
  costmap.open_around(robot_in(seen), body_radius_ + kOpenCells * seen.map.resolution);

  Planner planner;
  Vec2 from = robot_in(seen);
  const Mover* met = nullptr;
  for (const Vec2 ordered : waypoints_) {
    const Vec2 waypoint = within_horizon(seen.map, ordered, params_.horizon);
    const PlannedPath leg = planner.plan(costmap, from, waypoint, tolerance);
    if (leg.points.empty()) return {};
    first_along(leg.points, costmap.resolution(), [&](Vec2 p) {
      if (met == nullptr) met = mover_near(p, movers, body_radius_);
      return met != nullptr;
    });
    from = waypoint;
  }
  if (met == nullptr) return {};
  return *std::ranges::find(std::views::reverse(movers), met->name, &Mover::name);
}

bool Route::plan_to_frontier(const Observation& seen, const Explore& goal) {
  squeezed_path_ = false;
  bottleneck_.reset();
  if (try_frontier(clear_, seen, goal, 0.0)) return true;
  if (!memory_.avoids_any()) return false;

  // what is avoided may have closed the only way
  memory_.stop_avoiding();
  return try_frontier(clear_, seen, goal, 0.0);
}

// Those at which the robot keeps its distance, by a way on that layer. By the straight way most frontiers are not worth
// it, by the path the others.
bool Route::try_frontier(Layer& layer, const Observation& seen, const Explore& goal, double detour) {
  const bool squeezed = &layer == &squeezed_;
  renew(clear_, seen);
  if (squeezed) renew(squeezed_, seen);
  const map::Costmap& costmap = clear_.costmap;
  const Vec2 robot = robot_in(seen);
  if (has_path() && !std::isfinite(path_cost(layer.costmap, path_))) note_closure();
  path_.clear();
  find_frontiers(costmap, frontier_params_, frontiers_);
  left_some_ = !goal.thorough && drop_far_frontiers(costmap, frontier_params_, robot, frontiers_);

  const double per_metre = kPerCell / costmap.resolution();
  const int least = cells_in(frontier_params_.least_length, costmap.resolution());
  const auto bonus = [&](std::uint32_t index) {
    return int{frontiers_[index]} >= least ? std::optional(bonus_of_frontier(index, seen, goal)) : std::nullopt;
  };
  // through a gap the other side is seen only in part
  const auto is_unknown = [&](std::uint32_t index) { return !squeezed && costmap.unknown()[index] != 0; };
  const auto most = static_cast<int>(
      per_metre * (frontier_params_.gain * frontier_params_.longest + frontier_params_.stay + goal.most_worth));
  while (true) {
    const SearchResult found = search_.to_best(layer.costmap, costmap.cell(robot), bonus, most, is_unknown);
    if (!found.found) {
      frontier_.reset();
      return false;
    }
    const map::Cell end = found.path.back();
    path_ = straighten(layer.costmap, found.path, robot, costmap.center(end));
    if (goal.thorough || is_worthwhile(costmap, frontier_params_, end, frontiers_, path_length(path_) + detour)) {
      frontier_ = costmap.center(end);
      return true;
    }
    path_.clear();
    left_some_ = true;
    drop_frontier(costmap, end, frontiers_);
  }
}

// In the units of the search. What another robot is bound for and nearer to is left to it, as long as there is more.
int Route::bonus_of_frontier(std::uint32_t index, const Observation& seen, const Explore& goal) const {
  const map::Costmap& costmap = clear_.costmap;
  const auto width = static_cast<std::uint32_t>(costmap.width());
  const Vec2 place = costmap.center({static_cast<int>(index % width), static_cast<int>(index / width)});
  double worth = frontier_params_.gain * std::min(frontier_params_.longest, frontiers_[index] * costmap.resolution());
  if (frontier_ && distance(place, *frontier_) < frontier_params_.same) worth += frontier_params_.stay;
  if (goal.worth) worth += std::clamp(goal.worth(place), 0.0, goal.most_worth);
  for (const Peer& peer : seen.peers) {
    if (!peer.bound_for || distance(*peer.bound_for, place) > frontier_params_.claim) continue;
    if (distance(peer.map_from_base.position(), place) < distance(robot_in(seen), place))
      worth -= frontier_params_.claimed;
  }
  return static_cast<int>(kPerCell / costmap.resolution() * worth);
}

void Route::drop() {
  path_.clear();
  squeezed_path_ = false;
  bottleneck_.reset();
  corners_from_.clear();
  planned_once_ = false;
}

void Route::advance(Vec2 robot) {
  memory_.note_driven(robot);
  if (has_path()) {
    const PathPoint here = nearest_on_path(path_, robot);
    path_.erase(path_.begin(), path_.begin() + static_cast<std::ptrdiff_t>(here.piece));
    path_.front() = here.point;
  }
  while (waypoints_.size() > 1 && passed_waypoint(robot)) {
    waypoints_.erase(waypoints_.begin());
    if (!corners_from_.empty()) corners_from_.erase(corners_from_.begin());
  }
}

bool Route::avoid_ahead(bool end_too) {
  if (!has_path()) return false;
  if (end_too) memory_.avoid(Outcome::excused, path_.back());
  if (path_length(path_) <= params_.ahead) return false;
  return avoid(point_after(path_, {0, path_.front()}, params_.ahead));
}

bool Route::is_stale(const Observation& seen, Duration period) const {
  if (!has_path()) return age(seen.now) >= params_.retry;
  return seen.map_version != planned_version_ && age(seen.now) >= period;
}

void Route::renew(Layer& layer, const Observation& seen) {
  // what the lidar sees now counts too, where the map may not have it yet
  std::vector<Vec2> obstacles = memory_.obstacles();
  for (const Vec2 p : seen.obstacles) obstacles.push_back(seen.pose.map_from_odom * p);
  take_map(layer, seen, obstacles, relevant_places(seen));
  layer.costmap.open_around(robot_in(seen), body_radius_ + kOpenCells * seen.map.resolution);
  planned_once_ = true;
  planned_ = seen.now;
  planned_version_ = seen.map_version;
}

// What the costmap must hold.
std::vector<Vec2> Route::relevant_places(const Observation& seen) const {
  std::vector<Vec2> places = {robot_in(seen)};
  for (const Vec2 waypoint : waypoints_) places.push_back(within_horizon(seen.map, waypoint, params_.horizon));
  return places;
}

// Where peers tell what they know, that too; else only what has changed since the last time.
void Route::take_map(Layer& layer, const Observation& seen, const std::vector<Vec2>& obstacles,
                     const std::vector<Vec2>& include) {
  if (!seen.peers.empty()) {
    merge_maps(seen.map, seen.peers, shared_);
    layer.costmap.update(shared_, obstacles, include, kRim);
    layer.version.reset();
    return;
  }
  std::optional<map::Region> changed;
  if (seen.map_changes != nullptr && layer.version) changed = seen.map_changes->since(*layer.version);
  if (changed) {
    const map::Cell low = map::raster_cell(seen.map);
    changed = {{changed->low.x - low.x, changed->low.y - low.y}, {changed->high.x - low.x, changed->high.y - low.y}};
  }
  layer.costmap.update(seen.map, obstacles, include, kRim, changed);
  layer.version = seen.map_version;
}

// Near the next waypoint, or past it along the path.
bool Route::passed_waypoint(Vec2 robot) const {
  if (distance(robot, waypoints_.front()) < params_.waypoint) return true;
  return has_path() && !corners_from_.empty() && path_.size() <= corners_from_.front();
}

// Plans avoid a place of the path until there is no other way. Where that happened often and the path leads into
// unknown space, or to a frontier, they avoid it for good: the robot cannot look there. True when that has been
// decided.
bool Route::avoid(Vec2 place) {
  const bool excused = is_near_mover(place);
  memory_.avoid(excused ? Outcome::excused : Outcome::failed, place);
  if (excused || !memory_.failed_often(place) || memory_.has_driven(place)) return false;
  const auto is_entrance = [&](Vec2 p) {
    return clear_.costmap.unknown(clear_.costmap.cell(p)) && distance(p, place) < params_.entrance;
  };
  const std::optional<Vec2> entrance = first_along(path_, clear_.costmap.resolution(), is_entrance);
  if (!entrance && !waypoints_.empty()) return false;
  memory_.note(Outcome::barred, place);
  if (entrance) memory_.note(Outcome::barred, *entrance);
  return true;
}

// Of the path, once it has left the lethal cells that the robot may stand in.
std::optional<Vec2> Route::first_lethal() const {
  bool left = false;
  return first_along(path_, clear_.costmap.resolution(), [&](Vec2 p) {
    const bool lethal = is_lethal(p);
    left = left || !lethal;
    return left && lethal;
  });
}

bool Route::is_lethal(Vec2 place) const {
  return clear_.costmap.weight(clear_.costmap.cell(place)) == map::Costmap::kLethal;
}

// The path is blocked. A place that looked open from afar twice and was not is avoided from then on.
void Route::note_closure() {
  const std::optional<Vec2> closed = first_lethal();
  if (!closed) return;
  if (memory_.has(Outcome::closed, *closed)) {
    avoid(*closed);
  } else {
    memory_.note(Outcome::closed, *closed);
  }
}

}  // namespace threewe::nav
