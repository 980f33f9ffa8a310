#include "slam/scan_matcher.hpp"
#include "core/exact.hpp"
#include "core/numbers.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

namespace threewe::slam {
namespace {

constexpr int kMaxIterations = 6;
constexpr int kFarthestCells = 3;        // that hits of one surface are looked for in
constexpr double kMaxCellWeight = 12.0;  // hits in one cell beyond this add nothing to its weight

// What the number of hits in a cell makes of their sums.
struct CellScale {
  double place = 0.0;   // of the hits' places, to their mean in cells
  double weight = 0.0;  // of the cell
  double from = 0.0;    // of the directions that they were seen from, to their weighted mean
};

constexpr CellScale scale_of(int count) {
  const double weight = std::min<double>(count, kMaxCellWeight);
  return {1.0 / (256.0 * count), weight, weight / (100.0 * count)};
}

// Those of the usual numbers, since divisions are slow.
constexpr std::array<CellScale, 65> kScales = [] {
  std::array<CellScale, 65> scales{};
  for (std::size_t i = 1; i < scales.size(); ++i) scales[i] = scale_of(static_cast<int>(i));
  return scales;
}();

CellScale known_scale_of(int count) {
  const auto i = static_cast<std::size_t>(count);
  return i < kScales.size() ? kScales[i] : scale_of(count);
}

struct NormalEquations {
  Matrix4 h = Matrix4::Zero();
  Vector4 g = Vector4::Zero();
  Eigen::Matrix2d by_tilt = Eigen::Matrix2d::Zero();  // of the information on the position, what noise in normals makes
  int on_surface = 0;
  int in_free_space = 0;

  void add(const Residual& r, double weight) {
    h.noalias() += weight * r.jacobian * r.jacobian.transpose();
    g.noalias() += (weight * r.value) * r.jacobian;
  }
  void add_tilt(Vec2 along, double weight) {
    const Eigen::Vector2d t(along.x, along.y);
    by_tilt.noalias() += weight * t * t.transpose();
  }
};

// Along a bare corridor the walls tell nothing of the position, but the noise of their normals seems to: it would hold
// the robot back where the map ends. A direction of which not clearly more is known than by such noise counts as not
// observed (solution remapping: Zhang, Kaess & Singh 2016, "On degeneracy of optimization-based state estimation
// problems").
std::optional<Vec2> forget_unobserved(NormalEquations& scan, double observed) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> known(scan.h.topLeftCorner<2, 2>());
  const Eigen::Vector2d least = known.eigenvectors().col(0);
  if (known.eigenvalues()(0) > observed * least.dot(scan.by_tilt * least)) return {};
  const Vector4 direction(least(0), least(1), 0.0, 0.0);
  const Matrix4 rest = Matrix4::Identity() - direction * direction.transpose();
  scan.h = (rest * scan.h * rest).eval();
  scan.g = (rest * scan.g).eval();
  return Vec2{least(0), least(1)};
}

// The residual of a hit at `point` in `map`, hit by a beam that goes along `ray`, `arm` away from the base.
Residual residual_in_map(const Surface& surface, Vec2 direction, Vec2 point, Vec2 ray, Vec2 arm, double range_bias) {
  const double value = dot(direction, point - surface.mean - range_bias * surface.from);
  // a thin post shows its near side to everyone, just as if ranges were short: it tells nothing about them
  const double by_bias = surface.line ? -dot(direction, ray + surface.from) : 0.0;
  return {value, {direction.x, direction.y, cross(arm, direction), by_bias}};
}

NormalEquations linearize(const map::LogOddsMap& map, std::span<const map::Beam> beams, const Placement& at,
                          double scatter, const Params::Matching& params) {
  NormalEquations sum;
  // every beam of a scan shares the errors of map and deskewing, so that a scan knows less than its beams together: the
  // deviation of one residual is set so that the posterior is honest, not to the lidar's
  const double worse = std::max(scatter / params.usual_noise, 1.0);
  const double sigma = worse * params.residual;
  const double width = worse * params.robust_width;
  const auto [s, c] = exact::sincos(at.pose.theta);
  const auto turned = [s = s, c = c](Vec2 p) { return Vec2{c * p.x - s * p.y, s * p.x + c * p.y}; };
  for (const map::Beam& beam : beams) {
    if (!beam.hit) continue;
    const Vec2 arm = turned(beam.origin + (beam.range - at.range_bias) * beam.direction);
    const Vec2 ray = turned(beam.direction);
    const Vec2 point = at.pose.position() + arm;
    const std::optional<Surface> surface = surface_at(map, point, -1.0 * ray, params, scatter);
    if (!surface) {
      sum.in_free_space += map.log_odds(map.grid().cell(point)) < 0 ? 1 : 0;
      continue;
    }
    // what was seen along the same line only repeats itself: a robot that stands would take its own errors for a bias
    const bool tells_bias = norm(ray + surface->from) > params.viewing_angle;
    const auto add = [&](Vec2 direction) {
      Residual r = residual_in_map(*surface, direction, point, ray, arm, at.range_bias);
      if (!tells_bias) r.jacobian(3) = 0.0;
      const double variance = square(sigma) + surface->spread;
      sum.add(r, 1.0 / (variance * square(1.0 + square(r.value / width))));
      return std::fabs(r.value) < params.surface_distance;
    };
    // far walls are hit so sparsely that they look like spots too; only thin things really are some
    bool agrees = false;
    if (surface->line) {
      agrees = add(surface->normal);
      sum.add_tilt({-surface->normal.y, surface->normal.x}, surface->tilt / (square(sigma) + surface->spread));
    } else if (beam.thin) {
      const bool along = add(surface->normal);
      agrees = add({-surface->normal.y, surface->normal.x}) && along;
    } else {
      agrees = distance(point, surface->mean) < params.surface_distance;
    }
    ++(agrees ? sum.on_surface : sum.in_free_space);
  }
  return sum;
}

}  // namespace

std::optional<Surface> surface_at(const map::LogOddsMap& map, Vec2 point, Vec2 back, const Params::Matching& params,
                                  double scatter) {
  const map::OccupancyGrid& grid = map.grid();
  const double r = grid.resolution;
  const map::Cell middle = grid.cell(point);
  const int reach = std::clamp(static_cast<int>(std::ceil(params.reach * scatter / r - 0.5)), 1, kFarthestCells);
  if (middle.x < reach || middle.y < reach || middle.x >= grid.width - reach || middle.y >= grid.height - reach)
    return {};

  // sums over the cells that were seen from this side, around the middle cell, in cells
  double w = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0, yy = 0.0;
  Vec2 from;
  for (int dy = -reach; dy <= reach; ++dy) {
    const map::CellHits* row = &map.hits()[grid.index({middle.x, middle.y + dy})];
    for (int dx = -reach; dx <= reach; ++dx) {
      const map::CellHits& h = row[dx];
      if (h.count == 0) continue;
      const Vec2 sum_from{static_cast<double>(h.sum_from_x), static_cast<double>(h.sum_from_y)};
      const bool from_all_sides = h.sum_from_x == 0 && h.sum_from_y == 0;
      if (dot(sum_from, back) <= 0.0 && !from_all_sides) continue;
      const auto [scale, weight, from_scale] = known_scale_of(h.count);
      const double px = dx + scale * h.sum_x;
      const double py = dy + scale * h.sum_y;
      from = from + from_scale * sum_from;
      w += weight, x += weight * px, y += weight * py;
      xx += weight * px * px, xy += weight * px * py, yy += weight * py * py;
    }
  }
  if (w == 0.0) return {};

  // the line through them: the smaller eigenvalue of their covariance and its direction
  const double mx = x / w;
  const double my = y / w;
  const double cxx = xx / w - mx * mx;
  const double cxy = xy / w - mx * my;
  const double cyy = yy / w - my * my;
  const double half_trace = 0.5 * (cxx + cyy);
  const double root = exact::hypot(0.5 * (cxx - cyy), cxy);
  const double large = half_trace + root;
  const double small = std::max(half_trace - root, 0.0);

  Surface surface;
  surface.mean = grid.center(middle) + r * Vec2{mx, my};
  surface.from = (1.0 / w) * from;
  surface.spread = small * r * r;
  surface.line = large * r * r > square(params.spot_size);
  surface.tilt = std::max(surface.spread, square(params.usual_noise)) / (w * large * r * r);
  // (c - small I) has rows along the other eigenvector; the longer one is the better conditioned
  Vec2 along = cxx >= cyy ? Vec2{cxx - small, cxy} : Vec2{cxy, cyy - small};
  const double length = norm(along);
  surface.normal = length > 0.0 ? Vec2{-along.y / length, along.x / length} : Vec2{1.0, 0.0};
  return surface;
}

Residual residual(const Surface& surface, Vec2 direction, const Placement& at, const map::Beam& beam_in_base) {
  const Vec2 ray = rotate(beam_in_base.direction, at.pose.theta);
  const Vec2 arm = rotate(beam_in_base.origin, at.pose.theta) + (beam_in_base.range - at.range_bias) * ray;
  return residual_in_map(surface, direction, at.pose.position() + arm, ray, arm, at.range_bias);
}

Match match_scan(const map::LogOddsMap& map, std::span<const map::Beam> beams, const Placement& prior,
                 const Matrix4& prior_information, const Pose2D& start, double scatter, Directions directions,
                 const Params::Matching& params) {
  Match match;
  match.at = {start, prior.range_bias};
  for (int i = 0; i < kMaxIterations; ++i) {
    NormalEquations scan = linearize(map, beams, match.at, scatter, params);
    if (directions == Directions::observed) match.unobserved = forget_unobserved(scan, params.observed);
    const Pose2D& pose = match.at.pose;
    const Vector4 off{pose.x - prior.pose.x, pose.y - prior.pose.y, wrap_angle(pose.theta - prior.pose.theta),
                      match.at.range_bias - prior.range_bias};
    match.scan_information = scan.h;
    match.information = scan.h + prior_information;
    match.known_hits = scan.on_surface + scan.in_free_space;
    match.agreement = match.known_hits > 0 ? static_cast<double>(scan.on_surface) / match.known_hits : 1.0;

    const Vector4 step = -match.information.inverse() * (scan.g + prior_information * off);
    match.at = {{pose.x + step(0), pose.y + step(1), wrap_angle(pose.theta + step(2))}, match.at.range_bias + step(3)};
    if (std::fabs(step(0)) + std::fabs(step(1)) < 2e-4 && std::fabs(step(2)) < 1e-4) break;
  }
  return match;
}

Matrix4 free_prior(const Params::Matching& params) {
  return Vector4(1.0 / square(params.free_position), 1.0 / square(params.free_position),
                 1.0 / square(params.free_heading), 1.0 / square(params.free_bias))
      .asDiagonal();
}

Pose2D search_pose(const map::LogOddsMap& map, std::span<const map::Beam> beams, const Pose2D& center,
                   const SearchWindow& window) {
  constexpr double kHeadingStep = exact::kPi / 180.0;
  constexpr std::size_t kEvery = 3;  // beams tried
  const map::OccupancyGrid& grid = map.grid();
  const int headings = static_cast<int>(window.heading / kHeadingStep);
  const int cells = static_cast<int>(window.position / grid.resolution);

  Pose2D best = center;
  int best_score = -1;
  int best_distance = 0;
  std::vector<map::Cell> hits;
  for (int turn = -headings; turn <= headings; ++turn) {
    const Pose2D turned{center.x, center.y, wrap_angle(center.theta + turn * kHeadingStep)};
    const auto [sin, cos] = exact::sincos(turned.theta);
    hits.clear();
    for (std::size_t i = 0; i < beams.size(); i += kEvery) {
      if (!beams[i].hit) continue;
      const Vec2 hit = beams[i].origin + beams[i].range * beams[i].direction;
      hits.push_back(grid.cell(turned.position() + Vec2{cos * hit.x - sin * hit.y, sin * hit.x + cos * hit.y}));
    }
    for (int dy = -cells; dy <= cells; ++dy) {
      for (int dx = -cells; dx <= cells; ++dx) {
        int score = 0;
        for (const map::Cell c : hits) score += map.log_odds({c.x + dx, c.y + dy}) > 0 ? 1 : 0;
        const int distance = dx * dx + dy * dy + turn * turn;
        if (score < best_score || (score == best_score && distance >= best_distance)) continue;
        best_score = score;
        best_distance = distance;
        best = {turned.x + dx * grid.resolution, turned.y + dy * grid.resolution, turned.theta};
      }
    }
  }
  return best;
}

}  // namespace threewe::slam
