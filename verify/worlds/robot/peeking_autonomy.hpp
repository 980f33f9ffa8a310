// Autonomy stacks that peek at the ground truth: broken twins, which the test of truth isolation has to find out.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "nav/autonomy.hpp"
#include "robot/truth_localizer.hpp"
#include "threewe/backend/world.hpp"
#include "threewe/robot/world.hpp"
#include "threewe/scene/truth_view.hpp"

namespace threewe {

/// Our localizer, but for the velocity, which it takes from the truth.
class TrueVelocityLocalizer final : public slam::Localizer {
 public:
  TrueVelocityLocalizer(std::unique_ptr<slam::Localizer> ours, const scene::TruthView& truth)
      : ours_(std::move(ours)), truth_(truth) {}
  void add(const Sample& sample) override { ours_->add(sample); }
  slam::PoseEstimate estimate(Time now) const override {
    slam::PoseEstimate estimate = ours_->estimate(now);
    estimate.velocity = truth_.true_velocity();
    return estimate;
  }
  const map::OccupancyGrid& map() const override { return ours_->map(); }
  std::uint64_t map_version() const override { return ours_->map_version(); }
  const map::ChangeLog* map_changes() const override { return ours_->map_changes(); }
  std::span<const Vec2> obstacles() const override { return ours_->obstacles(); }
  std::unique_ptr<Localizer> clone() const override {
    return std::make_unique<TrueVelocityLocalizer>(ours_->clone(), truth_);
  }

 private:
  std::unique_ptr<slam::Localizer> ours_;
  const scene::TruthView& truth_;
};

/// Our navigator, but slower the nearer one person is, whom it knows by name.
class NavigatorByName final : public nav::Navigator {
 public:
  NavigatorByName(std::unique_ptr<nav::Navigator> ours, const scene::TruthView& truth)
      : ours_(std::move(ours)), truth_(truth) {}
  void start(const nav::Goal& goal, const nav::Observation& observation) override { ours_->start(goal, observation); }
  nav::Decision step(const nav::Observation& observation) override {
    nav::Decision decision = ours_->step(observation);
    const std::vector<scene::PersonPose> people = truth_.people();
    const scene::PersonPose known = *std::ranges::min_element(people, {}, &scene::PersonPose::name);
    const double away = distance(known.pose.position(), truth_.true_pose().position());
    const double share = away / (away + 1.0);
    const Velocity& wanted = decision.velocity;
    decision.velocity = {share * wanted.vx, share * wanted.vy, share * wanted.omega};
    return decision;
  }
  nav::Progress progress() const override { return ours_->progress(); }
  void set_zones(const std::vector<map::Zone>& zones) override { ours_->set_zones(zones); }
  std::span<const Vec2> path() const override { return ours_->path(); }
  std::unique_ptr<nav::Navigator> clone() const override {
    return std::make_unique<NavigatorByName>(ours_->clone(), truth_);
  }

 private:
  std::unique_ptr<nav::Navigator> ours_;
  const scene::TruthView& truth_;
};

// Each captures the service of the world that it drives in. Robots are made in their order.

inline Autonomy with_true_pose(const backend::TruthService& service) {
  Autonomy autonomy;
  autonomy.localizer = [&service, robot = std::size_t{0}](const auto& profile, const auto& initial) mutable {
    return make_truth_localizer(profile, initial, service.truth(robot++));
  };
  return autonomy;
}

inline Autonomy with_true_velocity(const backend::TruthService& service) {
  Autonomy autonomy;
  autonomy.localizer = [&service, robot = std::size_t{0}](const auto& profile, const auto& initial) mutable {
    return std::make_unique<TrueVelocityLocalizer>(slam::make_localizer(profile, initial), service.truth(robot++));
  };
  return autonomy;
}

inline Autonomy by_name(const backend::TruthService& service) {
  Autonomy autonomy;
  autonomy.navigator = [&service, robot = std::size_t{0}](const auto& profile) mutable {
    return std::make_unique<NavigatorByName>(nav::make_navigator(profile), service.truth(robot++));
  };
  return autonomy;
}

struct PeekingAutonomy {
  const char* at;
  Autonomy (*make)(const backend::TruthService& service);
};
inline constexpr std::array kPeekingAutonomies = {PeekingAutonomy{"the pose", with_true_pose},
                                                  PeekingAutonomy{"the velocity", with_true_velocity},
                                                  PeekingAutonomy{"names of people", by_name}};

}  // namespace threewe
