#include "calibration/fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Dense>

#include "calibration/figures.hpp"

namespace threewe::calibration {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kRows = 3;  // of a period: vx, vy, omega
constexpr int kMostIterations = 30;
constexpr int kMostAttempts = 16;    // of an iteration, each damped four times as much as the one before
constexpr double kConverged = 1e-5;  // of the sum of squares
constexpr double kNudge = 1e-3;      // of a figure's doubt, for its derivative

// What is minimised: how far the twin's velocities are from those measured, and its figures from those assumed.
class Misfit {
 public:
  Misfit(const RobotProfile& profile, const Twin& twin, std::span<const ExcitationSequence> sequences,
         std::span<const Track> tracks)
      : profile_(profile),
        twin_(twin),
        manoeuvres_(sequences),
        tracks_(tracks),
        knobs_(knobs(profile)),
        turn_weight_(std::sqrt(profile.body.inertia / profile.body.mass)) {
    assumed_ = VectorXd(static_cast<Eigen::Index>(knobs_.size()));
    for (std::size_t i = 0; i < knobs_.size(); ++i) {
      assumed_[static_cast<Eigen::Index>(i)] = knobs_[i].get(profile.body);
    }
  }

  const std::vector<Knob>& figures() const { return knobs_; }
  const VectorXd& assumed() const { return assumed_; }

  RobotProfile with(const VectorXd& x) const {
    RobotProfile profile = profile_;
    for (std::size_t i = 0; i < knobs_.size(); ++i) knobs_[i].set(profile.body, x[static_cast<Eigen::Index>(i)]);
    return profile;
  }

  VectorXd within_bounds(VectorXd x) const {
    for (std::size_t i = 0; i < knobs_.size(); ++i) {
      double& value = x[static_cast<Eigen::Index>(i)];
      value = std::clamp(value, knobs_[i].low, knobs_[i].high);
    }
    return x;
  }

  // One manoeuvre's residuals behind the other's [m/s].
  VectorXd residuals(const VectorXd& x) const {
    const std::vector<Track> driven = twin_.drive(with(x), manoeuvres_);
    std::vector<double> rows;
    for (std::size_t i = 0; i < tracks_.size(); ++i) {
      for (std::size_t t = 0; t < tracks_[i].velocities.size(); ++t) {
        const Velocity& v = driven[i].velocities[t];
        const Velocity& w = tracks_[i].velocities[t];
        rows.insert(rows.end(), {v.vx - w.vx, v.vy - w.vy, turn_weight_ * (v.omega - w.omega)});
      }
    }
    return Eigen::Map<const VectorXd>(rows.data(), static_cast<Eigen::Index>(rows.size()));
  }

  MatrixXd derivatives(const VectorXd& x) const {
    MatrixXd jacobian;
    for (Eigen::Index i = 0; i < x.size(); ++i) {
      const Knob& knob = knobs_[static_cast<std::size_t>(i)];
      const double step = kNudge * knob.doubt;
      VectorXd up = x;
      VectorXd down = x;
      up[i] = std::min(x[i] + step, knob.high);
      down[i] = std::max(x[i] - step, knob.low);
      const VectorXd change = (residuals(up) - residuals(down)) / (up[i] - down[i]);
      if (i == 0) jacobian.resize(change.size(), x.size());
      jacobian.col(i) = change;
    }
    return jacobian;
  }

  // What was assumed counts as much as a measurement would that is as far off as the assumption may be.
  VectorXd doubts() const {
    VectorXd doubts(assumed_.size());
    for (std::size_t i = 0; i < knobs_.size(); ++i) doubts[static_cast<Eigen::Index>(i)] = knobs_[i].doubt;
    return doubts;
  }

 private:
  const RobotProfile& profile_;
  const Twin& twin_;
  std::span<const ExcitationSequence> manoeuvres_;
  std::span<const Track> tracks_;
  std::vector<Knob> knobs_;
  double turn_weight_;  // [m]
  VectorXd assumed_;
};

struct Optimum {
  VectorXd x;
  MatrixXd jacobian;
  VectorXd residuals;
  double variance;  // of what a manoeuvre says
  VectorXd prior;   // precision of what was assumed, times that variance
};

MatrixXd curvature_of(const Optimum& best) {
  MatrixXd curvature = best.jacobian.transpose() * best.jacobian;
  curvature.diagonal() += best.prior;
  return curvature;
}

// More than one period says the same, as errors last: of a manoeuvre's periods every so many count as independent.
constexpr double kPeriodsThatLast = 10.0;

double variance_of(const VectorXd& residuals) {
  return kPeriodsThatLast * residuals.squaredNorm() / static_cast<double>(residuals.size());
}

Optimum minimise(const Misfit& misfit) {
  Optimum best{misfit.assumed(), {}, misfit.residuals(misfit.assumed()), 0.0, {}};
  double damping = 1e-3;
  for (int iteration = 0; iteration < kMostIterations; ++iteration) {
    best.variance = variance_of(best.residuals);
    best.prior = best.variance * misfit.doubts().cwiseAbs2().cwiseInverse();
    const auto cost = [&](const VectorXd& x, const VectorXd& residuals) {
      const VectorXd off = x - misfit.assumed();
      return residuals.squaredNorm() + best.prior.cwiseProduct(off.cwiseAbs2()).sum();
    };
    best.jacobian = misfit.derivatives(best.x);
    const MatrixXd curvature = curvature_of(best);
    const VectorXd slope =
        best.jacobian.transpose() * best.residuals + best.prior.cwiseProduct(best.x - misfit.assumed());
    const double before = cost(best.x, best.residuals);
    double gained = 0.0;
    for (int attempt = 0; attempt < kMostAttempts && gained == 0.0; ++attempt) {
      const MatrixXd damped = curvature + damping * MatrixXd(curvature.diagonal().asDiagonal());
      const VectorXd x = misfit.within_bounds(best.x - damped.ldlt().solve(slope));
      const VectorXd residuals = misfit.residuals(x);
      if (const double now = cost(x, residuals); now < before) {
        gained = (before - now) / before;
        best.x = x;
        best.residuals = residuals;
      }
      damping *= 4.0;
    }
    damping = std::max(damping / 16.0, 1e-9);
    if (gained < kConverged) break;
  }
  best.jacobian = misfit.derivatives(best.x);
  return best;
}

// Standard deviations: errors within a manoeuvre may belong together in any way, those of two do not.
VectorXd deviations(const Optimum& best, std::span<const Track> tracks) {
  const Eigen::Index count = best.x.size();
  MatrixXd repeatability = MatrixXd::Zero(count, count);
  repeatability.diagonal() = best.variance * best.prior;
  Eigen::Index row = 0;
  for (const Track& track : tracks) {
    const auto rows = static_cast<Eigen::Index>(kRows * track.velocities.size());
    const VectorXd slope = best.jacobian.middleRows(row, rows).transpose() * best.residuals.segment(row, rows);
    for (Eigen::Index i = 0; i < count; ++i) repeatability.col(i) += slope[i] * slope;
    row += rows;
  }
  const MatrixXd inverse = curvature_of(best).ldlt().solve(MatrixXd::Identity(count, count));
  return (inverse * repeatability * inverse).diagonal().cwiseMax(0.0).cwiseSqrt();
}

double seconds_of(std::span<const Track> tracks) {
  std::size_t periods = 0;
  for (const Track& track : tracks) periods += track.velocities.size();
  return static_cast<double>(periods) * to_seconds(kControlPeriod);
}

}  // namespace

Calibration fit(const RobotProfile& profile, const Twin& twin, std::span<const ExcitationSequence> sequences,
                std::span<const Track> tracks, Source source) {
  const RobotProfile start = with_traction(profile);
  const Misfit misfit(start, twin, sequences, tracks);
  const Optimum best = minimise(misfit);
  const VectorXd spread = deviations(best, tracks);

  Calibration calibration;
  calibration.profile = misfit.with(best.x);
  calibration.source = source;
  calibration.seconds = seconds_of(tracks);
  calibration.before = compare(profile, twin.drive(profile, sequences), tracks);
  calibration.after = compare(profile, twin.drive(calibration.profile, sequences), tracks);
  for (Eigen::Index i = 0; i < best.x.size(); ++i) {
    constexpr double kNormal95 = 1.96;
    const Knob& knob = misfit.figures()[static_cast<std::size_t>(i)];
    const double half = kNormal95 * spread[i];
    calibration.figures.push_back(
        {knob.name, misfit.assumed()[i], best.x[i], half, half < kNormal95 * 0.5 * knob.doubt});
  }
  return calibration;
}

}  // namespace threewe::calibration
