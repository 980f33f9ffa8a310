#include "backend/mujoco/world/mujoco_world.hpp"

#include <array>
#include <utility>

#include <fmt/format.h>

#include "backend/bytes.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::backend::mujoco {
namespace {

constexpr std::array<char, 8> kSavedAs{'3', 'w', 'e', 'm', 'j', 'c', 'o', '1'};

// What is not there yet is refused, so that nobody takes its absence for a result.
void require_simulated(const WorldOptions& options) {
  const auto refuse = [](const std::string& what) {
    throw ConfigError(fmt::format("backend 'mujoco': {}; backend 'mock' can", what));
  };
  if (options.robots.empty()) throw ConfigError("robots: a world needs at least one");
  if (options.robots.size() > 1) {
    refuse(fmt::format("robots: {} in one world cannot be simulated yet, only one", options.robots.size()));
  }
  if (options.image_size) refuse("image_size: cameras cannot be simulated yet");
  if (options.randomization != "none") {
    refuse(fmt::format("randomization: '{}' cannot be simulated yet", options.randomization));
  }
}

std::shared_ptr<const scene::Scene> load_scene(const WorldOptions& options) {
  require_simulated(options);
  auto scene = std::make_shared<const scene::Scene>(scene::Scene::load(options.scene));
  if (!scene->people.empty()) {
    throw ConfigError(fmt::format(
        "backend 'mujoco': the people of scene '{}' cannot be simulated yet; backend 'mock' can", scene->name));
  }
  return scene;
}

}  // namespace

MujocoWorld::MujocoWorld(const WorldOptions& options)
    : scene_(load_scene(options)),
      noise_(options.noise),
      robot_(make_robot(with_noise(load_profile(options.robots.front()), noise_))),
      physics_(*scene_, robot_.profile),
      port_(*this, load_profile(options.robots.front())) {
  begin({.seed = options.seed, .poses = options.poses});
}

RobotPort& MujocoWorld::robot(std::size_t index) {
  if (index != 0) throw ContractError(fmt::format("robot {}: this world has one", index));
  return port_;
}

void MujocoWorld::advance_to(Time t) {
  if (t < now_) {
    throw ContractError(fmt::format("advance_to({} s): now is {} s", to_seconds(t), to_seconds(now_)));
  }
  while (state_.time() + kStep <= t) {
    step(robot_, port_.command_at(state_.time()), physics_, state_);
    port_.collect();
  }
  now_ = t;
}

// The pose, its heading in (-pi, pi]. Throws unless the robot has room there.
Pose2D MujocoWorld::free_pose(const Pose2D& pose, const char* name) {
  const auto fail = [&](const std::string& what) {
    throw ConfigError(fmt::format("{}: ({}, {}, {}) {}", name, pose.x, pose.y, pose.theta, what));
  };
  if (!is_finite(pose)) fail("is not finite");
  if (pose.x < scene_->min.x || pose.y < scene_->min.y || pose.x > scene_->max.x || pose.y > scene_->max.y) {
    fail(fmt::format("is outside scene '{}', which reaches from ({}, {}) to ({}, {})", scene_->name, scene_->min.x,
                     scene_->min.y, scene_->max.x, scene_->max.y));
  }
  if (const auto hit = physics_.find_collision(pose)) {
    fail(fmt::format("is inside {} of scene '{}'", *hit, scene_->name));
  }
  return {pose.x, pose.y, wrap_angle(pose.theta)};
}

void MujocoWorld::carry(std::size_t robot, const Pose2D& pose) {
  if (robot != 0) throw ContractError(fmt::format("robot {}: this world has one", robot));
  physics_.carry(free_pose(pose, "carry"));
}

void MujocoWorld::reset(const ResetOptions& options) { begin(options); }

void MujocoWorld::begin(const ResetOptions& options) {
  if (options.poses.size() > 1) throw ConfigError(fmt::format("{} start poses for 1 robots", options.poses.size()));
  const Pose2D start =
      free_pose(options.poses.empty() ? scene_->starts.front() : options.poses.front(), "start pose 0");
  physics_.place(start);
  state_ = mujoco::begin(robot_, start, options.seed, options.episode);
  now_ = {};
  port_.reset();
}

std::vector<std::byte> MujocoWorld::save() const {
  ByteWriter bytes;
  bytes.put(kSavedAs);
  bytes.put(scene_->name);
  bytes.put(noise_);
  bytes.put(robot_.profile.name);
  bytes.put(now_);
  bytes.put(state_);
  bytes.put(physics_.state());
  port_.save(bytes);
  return bytes.take();
}

void MujocoWorld::restore(const std::vector<std::byte>& saved) {
  ByteReader bytes(saved);
  const auto expect = [&bytes]<typename T>(const T& expected, const char* what) {
    T found{};
    bytes.get(found);
    if (found != expected) throw ContractError(fmt::format("restore: saved from a world with another {}", what));
  };
  expect(kSavedAs, "format");
  expect(scene_->name, "scene");
  expect(noise_, "noise");
  expect(robot_.profile.name, "hardware profile");

  // everything is read before anything changes
  Time now{};
  RobotState state;
  std::vector<double> physics;
  bytes.get(now);
  bytes.get(state);
  bytes.get(physics);
  if (physics.size() != physics_.state_size()) throw ContractError("restore: these bytes are no saved world");
  MujocoPort::State port = port_.load(bytes);
  bytes.finish();

  now_ = now;
  state_ = state;
  physics_.restore(physics);
  port_.restore(std::move(port));
}

}  // namespace threewe::backend::mujoco
