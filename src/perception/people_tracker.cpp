#include "perception/people_tracker.hpp"

#include <algorithm>
#include <cmath>

#include "perception/bearing_bin.hpp"

namespace threewe::perception {
namespace {

constexpr std::size_t kNeighbours = 2;  // beams to both sides must have done so too

bool is_valid(const LaserScan& scan, std::size_t beam) {
  const auto range = static_cast<double>(scan.ranges[beam]);
  return range > 0.0 && range >= scan.range_min;
}

// Where the lidar was as it measured a beam.
Pose2D pose_at(const LaserScan& scan, std::size_t beam, const Pose2D& then, const Pose2D& now) {
  const double share = (static_cast<double>(beam) + 0.5) / static_cast<double>(scan.ranges.size());
  return interpolate(then, now, scan.time_increment < 0.0 ? 1.0 - share : share);
}

}  // namespace

void PeopleTracker::update(const LaserScan& scan, Time began, Time ended, const Pose2D& odom_from_lidar_then,
                           const Pose2D& odom_from_lidar) {
  const Time stamp = began + (ended - began) / 2;
  find_ends(scan, odom_from_lidar_then, odom_from_lidar);
  find_hits(scan);
  group_hits(scan, odom_from_lidar.position());
  merge_legs();
  predict(stamp);
  assign(stamp);
  begin_tracks(stamp);
  end_tracks(stamp);
  remember(scan, stamp, interpolate(odom_from_lidar_then, odom_from_lidar, 0.5).position());
}

// How far beams could be seen along, each from where the lidar was then.
void PeopleTracker::find_ends(const LaserScan& scan, const Pose2D& then, const Pose2D& now) {
  ends_.assign(scan.ranges.size(), {});
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    if (!is_valid(scan, i)) continue;
    const Pose2D lidar = pose_at(scan, i, then, now);
    const double angle = lidar.theta + scan.angle_min + static_cast<double>(i) * scan.angle_increment;
    ends_[i] = lidar.position() + rotate({static_cast<double>(scan.ranges[i]), 0.0}, angle);
  }
}

// Where beams hit something, and whether it was there before.
void PeopleTracker::find_hits(const LaserScan& scan) {
  hits_.clear();
  choose_views();
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    const auto range = static_cast<double>(scan.ranges[i]);
    if (!is_valid(scan, i) || range >= scan.range_max || range > params_.farthest) continue;
    hits_.push_back({ends_[i], i, range, was_free(ends_[i], params_.free_by)});
  }
}

void PeopleTracker::choose_views() {
  old_views_.clear();
  for (std::size_t i = 0; i < views_.size(); ++i) {
    if (views_[i].stamp + params_.youngest_view <= stamp_) old_views_.emplace_back(i, 0);
  }
}

// Did several earlier scans look through this point?
bool PeopleTracker::was_free(Vec2 point, double margin) {
  int through = 0;
  int left = static_cast<int>(old_views_.size());
  for (auto& [index, bin] : old_views_) {
    if (through + left-- < params_.views_through) return false;
    const View& view = views_[index];
    const Vec2 d = point - view.from;
    bin = bearing_bin(d, bin);  // near where the hit before was
    const auto needed = static_cast<float>(norm(d) + margin);
    if (view.open[bin] > needed && ++through >= params_.views_through) return true;
  }
  return false;
}

void PeopleTracker::remember(const LaserScan& scan, Time stamp, Vec2 from) {
  static_assert(kBins == kBearingBins);
  const auto nearer = [](float a, float b) { return a == 0.0F ? b : b == 0.0F ? a : std::min(a, b); };
  std::array<float, kBins> ranges{};
  std::size_t bin = 0;
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    if (!is_valid(scan, i)) continue;
    const Vec2 d = ends_[i] - from;
    bin = bearing_bin(d, bin);
    ranges[bin] = nearer(ranges[bin], static_cast<float>(norm(d)));
  }
  View view{stamp, from, {}};
  for (std::size_t i = 0; i < kBins; ++i) {
    for (std::size_t k = kBins - kNeighbours; k <= kBins + kNeighbours; ++k) {
      view.open[i] = nearer(view.open[i], ranges[(i + k) % kBins]);
    }
  }
  if (views_.size() < kRemembered) {
    views_.push_back(view);
  } else {
    views_[next_view_] = view;
    next_view_ = (next_view_ + 1) % kRemembered;
  }
  stamp_ = stamp;
}

// Blobs of neighbouring hits that are no wider than a person and stand free of what is beside them.
void PeopleTracker::group_hits(const LaserScan& scan, Vec2 lidar) {
  groups_.clear();
  const std::size_t n = hits_.size();
  const auto linked = [&](const Hit& a, const Hit& b) {
    const double spacing = std::max(a.range, b.range) * scan.angle_increment;
    return b.beam - a.beam <= 2 &&
           distance(a.at, b.at) <= params_.link + params_.link_beams * spacing * static_cast<double>(b.beam - a.beam);
  };
  // is what the next valid beam sees farther away, or nothing?
  const auto is_behind = [&](const Hit& hit, std::ptrdiff_t step) {
    const auto beams = static_cast<std::ptrdiff_t>(scan.ranges.size());
    for (std::ptrdiff_t k = 1; k <= 3; ++k) {
      const auto other =
          static_cast<std::size_t>(((static_cast<std::ptrdiff_t>(hit.beam) + k * step) % beams + beams) % beams);
      const auto range = static_cast<double>(scan.ranges[other]);
      if (range > 0.0) return range > hit.range + params_.stands_free;
    }
    return false;
  };
  for (std::size_t first = 0; first < n;) {
    std::size_t last = first;
    while (last + 1 < n && linked(hits_[last], hits_[last + 1])) ++last;
    const double width = distance(hits_[first].at, hits_[last].at);
    if (width <= params_.widest && is_behind(hits_[first], -1) && is_behind(hits_[last], 1))
      groups_.push_back(group_of(first, last, scan, lidar));
    first = last + 1;
  }
}

PeopleTracker::Group PeopleTracker::group_of(std::size_t first, std::size_t last, const LaserScan& scan,
                                             Vec2 lidar) const {
  Group group;
  group.low = group.high = hits_[first].at;
  double beams = 0.0;
  for (std::size_t i = first; i <= last; ++i) {
    const Vec2 p = hits_[i].at;
    group.center = group.center + p;
    group.low = {std::min(group.low.x, p.x), std::min(group.low.y, p.y)};
    group.high = {std::max(group.high.x, p.x), std::max(group.high.y, p.y)};
    group.moved += hits_[i].moved ? 1 : 0;
    beams += static_cast<double>(hits_[i].beam);
    ++group.hits;
  }
  group.center = (1.0 / group.hits) * group.center;
  group.late = (beams / group.hits - 0.5 * static_cast<double>(scan.ranges.size())) * scan.time_increment;
  // only the near side was seen
  const double depth = 0.75 * std::max(params_.leg_radius, 0.4 * distance(hits_[first].at, hits_[last].at));
  const Vec2 away = group.center - lidar;
  group.center = group.center + (depth / std::max(norm(away), depth)) * away;
  return group;
}

// Two legs near one another are one person's; the nearest pairs first.
void PeopleTracker::merge_legs() {
  const auto is_leg = [this](const Group& g) { return g.blobs == 1 && distance(g.low, g.high) <= params_.leg_width; };
  struct Pair {
    double apart;
    std::size_t a, b;
  };
  std::vector<Pair> pairs;
  for (std::size_t a = 0; a < groups_.size(); ++a) {
    for (std::size_t b = a + 1; b < groups_.size(); ++b) {
      if (!is_leg(groups_[a]) || !is_leg(groups_[b])) continue;
      const double apart = distance(groups_[a].center, groups_[b].center);
      // what moves and what does not belong to different things
      if (apart <= params_.stride && (groups_[a].moved > 0) == (groups_[b].moved > 0)) pairs.push_back({apart, a, b});
    }
  }
  std::ranges::stable_sort(pairs, {}, &Pair::apart);
  for (const Pair& pair : pairs) {
    Group& a = groups_[pair.a];
    Group& b = groups_[pair.b];
    if (a.blobs != 1 || b.blobs != 1) continue;
    a.center = 0.5 * (a.center + b.center);
    a.late = 0.5 * (a.late + b.late);
    a.low = {std::min(a.low.x, b.low.x), std::min(a.low.y, b.low.y)};
    a.high = {std::max(a.high.x, b.high.x), std::max(a.high.y, b.high.y)};
    a.hits += b.hits;
    a.moved += b.moved;
    a.blobs = 2;
    b.blobs = 0;
  }
  std::erase_if(groups_, [](const Group& g) { return g.blobs == 0; });
  taken_.assign(groups_.size(), 0);
}

// Where a person is `t` seconds later, and how surely.
PeopleTracker::Track PeopleTracker::later(Track track, double t) const {
  const double noise = params_.acceleration * params_.acceleration;  // of white acceleration, per second
  track.position = track.position + t * track.velocity;
  track.pp += 2.0 * t * track.pv + t * t * track.vv + noise * t * t * t / 3.0;
  track.pv += t * track.vv + noise * t * t / 2.0;
  track.vv += noise * t;
  return track;
}

void PeopleTracker::predict(Time stamp) {
  const double t = to_seconds(stamp - stamp_);
  if (t <= 0.0) return;
  for (Track& track : tracks_) track = later(track, t);
}

// How far a group is from where a track was as it was seen.
Vec2 PeopleTracker::offset(const Track& track, const Group& group) {
  return group.center - group.late * track.velocity - track.position;
}

// The nearest pairs of track and group first.
void PeopleTracker::assign(Time stamp) {
  struct Pair {
    double off;
    std::size_t track, group;
  };
  std::vector<Pair> pairs;
  for (std::size_t t = 0; t < tracks_.size(); ++t) {
    const double variance = tracks_[t].pp + params_.sigma * params_.sigma;
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      const Vec2 d = offset(tracks_[t], groups_[g]);
      // what has not moved is a person's only if that one was here before
      if (groups_[g].moved == 0 && tracks_[t].id == 0) continue;
      const double penalty = groups_[g].moved == 0 ? params_.unmoved_penalty : 0.0;
      const double off = dot(d, d) / variance + penalty;
      if (off <= params_.gate && norm(d) <= params_.largest_gate) pairs.push_back({off, t, g});
    }
  }
  std::ranges::stable_sort(pairs, {}, &Pair::off);
  for (Track& track : tracks_) ++track.misses;
  for (const Pair& pair : pairs) {
    Track& track = tracks_[pair.track];
    if (track.misses == 0 || taken_[pair.group] != 0) continue;
    const Group& group = groups_[pair.group];
    taken_[pair.group] = 1;
    const double variance = track.pp + params_.sigma * params_.sigma;
    const Vec2 off = offset(track, group);
    track.position = track.position + (track.pp / variance) * off;
    track.velocity = track.velocity + (track.pv / variance) * off;
    track.vv -= track.pv * track.pv / variance;
    track.pv -= track.pp * track.pv / variance;
    track.pp -= track.pp * track.pp / variance;
    track.misses = 0;
    track.seen = stamp;
    if (group.moved > 0) track.moved = stamp;
    ++track.sightings;
    const bool walked =
        distance(track.position, track.began_at) >= params_.walked && norm(track.velocity) >= params_.slowest;
    if (track.id == 0 && track.sightings >= params_.sightings && walked) track.id = ++known_;
  }
}

void PeopleTracker::begin_tracks(Time stamp) {
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const Group& group = groups_[g];
    if (taken_[g] != 0 || group.moved < 2 || 2 * group.moved < group.hits) continue;
    const auto is_here = [&](const Track& track) {
      return distance(track.position, group.center) < params_.same_place;
    };
    if (std::ranges::any_of(tracks_, is_here)) continue;
    Track track;
    track.position = track.began_at = group.center;
    track.pp = params_.sigma * params_.sigma;
    track.vv = params_.first_speed * params_.first_speed;
    track.seen = track.moved = stamp;
    track.sightings = 1;
    tracks_.push_back(track);
  }
}

void PeopleTracker::end_tracks(Time stamp) {
  std::erase_if(tracks_, [&](const Track& track) {
    if (track.id == 0) return track.misses >= params_.misses;
    return stamp - track.seen > params_.unseen || stamp - track.moved > params_.standing;
  });
  // two that have become one: the older stays
  for (std::size_t a = 0; a < tracks_.size(); ++a) {
    for (std::size_t b = a + 1; b < tracks_.size();) {
      const bool same = distance(tracks_[a].position, tracks_[b].position) < 0.5 * params_.same_place;
      if (same && tracks_[a].id == 0) tracks_[a] = tracks_[b];
      if (same) {
        tracks_.erase(tracks_.begin() + static_cast<std::ptrdiff_t>(b));
      } else {
        ++b;
      }
    }
  }
}

std::vector<TrackedPerson> PeopleTracker::people(Time now) const {
  std::vector<TrackedPerson> people;
  const double t = std::max(0.0, to_seconds(now - stamp_));
  for (const Track& track : tracks_) {
    if (track.id == 0) continue;
    const Track then = later(track, t);
    const double pp = then.pp, pv = then.pv, vv = then.vv;
    people.push_back({then.id, then.position, then.velocity, {pp, 0, pv, 0, 0, pp, 0, pv, pv, 0, vv, 0, 0, pv, 0, vv}});
  }
  std::ranges::sort(people, {}, &TrackedPerson::id);
  return people;
}

}  // namespace threewe::perception
