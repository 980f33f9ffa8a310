#include "slam/relocalizer.hpp"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "slam/packed_scan.hpp"
#include "slam/prior_map.hpp"
#include "slam/scan_beams.hpp"

namespace threewe::slam {
namespace {

constexpr std::ptrdiff_t kLeastKeyframes = 3;  // less of a map tells nothing
constexpr std::int64_t kWorkOfScan = 200'000;  // about a millisecond for each scan, see BranchAndBoundMatcher::Search

// The first keyframe of each component.
std::vector<int> roots_of(const std::vector<int>& components) {
  std::vector<int> roots;
  for (int k = 0; std::cmp_less(k, components.size()); ++k) {
    if (components[static_cast<std::size_t>(k)] == k) roots.push_back(k);
  }
  return roots;
}

}  // namespace

map::LogOddsMap drawn_component(const KeyframeGraphData& keyframe_graph, const std::vector<int>& components,
                                int component, double resolution, double range_bias, const Params& params) {
  std::vector<std::vector<map::Beam>> scans;
  for (std::size_t k = 0; k < keyframe_graph.keyframes.size(); ++k) {
    if (components[k] != component) continue;
    const Pose2D& map_from_keyframe = keyframe_graph.graph.poses()[k];
    for (const Keyframe::Scan& scan : keyframe_graph.keyframes[k].scans) {
      scans.push_back(unpacked(scan.beams, map_from_keyframe * scan.keyframe_from_base));
    }
  }
  return drawn(scans, {.resolution = resolution, .free_range = params.mapping.free_range}, range_bias);
}

std::optional<Relocalizer::Found> Relocalizer::look(const KeyframeGraph& keyframe_graph, Time stamp,
                                                    const Pose2D& local_from_base, std::span<const map::Beam> beams,
                                                    double range_bias) {
  const std::vector<int>& components = keyframe_graph.components();
  const auto stamp_of = [&](int keyframe) {
    return keyframe_graph.data().keyframes[static_cast<std::size_t>(keyframe)].stamp;
  };
  const std::vector<int> roots = roots_of(components);
  if (stamp_of(components.back()) != component_ || roots.size() != count_) {
    component_ = stamp_of(components.back());
    count_ = roots.size();
    searches_.clear();
    begun_ = false;
  }
  if (count_ == 1 || beams.empty()) return {};
  if (!begun_ && std::ranges::count(components, components.back()) < kLeastKeyframes) return {};
  if (!begun_) begin(keyframe_graph, range_bias);

  std::optional<Found> found;
  for (Search& search : searches_) {
    const auto place = search.finder.look(stamp, local_from_base, beams);
    if (place && !found) found = {*std::ranges::find(roots, search.component, stamp_of), *place};
    search.finder.go_on(kWorkOfScan / static_cast<std::int64_t>(searches_.size()));
  }
  return found;
}

void Relocalizer::begin(const KeyframeGraph& keyframe_graph, double range_bias) {
  const std::vector<int>& components = keyframe_graph.components();
  for (const int c : roots_of(components)) {
    if (c == components.back() || std::ranges::count(components, c) < kLeastKeyframes) continue;
    const map::LogOddsMap map =
        drawn_component(keyframe_graph.data(), components, c, params_->coarse_resolution(), range_bias, *params_);
    const Time first = keyframe_graph.data().keyframes[static_cast<std::size_t>(c)].stamp;
    searches_.push_back({first, GlobalLocalizer(std::make_shared<const PriorMap>(map.grid(), params_), params_)});
  }
  begun_ = true;
}

}  // namespace threewe::slam
