// Instructions of Robot: the calls that need an agent, which is made at the first of them.
#include <fmt/format.h>

#include "agent/agent.hpp"
#include "semantics/places.hpp"
#include "threewe/core/errors.hpp"
#include "threewe/robot/robot.hpp"

namespace threewe {

agent::Agent& Robot::instructed() {
  if (!agent_) agent_ = std::make_shared<agent::Agent>(*runtime_);
  return *agent_;
}

ExecutionResult Robot::execute_instruction(std::string_view instruction) {
  return execute_instruction(instruction, InstructionOptions{});
}

ExecutionResult Robot::execute_instruction(std::string_view instruction, const InstructionOptions& options) {
  if (options.max_steps < 1) throw ContractError(fmt::format("max_steps must be >= 1, got {}", options.max_steps));
  if (!(options.timeout >= 0.0)) throw ContractError(fmt::format("timeout must be >= 0 s, got {:g}", options.timeout));
  return agent::execute_instruction(*world_, instructed(), instruction, {options.max_steps, options.timeout});
}

void Robot::name_place(const std::string& name) {
  instructed().name_place({.name = name, .polygon = {get_pose().position()}});
}

void Robot::name_place(const std::string& name, const std::vector<Vec2>& polygon) {
  if (polygon.size() < 3)
    throw ContractError(fmt::format("polygon must have three points or more, got {}", polygon.size()));
  instructed().name_place({.name = name, .polygon = polygon});
}

std::vector<semantics::Place> Robot::get_places() { return instructed().map().places(); }
std::vector<semantics::Place> Robot::load_places(const std::filesystem::path& file) {
  std::vector<semantics::Place> places = semantics::load_places(file);
  instructed().add_places(places);
  return places;
}

void Robot::save_places(const std::filesystem::path& file) {
  semantics::save_places(instructed().map().places(), file);
}

std::vector<semantics::MappedThing> Robot::get_things() { return instructed().map().things(); }
const std::vector<std::string>& Robot::get_thing_labels() { return instructed().detector().labels(); }

}  // namespace threewe
