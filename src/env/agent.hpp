// Agent of a robot in an environment in place of the autonomy stack: newest scan, pose belief, and the gate.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "env/clock.hpp"
#include "models/lidar.hpp"
#include "models/localization_error.hpp"
#include "safety/approach.hpp"
#include "safety/gate.hpp"
#include "safety/unseen.hpp"
#include "sim/model.hpp"
#include "sim/state.hpp"
#include "threewe/env/options.hpp"
#include "threewe/models/localization.hpp"

namespace threewe::env {

/// What all agents of a batch share.
struct AgentModel {
  RobotProfile profile;
  safety::GateModel gate;
  safety::SightModel sight_model;
  safety::ApproachModel approach;
  Localization localization{};
  models::LocalizationSpec localization_model;
  double sight = 0.0;                     ///< [m], points farther from the lidar than this can't concern the gate
  double gate_sight = 0.0;                ///< [m], nor ranges beyond this, while nothing else moves
  double decision_sight = 0.0;            ///< [m] from the base, whatever the gate decides; see `Agent::act`
  double displacement = 0.0;              ///< [m] of a point as it is placed by its beam: what it may come nearer by
  bool scans = false;                     ///< something reads them, see `Clock::scans`
  bool looks_late = false;                ///< scans for the gate are taken when it needs them, while nothing else moves
  bool localizes = false;                 ///< something reads where the robot believes to be
  std::size_t scans_under_way = 0;        ///< at once, at most
  std::vector<models::PointBeams> beams;  ///< that each point of a turn counts for; empty where point i is beam i
};
/// `localizes`: whether something reads where it believes to be.
AgentModel make_agent_model(const Options& options, const Clock& clock, bool localizes);

/// A turn of the lidar: when, and where the robot was.
struct Turn {
  Time end{};
  std::uint64_t number = 0;
  Pose2D odom_at_begin;
  Pose2D odom_at_end;
  std::vector<Pose2D> path;  ///< in truth, step by step, so that its points can be taken later; else empty
};

/// A turn, complete, on its way to the robot.
struct Scan : Turn {
  Time arrives{};
  std::vector<float> ranges;  ///< [m] of its beams; empty if nothing observes them
};

/// Where nothing stands that the lidar could hit, in the scene's frame.
struct OpenDisc {
  Vec2 center;
  double radius = 0.0;  ///< [m]
};

/// Most of the gate's scans show nothing that is near enough to matter. Where nothing else moves, that is known without
/// looking: by how far the nearest thing is from where the robot was. So only the others are taken, afterwards.
class Agent {
 public:
  /// A robot as its episode begins. Keeps its memory. Where no others move, nothing is looked out for that comes
  /// nearer: there is nothing, and looking takes a tenth of a step.
  void begin(const AgentModel& model, bool others_move);

  /// The command for the next control period, from an action in shares of the limits.
  Velocity act(const AgentModel& model, const sim::RobotModel& robot, const sim::RobotState& state,
               const Velocity& action, Time now);
  /// Where the path of the lidar's turn in progress is kept; empty where its points are not taken later.
  std::span<Pose2D> path() { return path_; }
  /// After a step of physics that ended a turn of the lidar, whose points were taken if they were to be observed.
  void end_turn(const AgentModel& model, const sim::RobotModel& robot, const sim::RobotState& state, ScanUse use);
  /// At the end of a control period: what has arrived.
  void perceive(const AgentModel& model, const sim::RobotModel& robot, const sim::RobotState& state, Time now);

  /// Where the robot believes to be, from where it started.
  Pose2D map_from_base(const AgentModel& model, const sim::RobotState& state) const;
  Velocity velocity(const AgentModel& model, const sim::RobotState& state) const;
  /// The newest scan: [m] for each beam of the profile's; nothing before the first.
  std::span<const float> scan() const { return newest() ? newest()->ranges : std::span<const float>(); }
  /// What the newest scan hit [m], from where the robot is now, by its wheels.
  std::vector<Vec2> hits(const AgentModel& model, const sim::RobotState& state) const;

 private:
  void correct(const AgentModel& model, const sim::RobotState& state, Time now);
  void receive(const AgentModel& model, const sim::RobotModel& robot, const sim::RobotState& state);
  bool is_without_gap(const AgentModel& model, const sim::RobotState& state, const Turn& turn) const;
  void place_hits(const AgentModel& model, const Turn& turn, std::span<const float> ranges);
  void look_around(const AgentModel& model, const Turn& turn, std::span<const float> ranges);
  Pose2D odom_from_base(const AgentModel& model, const sim::RobotState& state) const;
  /// Of the scans that have arrived; null before the first.
  const Scan* newest() const { return arrived_ == 0 ? nullptr : &scans_[(arrived_ - 1) % scans_.size()]; }

  // what every step reads comes first, together
  models::LocalizationState localization_;
  Time correction_due_{};  // of the localization; the end of time where it has none
  std::size_t taken_ = 0;  // scans so far
  std::size_t arrived_ = 0;
  std::vector<Scan> scans_;      // a ring
  std::vector<Vec2> obstacles_;  // of the newest scan, in odom, once they are `placed_`
  bool placed_ = true;
  bool others_move_ = true;
  std::vector<Pose2D> path_;  // in truth, of the turn in progress
  safety::Approach approach_;
  safety::Sight sight_;
  safety::GateState gate_;
  Pose2D turn_began_;  // odom_from_base then
  OpenDisc open_;
  double nearest_ = 0.0;          // [m] from where the base was during the newest scan none of those is nearer
  std::vector<Turn> remembered_;  // a ring: those that `sight_` lacks
  std::size_t kept_ = 0;          // of these so far
};

}  // namespace threewe::env
