#include "slam/keyframe_graph.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include <Eigen/LU>

#include "core/exact.hpp"
#include "core/numbers.hpp"
#include "slam/pose_covariance.hpp"
#include "slam/scan_beams.hpp"

namespace threewe::slam {
namespace {

constexpr double kNowhere = 100.0;   // [m] off may be one that was lost ...
constexpr double kSomewhere = 10.0;  // [m] ... constraints beyond this join nothing

constexpr std::size_t kAsked = 3;  // submaps whose deviation is worked out
constexpr int kStepsOfSolution = 10;
constexpr std::size_t kUncovered = 20;  // keyframes that the covariance may lack
constexpr std::size_t kClosers = 8;     // maps of submaps that are kept for the next search

// The part of a symmetric matrix of positions that is not negative, and the same of its heading.
Matrix3 growth(const Matrix3& change) {
  const double a = change(kX, kX);
  const double b = change(kX, kY);
  const double d = change(kY, kY);
  const double mean = 0.5 * (a + d);
  const double root = exact::hypot(0.5 * (a - d), b);
  Matrix3 part = Matrix3::Zero();
  part(kTheta, kTheta) = std::max(change(kTheta, kTheta), 0.0);
  if (root <= mean) {
    part.topLeftCorner<2, 2>() = change.topLeftCorner<2, 2>();
  } else if (mean + root > 0.0) {
    // of two eigenvalues one counts: (M - small I) is (large - small) times the projection on its direction
    const double share = (mean + root) / (2.0 * root);
    part(kX, kX) = share * (a - mean + root);
    part(kY, kY) = share * (d - mean + root);
    part(kX, kY) = part(kY, kX) = share * b;
  }
  return part;
}

// How far off the front-end may be from one keyframe to the next.
Matrix3 step_covariance(const Pose2D& step, const Matrix3& unobserved, const Params::Graph& params) {
  const double length = norm(step.position());
  const double position = params.drift * length + square(params.least_drift);
  const double heading = square(params.turn_drift) * length + square(params.least_turn_drift);
  return unobserved + Matrix3(Vector3(position, position, heading).asDiagonal());
}

bool is_apart(double metres, double radians, const Pose2D& a, const Pose2D& b) {
  const Pose2D a_from_b = inverse(a) * b;
  return norm(a_from_b.position()) >= metres || std::fabs(a_from_b.theta) >= radians;
}

Matrix3 information_of(const Matrix3& covariance) {
  const Matrix3 inverse = covariance.inverse();
  return 0.5 * (inverse + inverse.transpose());
}

}  // namespace

bool KeyframeGraphData::extend_submaps(double length) {
  const int here = newest();
  const bool begins = submaps.empty() || driven_at(here) - driven_at(submaps.back().first) > length;
  if (begins) submaps.push_back({here, here, {}});
  submaps.back().last = here;
  return begins;
}

bool joins(const Constraint& constraint) { return constraint.information(kX, kX) > 1.0 / square(kSomewhere); }

// The root of each keyframe is the first of its component.
std::vector<int> KeyframeGraphData::components() const {
  std::vector<int> parent(keyframes.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int k) {
    while (parent[static_cast<std::size_t>(k)] != k) k = parent[static_cast<std::size_t>(k)];
    return k;
  };
  for (const Constraint& c : graph.constraints()) {
    if (!joins(c)) continue;
    const auto [low, high] = std::minmax({root(c.from), root(c.to)});
    parent[static_cast<std::size_t>(high)] = low;
  }
  for (int k = 0; k <= newest(); ++k) parent[static_cast<std::size_t>(k)] = root(k);
  return parent;
}

KeyframeGraph::KeyframeGraph(KeyframeGraphData data, const Pose2D& map_from_base, SharedParams params)
    : params_(std::move(params)), data_(std::move(data)), goes_on_at_(map_from_base), components_(data_.components()) {}

Pose2D KeyframeGraph::add(const FrontEndScan& point, bool closes_loops) {
  const bool begins = data_.keyframes.empty() || goes_on_at_ || point.lost ||
                      is_apart(params_->graph.keyframe_distance, params_->graph.keyframe_turn, local_from_keyframe_,
                               point.local_from_base);
  if (begins) begin_keyframe(point);
  if (!keeps_steps_) data_.steps.clear();
  data_.steps.push_back({point.stamp, data_.newest(), inverse(local_from_keyframe_) * point.local_from_base});
  keep_scan(point);
  if (begins) {
    if (data_.extend_submaps(params_->graph.submap_length) && data_.prune(params_->graph)) forget();
    if (closes_loops) close_loop(point.range_bias);
  }
  return data_.pose_of(data_.steps.back());
}

void KeyframeGraph::begin_keyframe(const FrontEndScan& point) {
  if (data_.keyframes.empty()) {
    data_.graph.add_node(goes_on_at_.value_or(Pose2D{}), true);
    data_.keyframes.push_back({point.stamp, 0.0, {}});
    components_.push_back(0);
    goes_on_at_.reset();
  } else {
    const int before = data_.newest();
    Pose2D step = inverse(local_from_keyframe_) * point.local_from_base;
    Matrix3 covariance = step_covariance(
        step, rotated(growth(point.covariance - covariance_at_keyframe_), -local_from_keyframe_.theta), params_->graph);
    double length = norm(step.position()) + params_->graph.turning * std::fabs(step.theta);
    if (goes_on_at_) {
      step = inverse(data_.pose_of(before)) * *goes_on_at_;
      covariance = Vector3(square(params_->graph.resumed_position), square(params_->graph.resumed_position),
                           square(params_->graph.resumed_heading))
                       .asDiagonal();
      length = params_->graph.submap_length;  // all that was there before may be met at once
      goes_on_at_.reset();
    } else if (point.lost) {
      covariance = Vector3(square(kNowhere), square(kNowhere), square(exact::kPi)).asDiagonal();
      length = 2.0 * params_->graph.submap_length;  // nothing that was seen before is seen together with this
      unconfirmed_.reset();
    }
    const int node = data_.graph.add_node(data_.pose_of(before) * step);
    data_.graph.add_constraint({before, node, step, information_of(covariance)});
    uncovered_.push_back(covariance);
    data_.keyframes.push_back({point.stamp, driven() + length, {}});
    components_.push_back(point.lost ? node : component_of(before));
  }
  local_from_keyframe_ = point.local_from_base;
  covariance_at_keyframe_ = point.covariance;
}

void KeyframeGraph::keep_scan(const FrontEndScan& point) {
  Keyframe& keyframe = data_.keyframes.back();
  if (point.beams.empty()) return;
  if (!keyframe.scans.empty() &&
      !is_apart(params_->graph.scan_distance, params_->graph.scan_turn, scan_kept_at_, point.local_from_base))
    return;
  keyframe.scans.push_back({data_.steps.back().keyframe_from_base, packed(point.beams)});
  scan_kept_at_ = point.local_from_base;
}

// Looks for the robot in the nearest submap that it has left long ago, and takes what is found into the graph.
void KeyframeGraph::close_loop(double range_bias) {
  if (unconfirmed_) return confirm_loop(range_bias);
  const std::vector<Nearby> near =
      nearby(components_.back(), data_.graph.poses().back().position(), params_->loops.far, params_->loops.try_again);
  for (std::size_t i = 0; i < std::min(near.size(), kAsked); ++i) {
    const Matrix3 covariance = between(near[i].keyframe);
    const double deviation = exact::sqrt(std::max(covariance(kX, kX), covariance(kY, kY)));
    if (near[i].away >= params_->loops.near + 2.0 * deviation) continue;
    const Pose2D keyframe_from_base = inverse(data_.pose_of(near[i].keyframe)) * data_.graph.poses().back();
    const auto closure = search(near[i], {keyframe_from_base, covariance}, range_bias);
    if (closure && deviation < params_->loops.unsure) take(*closure);
    if (closure && deviation >= params_->loops.unsure) unconfirmed_ = closure;
    return;
  }
}

// Who has lost the way for metres may take one door for another: only when what is seen farther on fits as well, where
// that closure says it must be, both count.
void KeyframeGraph::confirm_loop(double range_bias) {
  const Constraint first = *unconfirmed_;
  if (driven() - data_.driven_at(first.to) < params_->loops.view_length) return;
  unconfirmed_.reset();
  const Pose2D way = inverse(data_.pose_of(first.to)) * data_.graph.poses().back();
  const Pose2D map_from_base = data_.pose_of(first.from) * first.from_from_to * way;
  const std::vector<Nearby> near = nearby(component_of(first.from), map_from_base.position(), params_->loops.near, 0.0);
  if (near.empty()) return;
  const Matrix3 covariance = Vector3(square(params_->loops.same_position), square(params_->loops.same_position),
                                     square(params_->loops.same_heading))
                                 .asDiagonal();
  const Pose2D keyframe_from_base = inverse(data_.pose_of(near.front().keyframe)) * map_from_base;
  const auto second = search(near.front(), {keyframe_from_base, covariance}, range_bias);
  if (!second) return;
  const bool joins = component_of(first.from) != component_of(first.to);
  take(first);
  take(*second);
  if (joins) solve();  // one closure alone may be a little turned
}

void KeyframeGraph::join_at(int component, const Pose2D& map_from_base, double range_bias) {
  if (unconfirmed_) return;
  const Pose2D map_from_keyframe = map_from_base * inverse(data_.steps.back().keyframe_from_base);
  const std::vector<Nearby> near = nearby(component, map_from_keyframe.position(), params_->loops.near, 0.0);
  if (near.empty()) return;
  const Matrix3 covariance = Vector3(square(params_->loops.found_position), square(params_->loops.found_position),
                                     square(params_->loops.found_heading))
                                 .asDiagonal();
  const Pose2D keyframe_from_base = inverse(data_.pose_of(near.front().keyframe)) * map_from_keyframe;
  unconfirmed_ = search(near.front(), {keyframe_from_base, covariance}, range_bias);
}

// The submaps of a component that were left long ago, were not tried for `again` metres and lead by a place; the
// nearest first.
std::vector<KeyframeGraph::Nearby> KeyframeGraph::nearby(int component, Vec2 place, double within, double again) const {
  std::vector<Nearby> found;
  for (std::size_t i = 0; i < data_.submaps.size(); ++i) {
    const Submap& submap = data_.submaps[i];
    if (component_of(submap.first) != component) continue;
    const double left_at = data_.driven_at(submap.last);
    if (driven() - left_at < params_->graph.submap_length || driven() - submap.tried_at < again) continue;
    Nearby nearest{static_cast<int>(i), submap.first, within};
    for (int k = submap.first; k <= submap.last; ++k) {
      const double away = distance(data_.pose_of(k).position(), place);
      if (away < nearest.away) nearest = {static_cast<int>(i), k, away};
    }
    if (nearest.away < within) found.push_back(nearest);
  }
  std::ranges::stable_sort(found, {}, &Nearby::away);
  return found;
}

// Searches for the robot in a submap; `belief` is about where it is, seen from the keyframe nearby. What is found is
// computed from the keyframe that is then nearest, so that a bend of the submap counts little.
std::optional<Constraint> KeyframeGraph::search(const Nearby& near, const PoseBelief& belief, double range_bias) {
  Submap& submap = data_.submaps[static_cast<std::size_t>(near.submap)];
  submap.tried_at = driven();
  const LoopCloser& closer = closer_of(submap, range_bias);
  const std::vector<Pose2D>& places = submap.submap_from_keyframe;
  const Pose2D& from = places[static_cast<std::size_t>(near.keyframe - submap.first)];
  int scans = 0;
  const std::vector<map::Beam> seen = view(&scans);
  const PoseBelief in_submap{from * belief.pose, rotated(belief.covariance, from.theta)};
  const auto match = closer.find(seen, scans, in_submap, range_bias);
  if (!match) return {};
  const auto nearest = std::ranges::min_element(
      places, {}, [&](const Pose2D& place) { return distance(place.position(), match->map_from_base.position()); });
  return Constraint{submap.first + static_cast<int>(nearest - places.begin()), data_.newest(),
                    inverse(*nearest) * match->map_from_base,
                    information_of(rotated(match->covariance, -nearest->theta)), true};
}

// Solves the graph at once where the closure says something new.
void KeyframeGraph::take(const Constraint& closure) {
  align(closure);
  const int constraint = data_.graph.add_constraint(closure);
  if (driven() - solved_at_ < params_->graph.solve_distance &&
      data_.graph.fit(constraint).chi_squared < params_->graph.solve_chi)
    return;
  solve();
}

void KeyframeGraph::solve() {
  data_.graph.solve(kStepsOfSolution);
  ++solutions_;
  graph_covariance_.reset();
  solved_at_ = driven();
}

// A closure between two components makes them one: the later moves to where the closure has it.
void KeyframeGraph::align(const Constraint& closure) {
  const auto [stays, moves] = std::minmax({component_of(closure.from), component_of(closure.to)});
  if (stays == moves) return;
  const Pose2D to = data_.pose_of(closure.from) * closure.from_from_to;
  const Pose2D from = data_.pose_of(closure.to) * inverse(closure.from_from_to);
  const Pose2D new_from_old = moves == component_of(closure.to) ? to * inverse(data_.pose_of(closure.to))
                                                                : from * inverse(data_.pose_of(closure.from));
  for (int k = 0; k <= data_.newest(); ++k) {
    int& component = components_[static_cast<std::size_t>(k)];
    if (component != moves) continue;
    data_.graph.set_pose(k, new_from_old * data_.pose_of(k));
    component = stays;
  }
  ++joined_;
}

// Of the newest keyframe, seen from another. The graph's covariance is worked out now and then; from there on the steps
// add up.
Matrix3 KeyframeGraph::between(int keyframe) {
  const int here = data_.newest();
  if (!graph_covariance_ || uncovered_.size() >= kUncovered || keyframe > here - static_cast<int>(uncovered_.size())) {
    graph_covariance_ = std::make_shared<const GraphCovariance>(data_.graph);
    uncovered_.clear();
  }
  int k = here - static_cast<int>(uncovered_.size());
  Matrix3 covariance = graph_covariance_->between(keyframe, k);
  const Pose2D keyframe_from_map = inverse(data_.pose_of(keyframe));
  for (const Matrix3& of_step : uncovered_) {
    const Pose2D step = inverse(data_.pose_of(k)) * data_.pose_of(k + 1);
    covariance = composed(keyframe_from_map * data_.pose_of(k), covariance, step, of_step);
    ++k;
  }
  return covariance;
}

// What follows from the trail, when that was changed otherwise than at its end.
void KeyframeGraph::forget() {
  unconfirmed_.reset();
  graph_covariance_.reset();
  closers_.clear();
  components_ = data_.components();
}

const LoopCloser& KeyframeGraph::closer_of(Submap& submap, double range_bias) {
  const auto known = std::ranges::find(closers_, submap.first, &Cached::first);
  if (known != closers_.end()) {
    std::rotate(known, known + 1, closers_.end());
    return *closers_.back().closer;
  }
  if (submap.submap_from_keyframe.empty()) {
    const Pose2D submap_from_map = inverse(data_.pose_of(submap.first));
    for (int k = submap.first; k <= submap.last; ++k) {
      submap.submap_from_keyframe.push_back(submap_from_map * data_.pose_of(k));
    }
    submap.range_bias = range_bias;
  }
  std::vector<std::vector<map::Beam>> scans;
  for (int k = submap.first; k <= submap.last; ++k) {
    const Pose2D& place = submap.submap_from_keyframe[static_cast<std::size_t>(k - submap.first)];
    const std::vector<Keyframe::Scan>& seen = data_.keyframes[static_cast<std::size_t>(k)].scans;
    if (!seen.empty()) scans.push_back(unpacked(seen.front().beams, place * seen.front().keyframe_from_base));
  }
  map::LogOddsMap map = drawn(
      scans, {.resolution = params_->coarse_resolution(), .free_range = params_->graph.free_range}, submap.range_bias);
  if (closers_.size() == kClosers) closers_.erase(closers_.begin());
  closers_.push_back({submap.first, std::make_shared<const LoopCloser>(std::move(map), params_)});
  return *closers_.back().closer;
}

// What was seen on the last metres, as it lies around the robot.
std::vector<map::Beam> KeyframeGraph::view(int* scans) const {
  std::vector<map::Beam> beams;
  const Pose2D base_from_map = inverse(data_.graph.poses().back());
  double last = 1e9;
  for (int k = data_.newest(); k >= 0; --k) {
    const Keyframe& keyframe = data_.keyframes[static_cast<std::size_t>(k)];
    if (data_.keyframes.back().driven - keyframe.driven > params_->loops.view_length) break;
    if (last - keyframe.driven < params_->loops.view_distance || keyframe.scans.empty()) continue;
    last = keyframe.driven;
    const Keyframe::Scan& scan = keyframe.scans.front();
    const std::vector<map::Beam> seen =
        unpacked(scan.beams, base_from_map * data_.pose_of(k) * scan.keyframe_from_base);
    beams.insert(beams.end(), seen.begin(), seen.end());
    ++*scans;
  }
  return beams;
}

}  // namespace threewe::slam
