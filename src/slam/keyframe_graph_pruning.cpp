// What keeps a trail bounded in a bounded place: of the submaps that lead along the same way some are enough.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/LU>

#include "slam/keyframe_graph.hpp"
#include "slam/pose_covariance.hpp"

namespace threewe::slam {
namespace {

constexpr std::size_t kNotFinished = 2;  // the newest ones

bool is_beside(const Pose2D& a, const Pose2D& b, const Params::Graph& params) {
  return distance(a.position(), b.position()) < params.same_way &&
         std::fabs(wrap_angle(a.theta - b.theta)) < params.same_way_heading;
}

bool leads_by(const KeyframeGraphData& keyframe_graph, const Submap& submap, const Pose2D& place,
              const Params::Graph& params) {
  for (int k = submap.first; k <= submap.last; ++k) {
    if (is_beside(keyframe_graph.pose_of(k), place, params)) return true;
  }
  return false;
}

// Whether the robot was lost before a keyframe, so that nothing measured relates it to the one before.
bool begins_component(const KeyframeGraphData& keyframe_graph, int keyframe) {
  return std::ranges::any_of(keyframe_graph.graph.constraints(),
                             [&](const Constraint& c) { return !c.doubtful && c.to == keyframe && !joins(c); });
}

// Whether all of its way is seen by enough others too, of its own component.
bool is_redundant(const KeyframeGraphData& keyframe_graph, const std::vector<int>& components, std::size_t index,
                  const Params::Graph& params) {
  const Submap& submap = keyframe_graph.submaps[index];
  const auto enough = static_cast<std::size_t>(params.ways);
  const auto component = [&](int keyframe) { return components[static_cast<std::size_t>(keyframe)]; };
  for (int k = submap.first; k <= submap.last; ++k) {
    std::size_t others = 0;
    for (std::size_t i = 0; i < keyframe_graph.submaps.size() && others < enough; ++i) {
      const bool same = component(keyframe_graph.submaps[i].first) == component(submap.first);
      if (i != index && same && leads_by(keyframe_graph, keyframe_graph.submaps[i], keyframe_graph.pose_of(k), params))
        ++others;
    }
    if (others < enough) return false;
  }
  return true;
}

// The oldest redundant submap that the last finished one leads by: no other can have become redundant. The first stays,
// for the map begins there.
std::optional<std::size_t> find_redundant(const KeyframeGraphData& keyframe_graph, const Params::Graph& params) {
  const auto enough = static_cast<std::size_t>(params.ways);
  if (keyframe_graph.submaps.size() <= kNotFinished + enough) return {};
  const std::size_t finished = keyframe_graph.submaps.size() - kNotFinished;
  const Submap& last = keyframe_graph.submaps[finished];
  const std::vector<int> components = keyframe_graph.components();
  for (std::size_t i = 1; i < finished; ++i) {
    bool meets = false;
    for (int k = last.first; k <= last.last && !meets; ++k)
      meets = leads_by(keyframe_graph, keyframe_graph.submaps[i], keyframe_graph.pose_of(k), params);
    if (meets && is_redundant(keyframe_graph, components, i, params) &&
        !begins_component(keyframe_graph, keyframe_graph.submaps[i].first))
      return i;
  }
  return {};
}

// How uncertain the way from the keyframe before a submap to the one after it is, by itself.
Matrix3 across(const KeyframeGraphData& keyframe_graph, const Submap& gap) {
  Matrix3 covariance = Matrix3::Zero();
  Pose2D way;
  for (const Constraint& c : keyframe_graph.graph.constraints()) {
    if (c.doubtful || c.to != c.from + 1 || c.to < gap.first || c.from > gap.last) continue;
    covariance = composed(way, covariance, c.from_from_to, c.information.inverse());
    way = way * c.from_from_to;
  }
  return covariance;
}

// The graph without the keyframes of a submap: its neighbours are joined as they lie now, and its closures are gone.
PoseGraph without(const KeyframeGraphData& keyframe_graph, const Submap& gap) {
  const int gone = gap.last - gap.first + 1;
  const auto stays = [&](int k) { return k < gap.first || k > gap.last; };
  PoseGraph graph;
  for (int k = 0; k <= keyframe_graph.newest(); ++k) {
    if (stays(k)) graph.add_node(keyframe_graph.pose_of(k), keyframe_graph.graph.is_fixed(k));
  }
  for (Constraint c : keyframe_graph.graph.constraints()) {
    const bool enters = !c.doubtful && c.to == gap.first && c.from == gap.first - 1;
    if (enters) {
      const Matrix3 inverse_covariance = across(keyframe_graph, gap).inverse();
      c.to = gap.last + 1;
      c.from_from_to = inverse(keyframe_graph.pose_of(c.from)) * keyframe_graph.pose_of(c.to);
      c.information = 0.5 * (inverse_covariance + inverse_covariance.transpose());
    }
    if (!stays(c.from) || !stays(c.to)) continue;
    c.from -= c.from > gap.last ? gone : 0;
    c.to -= c.to > gap.last ? gone : 0;
    graph.add_constraint(c);
  }
  return graph;
}

}  // namespace

bool KeyframeGraphData::prune(const Params::Graph& params) {
  const std::optional<std::size_t> index = find_redundant(*this, params);
  if (!index) return false;
  const Submap gap = submaps[*index];
  const int gone = gap.last - gap.first + 1;

  // where the robot was there is computed from the keyframe before
  for (TrajectoryStep& step : steps) {
    if (step.keyframe > gap.last)
      step.keyframe -= gone;
    else if (step.keyframe >= gap.first) {
      step.keyframe_from_base = inverse(pose_of(gap.first - 1)) * pose_of(step);
      step.keyframe = gap.first - 1;
    }
  }
  graph = without(*this, gap);
  keyframes.erase(keyframes.begin() + gap.first, keyframes.begin() + gap.last + 1);
  submaps.erase(submaps.begin() + static_cast<std::ptrdiff_t>(*index));
  for (Submap& submap : submaps) {
    if (submap.first < gap.first) continue;
    submap.first -= gone;
    submap.last -= gone;
  }
  return true;
}

}  // namespace threewe::slam
