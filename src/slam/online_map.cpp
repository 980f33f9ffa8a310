#include "slam/online_map.hpp"

#include <algorithm>
#include <cmath>

#include "slam/scan_beams.hpp"

namespace threewe::slam {
namespace {

constexpr std::size_t kAtOnce = 10;  // scans drawn again in one go, about a millisecond

}  // namespace

map::LogOddsMap::Settings OnlineMap::settings_of(const Params& params) {
  return {.resolution = params.map_resolution, .free_range = params.mapping.free_range};
}

OnlineMap::OnlineMap(const SharedParams& params)
    : params_(params->online_map),
      settings_(settings_of(*params)),
      map_(settings_),
      keyframe_graph_(KeyframeGraph(false, params)) {}

void OnlineMap::insert(const FrontEndScan& scan) {
  const Pose2D map_from_base = scan.local_from_base;
  map_.insert(transformed(map_from_base, scan.beams), scan.range_bias, scan.range_noise);
  if (!keyframe_graph_) return;
  range_bias_ = scan.range_bias;
  range_noise_ = scan.range_noise;

  FrontEndScan point = scan;
  point.local_from_base = inverse(map_from_local_) * map_from_base;
  if (std::exchange(broken_off_, false)) keyframe_graph_->go_on_at(map_from_base);
  keyframe_graph_->add(point, !drawing_);
  const std::vector<Keyframe>& keyframes = keyframe_graph_->data().keyframes;
  if (keyframes.back().stamp == scan.stamp) drawn_.push_back({scan.stamp, map_from_base});
  if (drawn_.size() > keyframes.size()) forget_dropped();
}

std::optional<Pose2D> OnlineMap::redraw() {
  if (!keyframe_graph_) return {};
  if (!drawing_ && keyframe_graph_->solutions() != std::exchange(solutions_, keyframe_graph_->solutions()) &&
      lies_elsewhere()) {
    drawing_.emplace(settings_);
    const map::OccupancyGrid& grid = map_.grid();
    const Vec2 size{grid.width * grid.resolution, grid.height * grid.resolution};
    drawing_->map.make_room(grid.origin, grid.origin + size);
  }
  if (!drawing_) return {};
  draw_some();
  if (drawing_->until < keyframe_graph_->data().keyframes.back().stamp) return {};
  return put_in_place();
}

// The trail drops ways that others lead along too.
void OnlineMap::forget_dropped() {
  const std::vector<Keyframe>& keyframes = keyframe_graph_->data().keyframes;
  auto next = keyframes.begin();
  std::erase_if(drawn_, [&](const Drawn& drawn) {
    if (next->stamp != drawn.stamp) return true;
    ++next;
    return false;
  });
}

// Whether some keyframe is no longer where the map has it.
bool OnlineMap::lies_elsewhere() const {
  for (std::size_t k = 0; k < drawn_.size(); ++k) {
    const Pose2D off = inverse(drawn_[k].map_from_base) * keyframe_graph_->data().graph.poses()[k];
    if (norm(off.position()) + params_.redraw_arm * std::fabs(off.theta) > params_.redraw_distance) return true;
  }
  return false;
}

void OnlineMap::draw_some() {
  const KeyframeGraphData& keyframe_graph = keyframe_graph_->data();
  auto next = std::ranges::upper_bound(keyframe_graph.keyframes, drawing_->until, {}, &Keyframe::stamp);
  for (std::size_t scans = 0; next != keyframe_graph.keyframes.end() && scans < kAtOnce; ++next) {
    const Pose2D& map_from_keyframe =
        keyframe_graph.graph.poses()[static_cast<std::size_t>(next - keyframe_graph.keyframes.begin())];
    for (const Keyframe::Scan& scan : next->scans) {
      drawing_->map.insert(unpacked(scan.beams, map_from_keyframe * scan.keyframe_from_base), range_bias_,
                           range_noise_);
      ++scans;
    }
    drawing_->until = next->stamp;
  }
}

// The new map instead of the old one.
Pose2D OnlineMap::put_in_place() {
  const KeyframeGraphData& keyframe_graph = keyframe_graph_->data();
  const Pose2D new_from_old = keyframe_graph.graph.poses().back() * inverse(drawn_.back().map_from_base);
  map_.replace(std::move(drawing_->map));
  drawing_.reset();
  map_from_local_ = new_from_old * map_from_local_;
  for (std::size_t k = 0; k < drawn_.size(); ++k) drawn_[k].map_from_base = keyframe_graph.graph.poses()[k];
  return new_from_old;
}

}  // namespace threewe::slam
