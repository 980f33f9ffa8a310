#include "calibration/tracks.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <variant>

#include "core/numbers.hpp"
#include "sim/step.hpp"
#include "threewe/core/time.hpp"
#include "threewe/scene/truth_view.hpp"

namespace threewe::calibration {
namespace {

constexpr Duration kCommandHolds = 200ms;
constexpr Duration kRest = 500ms;  // a robot that was not put down has to stop first

// Velocity by wheels and gyro: the newest of each.
class Feeling {
 public:
  void take(const std::vector<Sample>& samples) {
    for (const Sample& sample : samples) {
      if (const auto* odometry = std::get_if<Odometry>(&sample.data)) wheels_ = odometry->velocity;
      if (const auto* imu = std::get_if<IMUData>(&sample.data)) gyro_ = imu->angular_velocity[2];
    }
  }
  Velocity velocity() const { return {wheels_.vx, wheels_.vy, gyro_.value_or(wheels_.omega)}; }

 private:
  Velocity wheels_;
  std::optional<double> gyro_;
};

void begin(backend::World& world, const ExcitationSequence& sequence) {
  backend::RobotPort& port = world.robot(0);
  if (port.features().can_reset) {
    world.reset({.poses = {sequence.start}});
    return;
  }
  const Time still = world.now() + kRest;
  while (world.now() < still) {
    port.command({}, world.now() + kCommandHolds);
    world.advance_to(world.now() + kControlPeriod);
  }
  port.poll();
}

Track drive(backend::World& world, const ExcitationSequence& sequence) {
  begin(world, sequence);
  backend::RobotPort& port = world.robot(0);
  const backend::TruthService* service = world.truth_service();
  const scene::TruthView* truth = service == nullptr ? nullptr : &service->truth(0);
  const Pose2D start = truth != nullptr ? truth->true_pose() : Pose2D{};
  Feeling feeling;
  Track track;
  for (const Velocity& command : sequence.commands) {
    port.command(command, world.now() + kCommandHolds);
    world.advance_to(world.now() + kControlPeriod);
    feeling.take(port.poll());
    track.velocities.push_back(truth != nullptr ? truth->true_velocity() : feeling.velocity());
    if (truth != nullptr) track.poses.push_back(inverse(start) * truth->true_pose());
  }
  return track;
}

// Nothing but the drive: no noise, and no sensors that would take time.
RobotProfile bare(const RobotProfile& profile) {
  RobotProfile bare = with_noise(profile, NoiseLevel::ideal);
  bare.lidar.reset();
  bare.ultrasonics.reset();
  bare.camera.reset();
  return bare;
}

struct Sums {
  double linear = 0.0;
  double angular = 0.0;
  void add(const Velocity& v) {
    linear += square(v.vx) + square(v.vy);
    angular += square(v.omega);
  }
};

double way_of(const Track& track) {
  double way = 0.0;
  for (std::size_t i = 1; i < track.poses.size(); ++i) {
    way += distance(track.poses[i - 1].position(), track.poses[i].position());
  }
  return way;
}

}  // namespace

std::string_view to_string(Source source) { return source == Source::truth ? "truth" : "sensors"; }

std::vector<Track> drive(backend::World& world, std::span<const ExcitationSequence> sequences) {
  std::vector<Track> tracks;
  tracks.reserve(sequences.size());
  for (const ExcitationSequence& sequence : sequences) tracks.push_back(drive(world, sequence));
  return tracks;
}

Twin::Twin(std::shared_ptr<const scene::Scene> scene, Source like) : scene_(std::move(scene)), like_(like) {}

std::vector<Track> Twin::drive(const RobotProfile& profile, std::span<const ExcitationSequence> sequences) const {
  const auto model = sim::make_model(scene_, {bare(profile)});
  std::vector<sim::RobotState> states;
  std::size_t longest = 0;
  for (const ExcitationSequence& sequence : sequences) {
    states.push_back(sim::begin(*model, 0, sequence.start, 0));
    longest = std::max(longest, sequence.commands.size());
  }

  constexpr int kSteps = static_cast<int>(kControlPeriod / sim::kStep);
  std::vector<Track> tracks(sequences.size());
  std::vector<Velocity> commands(sequences.size());
  for (std::size_t t = 0; t < longest; ++t) {
    for (std::size_t i = 0; i < sequences.size(); ++i) {
      const auto& given = sequences[i].commands;
      commands[i] = t < given.size() ? given[t] : Velocity{};
    }
    for (int k = 0; k < kSteps; ++k) sim::step(*model, states, commands);
    for (std::size_t i = 0; i < sequences.size(); ++i) {
      if (t >= sequences[i].commands.size()) continue;
      const sim::RobotState& state = states[i];
      const Velocity& wheels = state.odometry.reading.velocity;
      const bool true_ones = like_ == Source::truth;
      const double turning = profile.imu ? state.imu.angular_velocity[2] : wheels.omega;
      tracks[i].velocities.push_back(true_ones ? state.velocity : Velocity{wheels.vx, wheels.vy, turning});
      if (true_ones) tracks[i].poses.push_back(inverse(sequences[i].start) * state.pose);
    }
  }
  return tracks;
}

Deviation compare(const RobotProfile& profile, std::span<const Track> tracks, std::span<const Track> reference) {
  Sums apart;
  Sums all;
  Deviation deviation;
  std::size_t ends = 0;
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    for (std::size_t t = 0; t < tracks[i].velocities.size(); ++t) {
      const Velocity& v = tracks[i].velocities[t];
      const Velocity& w = reference[i].velocities[t];
      apart.add({v.vx - w.vx, v.vy - w.vy, v.omega - w.omega});
      all.add(w);
    }
    if (tracks[i].poses.empty() || reference[i].poses.empty()) continue;
    const double off = distance(tracks[i].poses.back().position(), reference[i].poses.back().position());
    const double share = off / way_of(reference[i]);
    deviation.pose += share;
    deviation.farthest_pose = std::max(deviation.farthest_pose, share);
    ++ends;
  }
  const double weight = profile.body.inertia / profile.body.mass;
  deviation.linear = std::sqrt(apart.linear / all.linear);
  deviation.angular = std::sqrt(apart.angular / all.angular);
  deviation.combined = std::sqrt((apart.linear + weight * apart.angular) / (all.linear + weight * all.angular));
  if (ends > 0) deviation.pose /= static_cast<double>(ends);
  return deviation;
}

}  // namespace threewe::calibration
