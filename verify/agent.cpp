// A robot that executes a drawn instruction offline, with its own detector and autonomy stack:
//
//   verify_agent SEED --false-truth    with the truth as it is, and with a simulator that falsifies it, things and
//                                      names included: by our agent, and by one that peeks; a hash a line
//   verify_agent SEED --speed          in office_v2, robot seconds a second of this process's CPU time
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <memory>
#include <random>
#include <span>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "agent/agent.hpp"
#include "hash.hpp"
#include "number.hpp"
#include "robot/false_truth_world.hpp"
#include "seconds.hpp"
#include "threewe/backend/registry.hpp"
#include "threewe/robot/robot.hpp"

using namespace threewe;

namespace {

using Draw = std::mt19937_64;

constexpr std::array kScenes{"office_v2", "apartment_v1", "dynamic_v1", "warehouse_v1"};
constexpr std::array kKinds{"plant", "chair", "desk", "shelf", "refrigerator", "couch"};
constexpr agent::Budget kBudget{.steps = 30, .duration = 60.0};
constexpr agent::Budget kLongBudget{.steps = 30, .duration = 180.0};

// Of one command after the other, and of what was said and mapped at the end.
class Drives {
 public:
  Drives(World& world, std::string text) : world_(world), agent_(world.robot(0)), text_(std::move(text)) {}
  std::uint64_t hash() {
    Hash hash;
    const auto id = world_.robot(0).observe([&](const TickView& view) {
      const Pose2D pose = view.pose.map_from_base();
      const Velocity& command = view.commanded.command;
      for (const double number : {pose.x, pose.y, pose.theta, command.vx, command.vy, command.omega}) hash.add(number);
    });
    const agent::ExecutionResult result = agent::execute_instruction(world_, agent_, text_, kBudget);
    world_.robot(0).unobserve(id);
    hash.add(std::span(result.reason));
    hash.add(std::span(result.answer));
    for (const semantics::MappedThing& thing : agent_.map().things()) {
      hash.add(thing.position.x);
      hash.add(thing.position.y);
      hash.add(std::span(thing.kinds));
    }
    return hash.value();
  }

 private:
  World& world_;
  agent::Agent agent_;
  std::string text_;
};

std::string drawn_instruction(Draw& draw) {
  const char* kind = kKinds[draw() % kKinds.size()];
  switch (draw() % 6) {
    case 0: return fmt::format("find the {}", kind);
    case 1: return fmt::format("is there a {}?", kind);
    case 2: return fmt::format("look around, then go to the nearest {}", kind);
    case 3: return "explore";
    case 4: return "turn right 30 degrees and move forward 75 cm, then look around and come back";
    default: return fmt::format("explore, then how many {}s are there?", kind);
  }
}

std::unique_ptr<backend::World> make_world(const backend::WorldOptions& options, bool falsified) {
  std::unique_ptr<backend::World> world = backend::make_world("mock", options);
  if (!falsified) return world;
  return std::make_unique<FalseTruthWorld>(std::move(world));
}

// Where the first thing of the scene truly is, in the robot's `map`, as an instruction.
std::string peeked_instruction(World& world) {
  const scene::TruthView& truth = world.truth_service()->truth(0);
  const Pose2D there = inverse(truth.start_pose()) * truth.scene().objects.front().pose;
  return fmt::format("go to ({:.2f}, {:.2f})", there.x, there.y);
}

std::uint64_t drive(const backend::WorldOptions& options, const std::string& text, bool falsified) {
  World world(make_world(options, falsified));
  Robot robot(world);
  return Drives(world, text.empty() ? peeked_instruction(world) : text).hash();
}

int compare_truths(std::uint64_t seed) {
  Draw draw(seed);
  const backend::WorldOptions options{.scene = kScenes[draw() % kScenes.size()], .seed = seed};
  const std::string text = drawn_instruction(draw);
  std::fprintf(stderr, "%s: %s\n", options.scene.c_str(), text.c_str());
  print_hash("truth", drive(options, text, false));
  print_hash("false truth", drive(options, text, true));
  print_hash("truth, peeking at things", drive(options, {}, false));
  print_hash("false truth, peeking at things", drive(options, {}, true));
  return 0;
}

int measure_speed(std::uint64_t seed) {
  Draw draw(seed);
  Robot robot({.seed = seed});
  agent::Agent agent(robot.runtime());
  const Time begun = robot.now();
  const double before = seconds_by(CLOCK_PROCESS_CPUTIME_ID);
  agent::execute_instruction(robot.world(), agent, fmt::format("find the {}", kKinds[draw() % kKinds.size()]),
                             kLongBudget);
  agent::execute_instruction(robot.world(), agent, "explore", kLongBudget);
  const double cpu = seconds_by(CLOCK_PROCESS_CPUTIME_ID) - before;
  std::printf("times %.2f\nmetres %.1f\n", to_seconds(robot.now() - begun) / cpu,
              robot.simulation()->distance_driven());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const auto seed = parse_number(argc == 3 ? argv[1] : "");
  if (seed && std::strcmp(argv[2], "--false-truth") == 0) return compare_truths(*seed);
  if (seed && std::strcmp(argv[2], "--speed") == 0) return measure_speed(*seed);
  std::fputs("usage: verify_agent SEED --false-truth|--speed\n", stderr);
  return 2;
}
