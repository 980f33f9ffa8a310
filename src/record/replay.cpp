// Replay of a journal at the backend's own border: the commands that were executed, and what comes back, bit by bit.
#include <algorithm>
#include <array>
#include <bit>

#include "record/records.hpp"
#include "robot/runtime_state.hpp"
#include "threewe/backend/registry.hpp"
#include "threewe/core/errors.hpp"
#include "threewe/hardware/profile.hpp"
#include "threewe/record/recorder.hpp"
#include "threewe/scene/truth_view.hpp"

namespace threewe::record {
namespace {

bool same_bits(const Pose2D& a, const Pose2D& b) {
  using Bits = std::array<std::uint64_t, 3>;
  return std::bit_cast<Bits>(a) == std::bit_cast<Bits>(b);
}

std::vector<std::byte> bytes_of(const Sample& sample) {
  RecordWriter records;
  records.put(0, sample);
  return records.take();
}

// What one robot did in one tick of the recording.
struct Recording {
  const RecordedRobot* robot = nullptr;
  std::size_t sample = 0;  // the next one

  // Whether those that arrive in the replay are the recorded ones; sensors that were not recorded are left out.
  bool same(const std::vector<Sample>& arrived) {
    const auto recorded = [this](const Sample& s) {
      return std::ranges::any_of(robot->samples, [&](const Sample& other) { return other.sensor == s.sensor; });
    };
    bool all = true;
    for (const Sample& it : arrived) {
      if (!recorded(it)) continue;
      all = all && sample < robot->samples.size() && bytes_of(robot->samples[sample]) == bytes_of(it);
      ++sample;
    }
    return all;
  }
};

// As the world was made, with the profiles that the robots had then: their files may have changed, or be gone.
backend::WorldOptions options_of(const Journal& journal) {
  backend::WorldOptions options = journal.origin()->options;
  for (const RecordedRobot& robot : journal.robots()) {
    if (robot.hardware.empty()) return journal.origin()->options;
    options.profiles.push_back(parse_profile(robot.hardware, robot.profile + ".yaml"));
  }
  return options;
}

}  // namespace

ReplayReport replay(const Journal& journal) {
  const auto& origin = journal.origin();
  if (!origin || journal.initial_state().empty()) {
    throw ContractError("this episode is of no simulated world that can be restored: replay it on a Robot");
  }
  if (journal.robots().size() != origin->options.robots.size()) {
    throw ContractError("this episode has not all robots of its world: the others' commands are not known");
  }
  const auto world = backend::make_world(origin->backend, options_of(journal));
  for (std::size_t i = 0; i < world->robot_count(); ++i) world->robot(i).connect();
  world->restore({journal.initial_state().begin(), journal.initial_state().end()});

  std::vector<Recording> recordings;
  std::size_t ticks = journal.robots().front().ticks.size();
  for (const RecordedRobot& robot : journal.robots()) {
    recordings.push_back({&robot, 0});
    ticks = std::min(ticks, robot.ticks.size());
  }
  ReplayReport report;
  for (std::size_t t = 0; t < ticks; ++t) {
    for (std::size_t i = 0; i < recordings.size(); ++i) {
      world->robot(i).command(recordings[i].robot->ticks[t].executed, world->now() + kCommandLifetime);
    }
    world->advance_to(journal.robots().front().ticks[t].now);
    ++report.ticks;
    for (std::size_t i = 0; i < recordings.size(); ++i) {
      const RecordedTick& tick = recordings[i].robot->ticks[t];
      const bool samples = recordings[i].same(world->robot(i).poll());
      const Pose2D pose = world->truth_service()->truth(i).true_pose();
      report.max_deviation = std::max(report.max_deviation, distance(pose.position(), tick.true_pose.position()));
      if (!(samples && same_bits(pose, tick.true_pose)) && !report.first_difference) report.first_difference = tick.now;
    }
  }
  return report;
}

}  // namespace threewe::record
