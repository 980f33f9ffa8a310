// Instruction agent: reads an instruction, makes skills of it, and executes them with the robot's public calls.
// Offline: language, detector and semantic map are the robot's own.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "semantics/semantic_map.hpp"
#include "threewe/language/command.hpp"
#include "threewe/robot/results.hpp"
#include "threewe/robot/runtime.hpp"
#include "threewe/robot/world.hpp"
#include "vision/detector.hpp"

namespace threewe::agent {

/// How long and how far an instruction may take the robot.
struct Budget {
  int steps = 30;           ///< of a plan
  double duration = 900.0;  ///< [s] of robot time
};

using threewe::ExecutedStep;
using threewe::ExecutionResult;

/// Executes instructions on one robot, one at a time, and remembers from one to the next what it has seen. It looks
/// twice a second, from when it is made. It uses what users may call, nothing else: every motion passes the gate.
class Agent {
 public:
  static constexpr Duration kLookPeriod = std::chrono::milliseconds(500);  ///< of robot time between two looks

  /// Of a connected robot, which must outlive it. One without a camera knows of no things.
  explicit Agent(Runtime& robot, vision::Detector detector = vision::Detector::load(),
                 language::Lexicon lexicon = language::Lexicon::load());
  ~Agent();
  Agent(const Agent&) = delete;
  Agent& operator=(const Agent&) = delete;

  /// Begins an instruction. Throws ContractError for a text that is no text, SafetyError while another instruction or
  /// motion runs, EmergencyStopError while the stop is latched, HardwareError for what needs a camera without one.
  void begin(std::string_view instruction, const Budget& budget = {});
  /// Goes on: to be called at least every 0.1 s of robot time, between ticks.
  void update();
  /// Whether nothing is in progress.
  bool done() const;
  /// The steps of the instruction that have begun; the last has no reason while it lasts.
  const std::vector<ExecutedStep>& steps() const;
  /// Ends the instruction as `cancelled` and stops the robot.
  void cancel();
  /// Of the last instruction. Throws ContractError before `done()`.
  const ExecutionResult& result() const;

  /// Whether the newest look shows a thing of its map.
  bool sees(std::uint64_t thing) const;
  /// What it has seen so far, and the places that have names.
  const semantics::SemanticMap& map() const;
  /// Gives a place a name. See SemanticMap::name_place.
  void name_place(semantics::Place place);
  /// Gives all of them their names, or none. Throws ContractError where there would be too many.
  void add_places(const std::vector<semantics::Place>& places);
  /// Its object detector.
  const vision::Detector& detector() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Reads and executes an instruction; robot time goes by until it is done.
ExecutionResult execute_instruction(World& world, Agent& agent, std::string_view instruction,
                                    const Budget& budget = {});

}  // namespace threewe::agent
