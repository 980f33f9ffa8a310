#include "backend/simulated/simulated_world.hpp"

#include <utility>

#include <fmt/format.h>

#include "backend/simulated/port.hpp"
#include "backend/simulated/truth.hpp"
#include "core/bytes.hpp"
#include "sim/camera.hpp"
#include "sim/placement.hpp"
#include "sim/step.hpp"
#include "threewe/core/errors.hpp"
#include "threewe/scene/scene.hpp"

namespace threewe::backend::simulated {

SimulatedWorld::SimulatedWorld(const WorldOptions& options, std::string format, const EngineFactory& make_engine)
    : format_(std::move(format)),
      noise_(options.noise),
      randomization_(models::load_randomization(options.randomization)) {
  constexpr std::size_t kMostRobots = 100;
  if (options.robots.empty()) throw ConfigError("robots: a world needs at least one");
  if (options.robots.size() > kMostRobots) {
    throw ConfigError(
        fmt::format("robots: {} in one world, at most {} can be simulated", options.robots.size(), kMostRobots));
  }
  std::vector<RobotProfile> profiles;
  std::vector<RobotProfile> simulated;
  if (!options.profiles.empty() && options.profiles.size() != options.robots.size()) {
    throw ConfigError(fmt::format("profiles: {} for {} robots", options.profiles.size(), options.robots.size()));
  }
  for (std::size_t i = 0; i < options.robots.size(); ++i) {
    profiles.push_back(options.profiles.empty() ? load_profile(options.robots[i]) : options.profiles[i]);
    if (options.image_size) profiles.back() = with_image_size(profiles.back(), *options.image_size);
    simulated.push_back(with_noise(profiles.back(), options.noise));
  }
  model_ = sim::make_model(std::make_shared<const scene::Scene>(scene::Scene::load(options.scene)), simulated);
  for (std::size_t i = 0; i < profiles.size(); ++i) {
    ports_.push_back(std::make_unique<Port>(*this, i, profiles[i]));
    truths_.push_back(std::make_unique<Truth>(*this, i));
  }
  engine_ = make_engine(model_);
  begin({.seed = options.seed, .poses = options.poses});
}

SimulatedWorld::~SimulatedWorld() = default;

std::size_t SimulatedWorld::robot_count() const { return ports_.size(); }

RobotPort& SimulatedWorld::robot(std::size_t index) { return *ports_.at(index); }

const scene::TruthView& SimulatedWorld::truth(std::size_t index) const { return *truths_.at(index); }

void SimulatedWorld::advance_to(Time t) {
  if (t < now_) {
    throw ContractError(fmt::format("advance_to({} s): now is {} s", to_seconds(t), to_seconds(now_)));
  }
  while (static_cast<Duration::rep>(steps_ + 1) * sim::kStep <= t) step();
  now_ = t;
}

void SimulatedWorld::step() {
  const Time begin = static_cast<Duration::rep>(steps_) * sim::kStep;
  for (std::size_t i = 0; i < ports_.size(); ++i) commands_[i] = ports_[i]->command_at(begin);
  engine_->step(states_, commands_, people_);
  ++steps_;
  vary();
  for (const auto& port : ports_) port->collect();
}

// Draws anew what changes again and again.
void SimulatedWorld::vary() {
  const Time now = static_cast<Duration::rep>(steps_) * sim::kStep;
  if (randomization_.interval.empty() || now < next_draw_) return;
  const auto& [seed, episode] = std::pair(states_.front().seed, states_.front().episode);
  ++draws_;
  for (std::size_t i = 0; i < ports_.size(); ++i) {
    sim::vary(model_->robots[i], models::draw_variation(randomization_, seed, episode, i, draws_), states_[i]);
    engine_->vary(i, states_[i]);
  }
  next_draw_ = now + models::draw_interval(randomization_, seed, episode, draws_);
}

std::vector<Pose2D> SimulatedWorld::start_poses(const std::vector<Pose2D>& asked) const {
  if (!asked.empty() && asked.size() != ports_.size()) {
    throw ConfigError(fmt::format("{} start poses for {} robots", asked.size(), ports_.size()));
  }
  const std::vector<Pose2D>& poses = asked.empty() ? model_->scene->starts : asked;
  if (poses.size() < ports_.size()) {
    throw ConfigError(fmt::format("scene '{}' names {} start poses, too few for {} robots: give start_poses",
                                  model_->scene->name, poses.size(), ports_.size()));
  }
  std::vector<Pose2D> starts;
  for (std::size_t i = 0; i < ports_.size(); ++i) {
    require_free(i, poses[i], fmt::format("start pose {}", i), starts);
    starts.push_back({poses[i].x, poses[i].y, wrap_angle(poses[i].theta)});
  }
  return starts;
}

// Throws unless a robot has room at a pose, beside the robots that stand at `others`.
void SimulatedWorld::require_free(std::size_t robot, const Pose2D& pose, const std::string& name,
                                  std::span<const Pose2D> others) const {
  const auto fail = [&](const std::string& what) {
    throw ConfigError(fmt::format("{}: ({}, {}, {}) {}", name, pose.x, pose.y, pose.theta, what));
  };
  if (!is_finite(pose)) fail("is not finite");
  const scene::Scene& scene = *model_->scene;
  if (pose.x < scene.min.x || pose.y < scene.min.y || pose.x > scene.max.x || pose.y > scene.max.y) {
    fail(fmt::format("is outside scene '{}', which reaches from ({}, {}) to ({}, {})", scene.name, scene.min.x,
                     scene.min.y, scene.max.x, scene.max.y));
  }
  if (const auto hit = sim::find_collision(*model_, robot, pose)) {
    fail(fmt::format("is inside {} of scene '{}'", *hit, scene.name));
  }
  for (std::size_t other = 0; other < others.size(); ++other) {
    const bool same = other == robot;
    if (!same && sim::robots_overlap(model_->robots[robot], pose, model_->robots[other], others[other])) {
      fail(fmt::format("overlaps robot {}", other));
    }
  }
}

void SimulatedWorld::teleport(std::size_t robot, const Pose2D& pose) {
  std::vector<Pose2D> others;
  for (const sim::RobotState& state : states_) others.push_back(state.pose);
  require_free(robot, pose, "teleport", others);
  const double reach = model_->robots[robot].body.footprint.circumscribed_radius();
  for (const scene::Circle& person : sim::circles_of(*model_, people_)) {
    if (distance(person.center, pose.position()) < person.radius + reach) {
      throw ConfigError(fmt::format("teleport: a person stands at ({}, {})", pose.x, pose.y));
    }
  }
  sim::RobotState& state = states_[robot];
  state.pose = {pose.x, pose.y, wrap_angle(pose.theta)};
  state.velocity = {};
  state.wheel_speeds = {};
  engine_->teleport(robot, state);
}

WorldCapture SimulatedWorld::capture(std::size_t robot) const {
  return {sim::capture_pose(states_, people_, robot), engine_->state()};
}

void SimulatedWorld::reset(const ResetOptions& options) { begin(options); }

void SimulatedWorld::begin(const ResetOptions& options) {
  const std::vector<Pose2D> starts = start_poses(options.poses);
  std::vector<sim::RobotState> states;
  for (std::size_t i = 0; i < ports_.size(); ++i) {
    const auto variation = models::draw_variation(randomization_, options.seed, options.episode, i);
    states.push_back(sim::begin(*model_, i, starts[i], options.seed, options.episode, variation));
  }
  people_ = sim::begin_people(*model_, states, options.seed, options.episode);
  states_ = std::move(states);
  now_ = {};
  steps_ = 0;
  draws_ = 0;
  next_draw_ = models::draw_interval(randomization_, options.seed, options.episode, 0);
  for (const auto& port : ports_) port->reset();
  commands_.assign(ports_.size(), {});
  engine_->place(states_, people_);
}

std::vector<std::byte> SimulatedWorld::save() const {
  ByteWriter bytes;
  bytes.put(format_);
  bytes.put(model_->scene->name);
  bytes.put(noise_);
  bytes.put(randomization_.name);
  bytes.put(std::uint64_t{ports_.size()});
  for (const auto& port : ports_) bytes.put(port->profile().name);
  bytes.put(now_);
  bytes.put(steps_);
  bytes.put(draws_);
  bytes.put(next_draw_);
  for (const sim::RobotState& state : states_) bytes.put(state);
  for (const sim::PersonState& person : people_) bytes.put(person);
  bytes.put(engine_->state());
  for (const auto& port : ports_) port->save(bytes);
  return bytes.take();
}

void SimulatedWorld::restore(const std::vector<std::byte>& state) {
  ByteReader bytes(state, kNotSaved);
  const auto expect = [&bytes]<typename T>(const T& expected, const char* what) {
    T found{};
    bytes.get(found);
    if (found != expected) throw ContractError(fmt::format("restore: saved from a world with another {}", what));
  };
  expect(format_, "format");
  expect(model_->scene->name, "scene");
  expect(noise_, "noise");
  expect(randomization_.name, "randomization");
  expect(std::uint64_t{ports_.size()}, "number of robots");
  for (const auto& port : ports_) expect(port->profile().name, "hardware profile");

  // everything is read before anything changes
  Time now{};
  std::uint64_t steps = 0;
  std::uint64_t draws = 0;
  Time next_draw{};
  std::vector<sim::RobotState> states(ports_.size());
  std::vector<Port::State> ports;
  bytes.get(now);
  bytes.get(steps);
  bytes.get(draws);
  bytes.get(next_draw);
  for (sim::RobotState& robot : states) bytes.get(robot);
  std::vector<sim::PersonState> people(people_.size());
  for (sim::PersonState& person : people) bytes.get(person);
  std::vector<double> physics;
  bytes.get(physics);
  for (const auto& port : ports_) ports.push_back(port->load(bytes));
  bytes.finish();
  engine_->restore(physics, states);

  now_ = now;
  steps_ = steps;
  draws_ = draws;
  next_draw_ = next_draw;
  states_ = std::move(states);
  people_ = std::move(people);
  for (std::size_t i = 0; i < ports.size(); ++i) ports_[i]->restore(std::move(ports[i]));
}

}  // namespace threewe::backend::simulated
