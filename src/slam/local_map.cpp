#include "slam/local_map.hpp"

#include "slam/scan_beams.hpp"

namespace threewe::slam {

void LocalMap::extend(FrontEnd& front) {
  if (!pieces_.empty() && !front.is_due(pieces_.front().map.version())) return;
  const Params::LocalMap& p = params_->local_map;
  const Pose2D here = front.map_from_base();
  if (!pieces_.empty()) driven_ += distance(last_.position(), here.position());
  last_ = here;
  const auto age = [this](const Piece& piece) { return driven_ - piece.begun; };
  if (pieces_.size() == 2 && age(pieces_.front()) > p.length) pieces_.erase(pieces_.begin());
  if (pieces_.empty() || age(pieces_.back()) > p.length - p.overlap)
    pieces_.push_back(
        {map::LogOddsMap({.resolution = params_->coarse_resolution(), .free_range = params_->graph.free_range}),
         driven_});
  const std::vector<map::Beam> seen =
      filled(transformed(here, front.beams()), params_->coarse_resolution(), params_->beams);
  for (Piece& piece : pieces_) piece.map.insert(seen, front.range_bias(), front.range_noise());
  front.set_mapped();
}

}  // namespace threewe::slam
