// An honest world behind a decorator that breaks one thing: what the conformance checks must catch.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "threewe/backend/registry.hpp"
#include "threewe/scene/truth_view.hpp"

namespace threewe::backend::testing {

/// What a faulty world does instead. Where a function is empty, it is honest.
struct Fault {
  std::function<void(WorldOptions&)> options{};  ///< before the world is made
  std::function<void(Features&, bool connected)> features{};
  std::function<void(RobotPort&)> connect{};
  std::function<void(RobotPort&)> disconnect{};
  bool polls_unconnected = false;                               ///< `poll` gives nothing instead of throwing
  std::function<void(std::vector<Sample>&, World&)> samples{};  ///< changes what `poll` gives
  std::function<void(RobotPort&, Velocity, Time valid_until)> command{};
  std::function<Time(Time)> now{};
  std::function<void(World&, Time)> advance{};  ///< the honest `advance_to` is then the fault's to call
  std::function<void(World&, const ResetOptions&)> reset{};
  std::function<std::vector<std::byte>(World&)> save{};
  std::function<void(World&, const std::vector<std::byte>&)> restore{};
  std::function<Pose2D(Pose2D)> true_pose{};
  std::function<Velocity(Velocity)> true_velocity{};
  std::function<double(double)> distance_driven{};
  std::function<double(double)> collision_speed{};
  std::function<Pose2D(Pose2D)> free_pose{};
  std::function<double(double)> geodesic{};
};

class FaultyTruth : public scene::TruthView {
 public:
  FaultyTruth(const TruthView& truth, const Fault& fault) : truth_(truth), fault_(fault) {}
  const scene::Scene& scene() const override { return truth_.scene(); }
  Pose2D true_pose() const override { return changed(fault_.true_pose, truth_.true_pose()); }
  Velocity true_velocity() const override { return changed(fault_.true_velocity, truth_.true_velocity()); }
  Pose2D start_pose() const override { return truth_.start_pose(); }
  double max_collision_speed() const override { return changed(fault_.collision_speed, truth_.max_collision_speed()); }
  double distance_driven() const override { return changed(fault_.distance_driven, truth_.distance_driven()); }
  std::vector<scene::PersonPose> people() const override { return truth_.people(); }
  Pose2D sample_free_pose(std::uint64_t seed) const override {
    return changed(fault_.free_pose, truth_.sample_free_pose(seed));
  }
  SemanticImage look(const CameraIntrinsics& camera, const Pose2D& pose, double height,
                     bool with_itself) const override {
    return truth_.look(camera, pose, height, with_itself);
  }
  double range(const Pose2D& pose, double height) const override { return truth_.range(pose, height); }
  double geodesic(Vec2 a, Vec2 b) const override { return changed(fault_.geodesic, truth_.geodesic(a, b)); }

 private:
  template <typename T>
  static T changed(const std::function<T(T)>& change, T value) {
    return change ? change(value) : value;
  }
  const TruthView& truth_;
  const Fault& fault_;
};

class FaultyWorld : public World, private RobotPort, private TruthService {
 public:
  FaultyWorld(std::unique_ptr<World> honest, Fault fault) : honest_(std::move(honest)), fault_(std::move(fault)) {
    if (const TruthService* service = honest_->truth_service()) truth_.emplace(service->truth(0), fault_);
  }

  std::size_t robot_count() const override { return 1; }
  RobotPort& robot(std::size_t) override { return *this; }
  const TruthService* truth_service() const override { return truth_ ? this : nullptr; }
  Time now() const override { return fault_.now ? fault_.now(honest_->now()) : honest_->now(); }
  void advance_to(Time t) override { fault_.advance ? fault_.advance(*honest_, t) : honest_->advance_to(t); }
  void reset(const ResetOptions& options) override {
    fault_.reset ? fault_.reset(*honest_, options) : honest_->reset(options);
  }
  std::vector<std::byte> save() const override { return fault_.save ? fault_.save(*honest_) : honest_->save(); }
  void restore(const std::vector<std::byte>& state) override {
    fault_.restore ? fault_.restore(*honest_, state) : honest_->restore(state);
  }

 private:
  RobotPort& port() const { return honest_->robot(0); }
  const Features& features() const override {
    features_ = port().features();
    if (fault_.features) fault_.features(features_, connected_);
    return features_;
  }
  const RobotProfile& profile() const override { return port().profile(); }
  void connect() override {
    fault_.connect ? fault_.connect(port()) : port().connect();
    connected_ = true;
  }
  void disconnect() override {
    fault_.disconnect ? fault_.disconnect(port()) : port().disconnect();
    connected_ = false;
  }
  std::vector<Sample> poll() override {
    if (fault_.polls_unconnected && !connected_) return {};
    std::vector<Sample> samples = port().poll();
    if (fault_.samples) fault_.samples(samples, *honest_);
    return samples;
  }
  void command(const Velocity& velocity, Time valid_until) override {
    fault_.command ? fault_.command(port(), velocity, valid_until) : port().command(velocity, valid_until);
  }
  const scene::TruthView& truth(std::size_t) const override { return *truth_; }

  std::unique_ptr<World> honest_;
  Fault fault_;
  bool connected_ = false;
  mutable Features features_;
  std::optional<FaultyTruth> truth_;
};

}  // namespace threewe::backend::testing
