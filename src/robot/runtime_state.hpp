// State of a runtime that its future depends on, and the bookkeeping around it.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "perception/perception.hpp"
#include "robot/pose_history.hpp"
#include "robot/senses.hpp"
#include "robot/world_state.hpp"
#include "safety/approach.hpp"
#include "safety/gate.hpp"
#include "safety/unseen.hpp"
#include "threewe/robot/runtime.hpp"

namespace threewe {

/// A velocity that was asked for, and until when.
struct HeldVelocity {
  Velocity velocity;
  Time until{};
  bool quiet = false;       // part of a control step: its end is no surprise
  bool creep_mode = false;  // asked for
};

/// Everything about one robot that its future depends on. Copying clones the autonomy stack.
struct Runtime::State {
  std::unique_ptr<slam::Localizer> localizer;
  std::unique_ptr<nav::Navigator> navigator;
  std::vector<map::Zone> zones;  // as the navigator has them
  Senses senses;
  perception::Perception perception;
  Duration waited{};    // for sensors at fault, which the navigator does not notice
  Time sensed{};        // when samples were last fetched
  Time last_arrival{};  // of any sample
  slam::PoseEstimate estimate;
  std::optional<HeldVelocity> held;
  safety::GateState gate;
  safety::Sight sight;
  safety::Approach approach;
  PoseHistory poses;
  Velocity requested;
  safety::GateOutput commanded;
  std::vector<SensorHealth> health;  // with programs that localise or drive the robot; empty where there are none

  State(Options autonomy, const perception::PerceptionModel& model)
      : localizer(std::move(autonomy.localizer)),
        navigator(std::move(autonomy.navigator)),
        senses(model.sensors.size()),
        perception(model) {}
  State(const State& other)
      : localizer(other.localizer->clone()),
        navigator(other.navigator->clone()),
        zones(other.zones),
        senses(other.senses),
        perception(other.perception),
        waited(other.waited),
        sensed(other.sensed),
        last_arrival(other.last_arrival),
        estimate(other.estimate),
        held(other.held),
        gate(other.gate),
        sight(other.sight),
        approach(other.approach),
        poses(other.poses),
        requested(other.requested),
        commanded(other.commanded),
        health(other.health) {}
  State& operator=(const State&) = delete;
};

/// A motion in progress and what decides its end.
struct OpenMotion {
  MotionHandle handle;
  std::optional<nav::Goal> goal;  // of the navigator ...
  VelocitySource source;          // ... or what steers in its place
  Time began{};
  std::optional<Time> times_out;
  double distance = 0.0;        // [m] driven, by the robot's own belief
  Duration without_place{};     // that it has waited for a program to say where the robot is
  nav::Decision decision;       // the navigator's latest
  std::string given_up;         // why, when it cannot go on whatever the navigator does
  std::optional<Time> decided;  // to end: as soon as the robot stands and knows where, at the latest soon after
};

struct Runtime::Impl {
  Impl(World& world, backend::RobotPort& port, Options autonomy);

  // what may be done now
  bool healthy() const { return connected && fault.empty(); }
  void require_healthy() const;
  void require_free() const;
  bool looks_with(SensorType type) const;
  std::span<const Vec2> obstacles_in_odom() const;
  const State& reading() const;
  std::optional<std::string> halt();

  // act
  safety::GateOutput gated(Time now);
  Velocity request();
  Velocity wait_for(const SensorHealth& sensor);
  bool out_of_reach() const;
  bool waits_for_its_place();
  Velocity steer();
  nav::Decision steer_by_source();
  MotionHandle begin(std::optional<nav::Goal> goal, VelocitySource source, std::optional<Duration> timeout);
  Velocity held_velocity();
  void listen_to_peers();
  nav::Observation observation() const;

  // sense
  std::vector<Sample> perceive();
  bool moves_a_delegated_pose(const Sample& sample) const;
  void look_around(const Sample& sample);
  void end_motion_if_over();
  bool stands() const;
  bool knows_where_it_ended() const;
  std::pair<Reason, std::string> verdict() const;
  void end_motion(Reason reason, const std::string& detail);
  void end_ready();
  void note_health();
  void warn_of_faults();

  World::Impl& shared() const { return *world.impl_; }
  Time now() const { return world.now(); }

  World& world;
  backend::RobotPort& port;
  const perception::PerceptionModel perception_model;
  const safety::GateModel gate_model;
  const safety::SightModel sight_model;
  const safety::ApproachModel approach_model;
  const State fresh;  // as it was before anything happened
  std::unique_ptr<State> state;
  bool connected = false;
  std::string fault;
  std::optional<OpenMotion> motion;
  std::vector<WaitHandle> ready;  // those who wait for first samples
  std::vector<nav::Peer> peers;   // during a tick

  std::vector<std::pair<std::uint64_t, std::shared_ptr<const Observer>>> observers;
  std::uint64_t observers_made = 0;

  bool warned_of_expiry = false;
  std::string warned_of_link;
  mutable bool warned_of_reads = false;
  mutable int reads = 0;  // at one stamp
  mutable Time reads_stamp{};
};

/// [robot time] that a motion waits for a sensor in trouble before it fails.
inline constexpr Duration kSensorPatience = 10s;
// How long nothing at all may arrive before the robot counts as out of reach: what it was commanded to do then ends.
inline constexpr Duration kLinkPatience = 250ms;

/// A port stops the robot when the runtime falls silent for so long.
inline constexpr Duration kCommandLifetime = 200ms;

}  // namespace threewe
