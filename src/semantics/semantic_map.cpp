#include "semantics/semantic_map.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

#include "core/exact.hpp"
#include "core/names.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::semantics {
namespace {

constexpr std::size_t kMostThings = 500;
constexpr std::size_t kMostPlaces = 1000;
constexpr int kLeastViews = 2;     // of a thing that others are shown
constexpr int kLeastCells = 2;     // of a detection that is taken over
constexpr double kFarthest = 7.0;  // [m] of one
// Standard deviations of where a detection is: a constant and a share of its distance [m].
constexpr double kAlong = 0.10;
constexpr double kAlongShare = 0.14;
constexpr double kAcross = 0.06;
constexpr double kAcrossShare = 0.04;
constexpr double kInside = 0.7;   // of a thing's radius, from its surface to its centre: boxes of 1:1 to 1:2, all sides
constexpr double kShape = 0.25;   // and the standard deviation of that
constexpr double kAgree = 1.5;    // standard deviations between the two ranges up to which both are of the thing
constexpr double kNearest = 0.2;  // [m] in front of the camera, which is the robot itself
constexpr double kGate = 9.21;    // chi-square of two, 99 %
constexpr double kFloor = 0.0016;     // [m^2] variances stay above: views share their errors
constexpr double kLeastAlike = 0.12;  // product of the two kinds' distributions, below which it is another thing
// A view counts as new evidence when the camera has moved or turned by so much.
constexpr double kNewPlace = 0.25;    // [m]
constexpr double kNewHeading = 0.20;  // [rad]
// Views err alike where they are from like viewpoints, and all views of a thing share what makes it look like another.
// Log-probabilities of kinds are kTrust * n / (1 + kShared * n) times the mean of the views' ones, where n counts views
// by how new their viewpoints were; fitted to drives through generated buildings that the detector has not seen.
constexpr double kTrust = 1.2;
constexpr double kShared = 0.5;
constexpr double kLikeBearing = 0.5;  // [rad] standard deviation of the bearing from the thing of like viewpoints
constexpr double kLikeRange = 0.4;    // and of the logarithm of the distance
constexpr double kLeastNew = 0.05;    // of a view
constexpr double kLeastRange = 0.1;   // [m]
constexpr std::size_t kMostViewpoints = 12;  // of a thing, that are remembered
constexpr double kLeastScore = 0.02;         // no view makes a kind impossible
constexpr double kOldColors = 0.9;           // weight of what was seen of the color before
// What is missed: in a narrower view than the camera's, nearer than it can be seen well.
constexpr double kMissBearing = 0.6;  // [rad]
constexpr double kMissNearest = 0.6;  // [m]
constexpr double kMissFarthest = 3.5;
constexpr double kInFront = 0.45;    // [m] short of the thing's centre, up to where the line of sight must be free
constexpr int kMostMisses = 3;       // more than views
constexpr double kApart = 0.8;       // share of a kind's radius within which there is no other
constexpr double kDouble = 0.35;     // [m] within which two of a kind are one
constexpr double kPointPlace = 2.5;  // [m]
constexpr Duration kRecent = std::chrono::seconds(30);

// A covariance after a rotation by an angle [rad].
std::array<double, 3> rotated(const std::array<double, 3>& covariance, double angle) {
  const auto [s, c] = exact::sincos(angle);
  const auto [xx, xy, yy] = covariance;
  return {c * c * xx - 2.0 * s * c * xy + s * s * yy, s * c * (xx - yy) + (c * c - s * s) * xy,
          s * s * xx + 2.0 * s * c * xy + c * c * yy};
}

// A range [m] and its standard deviation; 0 where none was measured.
struct Range {
  double value = 0.0;
  double sigma = 0.0;
};

// Along the camera's axis to the front in the middle of a detection's box, by the lower quartile of what was measured
// there; the quartiles are apart where the thing can be seen through, or is deep.
Range depth_of(const vision::Detection& detection, const View& view) {
  const int third = (detection.x_max - detection.x_min) / 3;
  const int right = std::min(detection.x_max - third, view.camera.width);
  const int bottom = view.depth.empty() ? 0 : std::min(detection.y_max, view.camera.height);
  std::vector<float> measured;
  for (int y = std::max(0, detection.y_min); y < bottom; ++y) {
    const std::size_t row = static_cast<std::size_t>(y) * static_cast<std::size_t>(view.camera.width);
    for (int x = std::max(0, detection.x_min + third); x < right; ++x) {
      const float depth = view.depth[row + static_cast<std::size_t>(x)];
      if (depth > 0.0F) measured.push_back(depth);
    }
  }
  if (measured.empty()) return {};
  std::ranges::sort(measured);
  const auto front = static_cast<double>(measured[measured.size() / 4]);
  const double apart = static_cast<double>(measured[measured.size() * 3 / 4]) - front;
  return {front, apart + view.depth_sigma * front * front};
}

// [m] from a point to what is occupied in a direction; 0 where nothing is up to `farthest`.
double range_to(const map::OccupancyGrid& grid, Vec2 from, Vec2 direction, double farthest) {
  const double step = 0.5 * grid.resolution;
  const auto steps = static_cast<int>((farthest - kNearest) / step);
  for (int i = 0; i < steps; ++i) {
    const double way = kNearest + i * step;
    if (grid.at(grid.cell(from + way * direction)) >= map::OccupancyGrid::kOccupiedThreshold) return way;
  }
  return 0.0;
}

double mahalanobis(Vec2 d, const std::array<double, 3>& a, const std::array<double, 3>& b) {
  const double xx = a[0] + b[0];
  const double xy = a[1] + b[1];
  const double yy = a[2] + b[2];
  const double determinant = xx * yy - xy * xy;
  return (yy * d.x * d.x - 2.0 * xy * d.x * d.y + xx * d.y * d.y) / determinant;
}

void normalize(std::vector<double>& shares) {
  const double sum = std::accumulate(shares.begin(), shares.end(), 0.0);
  for (double& share : shares) share /= sum;
}

double alike(const std::vector<double>& kinds, const std::vector<float>& scores) {
  double same = 0.0;
  double total = 0.0;
  for (std::size_t k = 1; k < kinds.size(); ++k) {
    same += exact::sqrt(kinds[k] * static_cast<double>(scores[k]));
    total += static_cast<double>(scores[k]);
  }
  return total > 0.0 ? same / exact::sqrt(total) : 0.0;
}

// What was seen of another counts as seen of this one, by how often it was.
void absorb(MappedThing& thing, const MappedThing& other) {
  const double share = static_cast<double>(other.views) / std::max(1, thing.views + other.views);
  thing.position = thing.position + share * (other.position - thing.position);
  for (std::size_t c = 0; c < thing.colors.size(); ++c) thing.colors[c] += share * (other.colors[c] - thing.colors[c]);
  if (other.views > thing.views) thing.covariance = other.covariance;
  thing.views += other.views;
  thing.misses = std::min(thing.misses, other.misses);
  thing.last_seen = std::max(thing.last_seen, other.last_seen);
  thing.nearest_view = std::min(thing.nearest_view, other.nearest_view);
}

bool sees(const map::OccupancyGrid& grid, Vec2 from, Vec2 to) {
  const double length = norm(to - from);
  const auto steps = static_cast<int>(std::ceil((length - kInFront) / grid.resolution));
  for (int i = 0; i < steps; ++i) {
    const double way = i * grid.resolution;
    if (grid.at(grid.cell(from + (way / length) * (to - from))) >= map::OccupancyGrid::kOccupiedThreshold) return false;
  }
  return true;
}

}  // namespace

std::size_t MappedThing::kind() const {
  return static_cast<std::size_t>(std::max_element(kinds.begin(), kinds.end()) - kinds.begin());
}
std::size_t MappedThing::color() const {
  return static_cast<std::size_t>(std::max_element(colors.begin(), colors.end()) - colors.begin());
}

SemanticMap::SemanticMap(std::vector<std::string> labels, std::vector<double> radii)
    : labels_(std::move(labels)), radii_(std::move(radii)) {
  radii_.resize(labels_.size(), 0.0);
}

void SemanticMap::Evidence::add(Viewpoint viewpoint, const std::vector<float>& scores) {
  double alike = 0.0;
  for (const Viewpoint& other : from) {
    const double turn = wrap_angle(viewpoint.bearing - other.bearing) / kLikeBearing;
    const double nearer = (viewpoint.log_range - other.log_range) / kLikeRange;
    alike = std::max(alike, exact::exp(-0.5 * (turn * turn + nearer * nearer)));
  }
  const double is_new = std::max(kLeastNew, 1.0 - alike);
  if (is_new > 0.5 || from.empty()) {
    if (from.size() == kMostViewpoints) from.erase(from.begin());
    from.push_back(viewpoint);
  }
  weight += is_new;
  for (std::size_t k = 0; k < log_scores.size(); ++k)
    log_scores[k] += is_new * exact::log(std::max(kLeastScore, static_cast<double>(scores[k])));
}

void SemanticMap::Evidence::add(const Evidence& other) {
  weight += other.weight;
  for (std::size_t k = 0; k < log_scores.size(); ++k) log_scores[k] += other.log_scores[k];
  for (const Viewpoint& viewpoint : other.from) {
    if (from.size() < kMostViewpoints) from.push_back(viewpoint);
  }
}

void SemanticMap::Evidence::weigh(std::vector<double>& kinds) const {
  if (weight == 0.0) return;
  const double trust = kTrust / (1.0 + kShared * weight);  // of the sums, which are `weight` times the means
  const double most = *std::ranges::max_element(log_scores);
  for (std::size_t k = 0; k < kinds.size(); ++k) kinds[k] = exact::exp(trust * (log_scores[k] - most));
  normalize(kinds);
  kinds[0] = 0.0;  // that it is none of them is what is left to 1
}

void SemanticMap::update(const View& view, const map::OccupancyGrid& grid) {
  std::vector<std::uint64_t> seen;
  for (const vision::Detection& detection : view.things) {
    if (detection.cells < kLeastCells || detection.distance > kFarthest) continue;
    const auto [position, covariance, range] = locate(detection, view, grid);
    const std::size_t index = match(position, covariance, detection);
    if (index == things_.size()) {
      if (index == kMostThings) continue;
      add_new(position, covariance, range);
    }
    add_view(index, position, covariance, view, detection);
    seen.push_back(things_[index].id);
  }
  for (MappedThing& thing : things_) {
    if (std::ranges::find(seen, thing.id) != seen.end()) thing.misses = 0;
  }
  count_misses(view, grid);
  merge_doubles();
}

// In the direction that the camera shows. The range is that of the detector, by how the thing looks, and that of its
// surface and its usual radius, each by its variance; the surface alone may be that of what stands behind.
SemanticMap::Located SemanticMap::locate(const vision::Detection& detection, const View& view,
                                         const map::OccupancyGrid& grid) const {
  const Pose2D& camera = view.map_from_camera;
  const double forward = exact::cos(detection.bearing);
  double range = detection.distance / forward;
  const double sigma_across = kAcross + kAcrossShare * range;
  const double sigma_along = kAlong + kAlongShare * range;
  double variance = sigma_along * sigma_along;
  const double direction = camera.theta + detection.bearing;
  const auto [s, c] = exact::sincos(direction);
  Range surface = depth_of(detection, view);
  surface.value /= forward;
  if (surface.value == 0.0)
    surface = {range_to(grid, camera.position(), {c, s}, range + kAgree * sigma_along), grid.resolution};
  const double inside = kInside * radii_[detection.kind];
  const double off = surface.value + inside - range;
  if (surface.value > 0.0 && inside > 0.0 && std::fabs(off) < kAgree * sigma_along) {
    const double shape = kShape * radii_[detection.kind];
    const double variance_of_surface = surface.sigma * surface.sigma + shape * shape;
    const double share = variance / (variance + variance_of_surface);
    range += share * off;
    variance *= 1.0 - share;
  }
  return {camera.position() + range * Vec2{c, s}, rotated({variance, 0.0, sigma_across * sigma_across}, direction),
          range};
}

void SemanticMap::add_new(Vec2 position, const std::array<double, 3>& covariance, double range) {
  MappedThing thing;
  thing.id = next_id_++;
  thing.position = position;
  thing.covariance = covariance;
  thing.kinds.push_back(0.0);
  thing.kinds.resize(labels_.size(), 1.0 / static_cast<double>(labels_.size()));
  thing.nearest_view = range;
  things_.push_back(std::move(thing));
  Evidence& evidence = evidence_.emplace_back();
  evidence.last = {1e9, 0.0, 0.0};
  evidence.log_scores.resize(labels_.size(), 0.0);
}

// The index of the thing that a detection most probably is of; the number of things where it is of none.
std::size_t SemanticMap::match(Vec2 position, const std::array<double, 3>& covariance,
                               const vision::Detection& detection) const {
  std::size_t best = things_.size();
  double nearest = kGate;
  for (std::size_t i = 0; i < things_.size(); ++i) {
    const MappedThing& thing = things_[i];
    const double same = alike(thing.kinds, detection.scores);
    if (same < kLeastAlike) continue;
    const double distance =
        mahalanobis(position - thing.position, thing.covariance, covariance) - 2.0 * exact::log(same);
    if (distance >= nearest) continue;
    nearest = distance;
    best = i;
  }
  return best;
}

void SemanticMap::add_view(std::size_t index, Vec2 position, const std::array<double, 3>& covariance, const View& view,
                           const vision::Detection& detection) {
  MappedThing& thing = things_[index];
  const Pose2D& camera = view.map_from_camera;
  thing.last_seen = view.now;
  thing.nearest_view = std::min(thing.nearest_view, norm(position - camera.position()));
  Evidence& evidence = evidence_[index];
  const Pose2D& last = evidence.last;
  if (norm(camera.position() - last.position()) < kNewPlace &&
      std::fabs(wrap_angle(camera.theta - last.theta)) < kNewHeading)
    return;
  evidence.last = camera;

  if (thing.views > 0) {  // Kalman update
    const auto& p = thing.covariance;
    const double xx = p[0] + covariance[0];
    const double xy = p[1] + covariance[1];
    const double yy = p[2] + covariance[2];
    const double determinant = xx * yy - xy * xy;
    const std::array<double, 4> gain{(p[0] * yy - p[1] * xy) / determinant, (p[1] * xx - p[0] * xy) / determinant,
                                     (p[1] * yy - p[2] * xy) / determinant, (p[2] * xx - p[1] * xy) / determinant};
    const Vec2 off = position - thing.position;
    thing.position = thing.position + Vec2{gain[0] * off.x + gain[1] * off.y, gain[2] * off.x + gain[3] * off.y};
    thing.covariance = {std::max(kFloor, p[0] - gain[0] * p[0] - gain[1] * p[1]),
                        p[1] - gain[0] * p[1] - gain[1] * p[2],
                        std::max(kFloor, p[2] - gain[2] * p[1] - gain[3] * p[2])};
  }
  ++thing.views;
  const Vec2 away = camera.position() - thing.position;
  evidence.add({exact::atan2(away.y, away.x), exact::log(std::max(kLeastRange, norm(away)))}, detection.scores);
  evidence.weigh(thing.kinds);
  const double old = thing.views == 1 ? 0.0 : kOldColors;
  for (std::size_t term = 0; term < thing.colors.size(); ++term) {
    thing.colors[term] = old * thing.colors[term] + (1.0 - old) * static_cast<double>(detection.colors[term]);
  }
}

// Forgets what is gone: it should have been in view, and was not, more often than it was seen.
void SemanticMap::count_misses(const View& view, const map::OccupancyGrid& grid) {
  const Pose2D camera_from_map = inverse(view.map_from_camera);
  for (std::size_t i = 0; i < things_.size();) {
    MappedThing& thing = things_[i];
    const Vec2 at = camera_from_map * thing.position;
    const double range = norm(at);
    const bool in_view = thing.last_seen != view.now && range > kMissNearest && range < kMissFarthest &&
                         std::fabs(exact::atan2(at.y, at.x)) < kMissBearing &&
                         sees(grid, view.map_from_camera.position(), thing.position);
    if (in_view) ++thing.misses;
    if (thing.misses > kMostMisses + thing.views) {
      things_.erase(things_.begin() + static_cast<std::ptrdiff_t>(i));
      evidence_.erase(evidence_.begin() + static_cast<std::ptrdiff_t>(i));
    } else {
      ++i;
    }
  }
}

// Two of a kind that are nearer to each other than things of that size can be are one, seen at two ends.
void SemanticMap::merge_doubles() {
  for (std::size_t i = 0; i < things_.size(); ++i) {
    for (std::size_t j = i + 1; j < things_.size();) {
      MappedThing& one = things_[i];
      const MappedThing& other = things_[j];
      const std::size_t kind = one.kind();
      if (kind != other.kind() || norm(one.position - other.position) >= std::max(kDouble, kApart * radii_[kind])) {
        ++j;
        continue;
      }
      absorb(one, other);
      evidence_[i].add(evidence_[j]);
      evidence_[i].weigh(one.kinds);
      things_.erase(things_.begin() + static_cast<std::ptrdiff_t>(j));
      evidence_.erase(evidence_.begin() + static_cast<std::ptrdiff_t>(j));
    }
  }
}

void SemanticMap::move(const Pose2D& from, const Pose2D& to, Time now) {
  const double since = to_seconds(std::max(kRecent, moved_ ? now - *moved_ : now - Time{}));
  const double turn = wrap_angle(to.theta - from.theta);
  for (std::size_t i = 0; i < things_.size(); ++i) {
    MappedThing& thing = things_[i];
    const double share = std::max(0.0, 1.0 - to_seconds(now - thing.last_seen) / since);
    const Vec2 there = from.position() + share * (to.position() - from.position());
    const Pose2D correction = Pose2D{there.x, there.y, from.theta + share * turn} * inverse(from);
    thing.position = correction * thing.position;
    thing.covariance = rotated(thing.covariance, share * turn);
    evidence_[i].last = correction * evidence_[i].last;
    for (Viewpoint& viewpoint : evidence_[i].from) viewpoint.bearing = wrap_angle(viewpoint.bearing + share * turn);
  }
  moved_ = now;
}

std::vector<MappedThing> SemanticMap::things() const {
  std::vector<MappedThing> seen;
  std::ranges::copy_if(things_, std::back_inserter(seen),
                       [](const MappedThing& thing) { return thing.views >= kLeastViews; });
  return seen;
}

std::optional<MappedThing> SemanticMap::thing(std::uint64_t id) const {
  const auto found = std::ranges::find(things_, id, &MappedThing::id);
  return found == things_.end() || found->views < kLeastViews ? std::nullopt : std::optional(*found);
}

std::vector<MappedThing> SemanticMap::find(const ThingQuery& query) const {
  const std::vector<std::string> colors(vision::color_names().begin(), vision::color_names().end());
  const auto index = [](std::string_view what, const std::vector<std::string>& names, const std::string& name) {
    const auto found = std::ranges::find(names, name);
    if (found == names.end()) throw ContractError(unknown_name(what, name, names));
    return static_cast<std::size_t>(found - names.begin());
  };
  const auto kind = query.kind.empty() ? 0 : index("kind of thing", labels_, query.kind);
  const auto color = query.color.empty() ? 0 : index("color", colors, query.color);
  const Place* place_of = query.place.empty() ? nullptr : &place(query.place);
  const auto fit = [&](const MappedThing& thing) {
    return (query.kind.empty() ? 1.0 : thing.kinds[kind]) * (query.color.empty() ? 1.0 : thing.colors[color]);
  };
  std::vector<MappedThing> found;
  for (const MappedThing& thing : things()) {
    if (!query.kind.empty() && thing.kinds[kind] < query.least_probability) continue;
    if (!query.color.empty() && thing.colors[color] < query.least_color) continue;
    if (place_of == nullptr || contains(*place_of, thing.position)) found.push_back(thing);
  }
  std::ranges::stable_sort(found, std::greater<>(), fit);
  return found;
}

void SemanticMap::name_place(Place place) {
  if (!is_name(place.name)) throw ContractError("name of a place: " + not_a_name(place.name));
  if (place.name == "start") throw ContractError("a place cannot be named 'start': that is where the robot began");
  if (place.polygon.empty() || place.polygon.size() == 2)
    throw ContractError(fmt::format("place '{}' must be one point, or a polygon of three or more", place.name));
  for (const Vec2 point : place.polygon) {
    if (!std::isfinite(point.x) || !std::isfinite(point.y))
      throw ContractError(fmt::format("place '{}' has a point that is not finite", place.name));
  }
  const auto found = std::ranges::find(places_, place.name, &Place::name);
  if (found != places_.end()) {
    *found = std::move(place);
  } else if (places_.size() == kMostPlaces) {
    throw ContractError(fmt::format("there are {} places already", kMostPlaces));
  } else {
    places_.push_back(std::move(place));
  }
}

const Place& SemanticMap::place(std::string_view name) const {
  const auto found = std::ranges::find(places_, name, &Place::name);
  if (found != places_.end()) return *found;
  std::vector<std::string> names;
  for (const Place& place : places_) names.push_back(place.name);
  throw ContractError(unknown_name("place", name, names));
}

Vec2 SemanticMap::center(const Place& place) {
  Vec2 sum;
  for (const Vec2 point : place.polygon) sum = sum + point;
  return (1.0 / static_cast<double>(place.polygon.size())) * sum;
}

bool SemanticMap::contains(const Place& place, Vec2 point) {
  if (place.polygon.size() == 1) return norm(point - place.polygon.front()) <= kPointPlace;
  bool inside = false;  // even-odd rule
  for (std::size_t i = 0, j = place.polygon.size() - 1; i < place.polygon.size(); j = i++) {
    const Vec2 a = place.polygon[i];
    const Vec2 b = place.polygon[j];
    if ((a.y > point.y) != (b.y > point.y) && point.x < (b.x - a.x) * (point.y - a.y) / (b.y - a.y) + a.x)
      inside = !inside;
  }
  return inside;
}

}  // namespace threewe::semantics
