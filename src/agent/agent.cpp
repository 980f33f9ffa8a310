#include "agent/agent.hpp"

#include <algorithm>
#include <deque>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "agent/skills.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::agent {
namespace {

using language::ReadingOutcome;
using language::Skill;

constexpr std::size_t kPoses = 50;        // that are remembered: a second
constexpr double kCorrected = 0.03;       // [m] by which the map moved at once
constexpr double kCorrectedTurn = 0.015;  // [rad]

struct PoseAt {
  Time time{};
  Pose2D odom_from_base;
};

// An instruction in progress.
struct Run {
  std::vector<language::Step> steps;
  std::size_t next = 0;
  std::unique_ptr<SkillRun> skill;
  Budget budget;
  Time begun{};
  Vec2 last;  // where the robot was at the last update, to add up the distance
};

}  // namespace

struct Agent::Impl {
  Impl(Runtime& runtime, vision::Detector detects, language::Lexicon reads)
      : detector(std::move(detects)),
        lexicon(std::move(reads)),
        body{runtime,
             semantics::SemanticMap(detector.labels(), detector.radii()),
             {},
             runtime.pose().map_from_base().position()} {}

  double now() const { return to_seconds(body.robot.world().now()); }
  void remember(const TickView& view);
  void look();
  void begin_step();
  void end_step(const Outcome& outcome);
  void finish(const std::string& reason, const std::string& detail);
  bool over_budget() const;

  vision::Detector detector;
  language::Lexicon lexicon;
  Body body;
  std::uint64_t observer = 0;
  std::deque<PoseAt> poses;
  std::optional<Time> looked;
  std::optional<Pose2D> map_from_odom;
  std::optional<Run> run;
  std::optional<ExecutionResult> result;
};

Agent::Agent(Runtime& robot, vision::Detector detector, language::Lexicon lexicon)
    : impl_(std::make_unique<Impl>(robot, std::move(detector), std::move(lexicon))) {
  impl_->observer = robot.observe([impl = impl_.get()](const TickView& view) { impl->remember(view); });
}

Agent::~Agent() { impl_->body.robot.unobserve(impl_->observer); }

void Agent::Impl::remember(const TickView& view) {
  poses.push_back({view.now, view.pose.odom_from_base});
  if (poses.size() > kPoses) poses.pop_front();
}

// Takes over what the newest picture shows, from where the camera was as it was taken.
void Agent::Impl::look() {
  if (!body.robot.profile().camera) return;
  const Time time = body.robot.world().now();
  if (looked && time - *looked < kLookPeriod) return;
  const slam::PoseEstimate& pose = body.robot.pose();
  if (pose.lost() || poses.empty()) return;
  looked = time;
  const RGBDImage& image = body.robot.image();
  const Time measured = body.robot.sample(SensorType::camera).measured;
  const auto after = std::ranges::find_if(poses, [&](const PoseAt& at) { return at.time >= measured; });
  const Pose2D odom_from_base = after == poses.end() ? poses.back().odom_from_base : after->odom_from_base;
  if (map_from_odom && (norm(map_from_odom->position() - pose.map_from_odom.position()) > kCorrected ||
                        std::fabs(wrap_angle(map_from_odom->theta - pose.map_from_odom.theta)) > kCorrectedTurn))
    body.map.move(*map_from_odom * odom_from_base, pose.map_from_odom * odom_from_base, time);
  map_from_odom = pose.map_from_odom;

  const auto& camera = *body.robot.profile().camera;
  const Pose2D map_from_camera = pose.map_from_odom * odom_from_base * camera.base_from_camera;
  const auto seen = detector.detect(image.color, image.intrinsics);
  body.map.update({.now = measured,
                   .map_from_camera = map_from_camera,
                   .things = seen,
                   .camera = image.intrinsics,
                   .depth = image.depth,
                   .depth_sigma = camera.depth ? camera.depth->sigma : 0.0},
                  body.robot.map());
  body.coverage.add(body.robot.map(), map_from_camera, camera.horizontal_fov);
  ++body.looks;
  body.looked = measured;
}

void Agent::begin(std::string_view instruction, const Budget& budget) {
  Impl& impl = *impl_;
  if (impl.run) throw SafetyError("an instruction is being executed: wait for it, or cancel it");
  if (impl.body.robot.motion()) throw SafetyError("a motion owns the robot: wait for it, or stop it");
  if (impl.body.robot.estopped()) throw EmergencyStopError("the emergency stop is latched");
  std::vector<std::string> places;
  for (const auto& place : impl.body.map.places()) places.push_back(place.name);
  const language::Reading reading = language::read(instruction, impl.lexicon, places);
  if (const RobotProfile& profile = impl.body.robot.profile(); !profile.camera) {
    const auto blind =
        std::ranges::find_if(reading.steps, [&](const auto& step) { return needs_camera(impl.body, step); });
    if (blind != reading.steps.end()) {
      throw HardwareError(
          fmt::format("robot '{}' has no camera, which {} needs", profile.name, to_string(blind->skill)));
    }
  }
  impl.result = ExecutionResult{};
  impl.run = Run{reading.steps, 0, nullptr, budget, impl.body.robot.world().now(), impl.body.position()};
  switch (reading.outcome) {
    case ReadingOutcome::understood: return;
    case ReadingOutcome::ambiguous:
      return impl.finish("ambiguous", fmt::format("it may mean: {}", fmt::join(reading.meanings, "; or ")));
    case ReadingOutcome::not_understood:
      return impl.finish("not_understood", fmt::format("'{}' is not understood", reading.word));
    case ReadingOutcome::refused:
      return impl.finish("refused", fmt::format("no instruction may override this: {}", to_string(*reading.rule)));
  }
}

void Agent::update() {
  Impl& impl = *impl_;
  impl.look();
  if (!impl.run) return;
  Run& run = *impl.run;
  const Vec2 here = impl.body.position();
  impl.result->distance += norm(here - run.last);
  run.last = here;
  if (impl.over_budget()) {
    if (run.skill) run.skill->cancel();
    return impl.finish("budget",
                       fmt::format("it took more than {} steps or {:g} s", run.budget.steps, run.budget.duration));
  }
  if (!run.skill) impl.begin_step();
  if (!impl.run || !run.skill) return;
  if (const auto outcome = run.skill->update(impl.body)) impl.end_step(*outcome);
}

bool Agent::Impl::over_budget() const {
  return std::cmp_greater_equal(run->next, run->budget.steps) ||
         to_seconds(body.robot.world().now() - run->begun) > run->budget.duration;
}

void Agent::Impl::begin_step() {
  const language::Step& step = run->steps[run->next];
  ExecutedStep& executed = result->steps.emplace_back();
  executed.skill = to_string(step.skill);
  executed.text = to_text(step);
  executed.begun = executed.ended = now();
  for (const auto& [name, value] : language::arguments_of(step))
    executed.arguments.push_back({std::string(name), value});
  try {
    run->skill = begin_skill(body, step);
  } catch (const ContractError& error) {
    end_step({"not_found", error.what()});
  }
}

void Agent::Impl::end_step(const Outcome& outcome) {
  ExecutedStep& step = result->steps.back();
  step.reason = outcome.reason;
  step.detail = outcome.detail;
  step.thing = outcome.thing;
  step.verified = outcome.verified;
  if (body.robot.profile().camera) step.picture = std::get<Picture>(body.robot.sample(SensorType::camera).data);
  step.ended = now();
  run->skill.reset();
  ++run->next;
  if (!outcome.answer.empty()) {
    result->answer = outcome.answer;
    result->verified = outcome.verified;
  }
  const bool more = run->next < run->steps.size();
  // that something was not found is what a question after it says
  const bool answered = more && outcome.reason == "not_found" && run->steps[run->next].skill == Skill::answer;
  if (outcome.reason != "done" && !answered) {
    finish(outcome.reason, outcome.detail);
  } else if (!more) {
    finish("done", {});
  }
}

void Agent::Impl::finish(const std::string& reason, const std::string& detail) {
  result->success = reason == "done";
  result->reason = reason;
  result->detail = detail;
  result->duration = to_seconds(body.robot.world().now() - run->begun);
  run.reset();
}

bool Agent::done() const { return !impl_->run; }

const std::vector<ExecutedStep>& Agent::steps() const {
  if (!impl_->result) throw ContractError("no instruction has begun yet");
  return impl_->result->steps;
}

void Agent::cancel() {
  if (!impl_->run) return;
  if (impl_->run->skill) impl_->run->skill->cancel();
  impl_->finish("cancelled", "");
  impl_->body.robot.stop();
}

const ExecutionResult& Agent::result() const {
  if (impl_->run || !impl_->result) throw ContractError("no instruction has ended yet");
  return *impl_->result;
}

bool Agent::sees(std::uint64_t thing) const {
  const Body& body = impl_->body;
  const auto known = body.map.thing(thing);
  return known && body.looks > 0 && known->last_seen == body.looked;
}

const semantics::SemanticMap& Agent::map() const { return impl_->body.map; }
void Agent::name_place(semantics::Place place) { impl_->body.map.name_place(std::move(place)); }
void Agent::add_places(const std::vector<semantics::Place>& places) {
  semantics::SemanticMap map = impl_->body.map;
  for (const semantics::Place& place : places) map.name_place(place);
  impl_->body.map = std::move(map);
}
const vision::Detector& Agent::detector() const { return impl_->detector; }

ExecutionResult execute_instruction(World& world, Agent& agent, std::string_view instruction, const Budget& budget) {
  constexpr int kTicks = 5;  // between updates
  agent.begin(instruction, budget);
  while (!agent.done()) {
    agent.update();
    for (int i = 0; i < kTicks && !agent.done(); ++i) world.tick();
  }
  return agent.result();
}

}  // namespace threewe::agent
