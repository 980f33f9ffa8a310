#include "threewe/robot/world.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

#include <fmt/format.h>

#include "core/bounds.hpp"
#include "nav/autonomy.hpp"
#include "robot/delegated_localizer.hpp"
#include "robot/delegated_navigator.hpp"
#include "robot/runtime_state.hpp"
#include "robot/truth_localizer.hpp"
#include "robot/world_state.hpp"
#include "threewe/backend/registry.hpp"
#include "threewe/core/errors.hpp"

namespace threewe {
namespace {

// Only here, where the world is held, a localizer is given the truth, and only where the options say so.
std::unique_ptr<slam::Localizer> make_localizer(const Autonomy& autonomy, backend::RobotPort& port,
                                                const slam::InitialState& initial, const backend::TruthService* truths,
                                                std::size_t robot) {
  const RobotProfile& profile = port.profile();
  if (autonomy.localizer) return autonomy.localizer(profile, initial);
  const std::string name = autonomy_with(autonomy.localization).localization;  // throws for another
  if (name == "slam") return slam::make_localizer(profile, initial);
  if (name != "truth") {
    if (initial.map) throw ConfigError(fmt::format("map: with localization '{}' the map is the one that it has", name));
    return make_delegated_localizer(profile, name, port.delegate_localization(name, initial.map_from_start));
  }
  if (truths != nullptr) return make_truth_localizer(profile, initial, truths->truth(robot));
  throw ContractError("localization 'truth' needs a simulator that states it; unknown is where robot '" + profile.name +
                      "' truly is on this backend");
}

std::unique_ptr<nav::Navigator> make_navigator(const Autonomy& autonomy, backend::RobotPort& port) {
  if (autonomy.navigator) return autonomy.navigator(port.profile());
  auto own = nav::make_navigator(port.profile());
  if (autonomy.navigation == "own") return own;
  return make_delegated_navigator(autonomy.navigation, port.delegate_navigation(autonomy.navigation), std::move(own));
}

Runtime::Options make_autonomy(const Autonomy& autonomy, backend::World& world, std::size_t robot,
                               const slam::InitialState& initial) {
  const RobotProfile& profile = world.robot(robot).profile();
  if (initial.map && !profile.lidar) {
    throw HardwareError("robot '" + profile.name + "' has no sensor 'lidar', which finding its place in a map needs");
  }
  return {make_localizer(autonomy, world.robot(robot), initial, world.truth_service(), robot),
          make_navigator(autonomy, world.robot(robot))};
}

std::string size_of_pictures(const RobotProfile& profile) {
  return profile.camera ? fmt::format("{} x {}", profile.camera->width, profile.camera->height) : "none";
}

// Throws unless a state of a world made in one way can go on in a world made in another.
void require_like(const WorldSetup& saved, const WorldSetup& ours) {
  const auto fail = [](const std::string& what) {
    throw ContractError(fmt::format("restore: saved from a world with {}", what));
  };
  if (saved.localization != ours.localization) {
    fail(fmt::format("localization '{}', this one has '{}'", saved.localization, ours.localization));
  }
  const bool same_map = saved.map && ours.map ? *saved.map == *ours.map : saved.map == ours.map;
  if (!same_map) fail("another map");
  if (saved.initial_poses != ours.initial_poses) fail("another initial_pose");
  for (std::size_t i = 0; i < ours.cameras.size(); ++i) {
    if (saved.cameras[i] == ours.cameras[i]) continue;
    fail(fmt::format("pictures of {} px of robot {}, this one has {}", saved.cameras[i], i, ours.cameras[i]));
  }
}

World::Options options_of(const RobotOptions& o) {
  World::Options options;
  options.backend = o.backend;
  options.robots = {o.hardware};
  options.scene = o.scene;
  options.noise = o.noise;
  options.seed = o.seed;
  options.realtime = o.realtime;
  options.autonomy = o.autonomy;
  options.image_size = o.image_size;
  options.randomization = o.randomization;
  options.map = o.map;
  if (o.start_pose) options.poses = {*o.start_pose};
  if (o.initial_pose) options.initial_poses = {*o.initial_pose};
  return options;
}

// True for as long as it lives, whatever is thrown.
class Ticking {
 public:
  explicit Ticking(bool& flag) : flag_(flag) { flag_ = true; }
  ~Ticking() { flag_ = false; }
  Ticking(const Ticking&) = delete;
  Ticking& operator=(const Ticking&) = delete;

 private:
  bool& flag_;
};

}  // namespace

struct World::Snapshot {
  Time now{};
  std::vector<std::byte> backend;
  std::vector<std::shared_ptr<const Runtime::State>> robots;
  WorldSetup setup;
};

World::World(const Options& options)
    : World(backend::make_world(options.backend, options), options.realtime, options.autonomy, options.initial_poses,
            options.map) {
  impl_->seed = options.seed;
  impl_->origin = {options.backend, options};
}

World::World(const RobotOptions& robot) : World(options_of(robot)) {}

World::World(std::unique_ptr<backend::World> backend, bool realtime, const Autonomy& autonomy,
             const std::vector<Pose2D>& initial_poses, const std::shared_ptr<const map::OccupancyGrid>& map)
    : impl_(std::make_unique<Impl>()) {
  impl_->backend = std::move(backend);
  impl_->now = impl_->backend->now();
  impl_->paced = realtime;
  impl_->setup = {autonomy.localization, map, initial_poses, {}};
  impl_->autonomy = autonomy;
  if (initial_poses.size() > impl_->backend->robot_count()) {
    throw ConfigError("there are " + std::to_string(initial_poses.size()) + " initial_poses for " +
                      std::to_string(impl_->backend->robot_count()) + " robots");
  }
  if (map) check_bounds(*map);
  if (map && map->data.empty()) throw ContractError("map must have cells");
  impl_->one_map_frame = initial_poses.size() > 1 && initial_poses.size() == impl_->backend->robot_count();
  for (std::size_t i = 0; i < impl_->backend->robot_count(); ++i) {
    backend::RobotPort& port = impl_->backend->robot(i);
    impl_->lockstep = impl_->lockstep && port.features().lockstep;
    slam::InitialState initial{map, {}};
    if (i < initial_poses.size()) {
      const Pose2D& pose = initial_poses[i];
      check_bounds("initial_pose", pose);
      initial.map_from_start = pose;
    }
    impl_->setup.cameras.push_back(size_of_pictures(port.profile()));
    impl_->robots.push_back(
        std::make_unique<Runtime>(*this, port, make_autonomy(autonomy, *impl_->backend, i, initial)));
  }
}

// The robots go first: they end their motions, and their waits are ended by the rest of the world.
World::~World() { impl_->robots.clear(); }

std::size_t World::robot_count() const { return impl_->robots.size(); }

Runtime& World::robot(std::size_t index) { return const_cast<Runtime&>(std::as_const(*this).robot(index)); }

const Runtime& World::robot(std::size_t index) const {
  if (index < robot_count()) return *impl_->robots[index];
  throw ContractError("no robot " + std::to_string(index) + " in a world of " + std::to_string(robot_count()));
}

const backend::TruthService* World::truth_service() { return impl_->backend->truth_service(); }

Time World::now() const { return impl_->now; }
const Autonomy& World::autonomy() const { return impl_->autonomy; }
const std::optional<World::Origin>& World::origin() const { return impl_->origin; }
std::uint64_t World::seed() const { return impl_->seed; }

std::optional<Pose2D> World::scene_from_map(std::size_t robot) {
  const backend::TruthService* service = truth_service();
  if (service == nullptr) return {};
  const Pose2D start = service->truth(robot).start_pose();
  const auto& [localization, map, initial_poses, cameras] = impl_->setup;
  if (robot < initial_poses.size()) return start * inverse(initial_poses[robot]);
  return map ? std::nullopt : std::optional(start);
}

void World::tick() {
  impl_->require_no_tick();
  if (held()) throw ContractError("robot time stands still while a `thinking` block is open");
  if (!impl_->broken.empty()) throw ConnectionError(impl_->broken);
  if (impl_->paced && impl_->lockstep) impl_->pacer.wait(now());

  {
    const Ticking ticking(impl_->ticking);
    for (const auto& robot : impl_->robots) robot->act(now());
    if (impl_->advance()) {
      for (const auto& robot : impl_->robots) robot->sense(now());
      impl_->waits.end_due(now());
    }
  }

  if (!impl_->broken.empty()) throw ConnectionError(impl_->broken);
  if (impl_->observer_error) std::rethrow_exception(std::exchange(impl_->observer_error, nullptr));
}

Time World::Impl::current() const {
  return lockstep ? now : std::max(now, backend->now() / kControlPeriod * kControlPeriod);
}

// One period in lockstep; in real time the next multiple of it, so that a late tick does not make all later ones late.
bool World::Impl::advance() {
  Time next = now + kControlPeriod;
  try {
    next = std::max(next, current());
    backend->advance_to(next);
  } catch (const std::exception& error) {
    broken = std::string("the world stopped: ") + error.what();
    for (const auto& robot : robots) robot->fail(broken);
    return false;
  }
  now = next;
  return true;
}

bool World::run(Duration wall) {
  const auto end = RealTimePacer::Clock::now() + wall;
  do {
    if (impl_->waits.has_finished()) return true;
    if (held() || !(has_pending() || realtime())) return false;
    const Duration left = std::max<Duration>(Duration::zero(), end - RealTimePacer::Clock::now());
    if (due() > left) {
      std::this_thread::sleep_for(left);
      return false;
    }
    tick();
  } while (RealTimePacer::Clock::now() < end);
  return impl_->waits.has_finished();
}

void World::wait(const WaitHandle& wait) {
  while (!wait->done()) {
    impl_->require_possible(wait);
    tick();
  }
  impl_->waits.take(wait);
}

// Time can neither go by nor jump while an observer is called with it, and half a tick is no state to go back to.
void World::Impl::require_no_tick() const {
  if (ticking) throw ContractError("an observer can neither wait nor reset nor save nor restore");
}

// Throws for what could only be waited for in vain.
void World::Impl::require_possible(const WaitHandle& wait) {
  if (!waits.contains(wait)) throw ContractError("this wait is of another world, or was forgotten");
  if (holds > 0 && lockstep) throw ContractError("a wait inside a `thinking` block can never end: wait after it");
  if (std::none_of(robots.begin(), robots.end(), [](const auto& robot) { return robot->connected(); })) {
    throw ConnectionError("no robot of this world is connected; call connect() first");
  }
}

void World::settle() {
  for (const auto& robot : impl_->robots) {
    if (robot->connected()) wait(robot->ready());
  }
}

void World::disconnect() {
  std::exception_ptr error;
  for (const auto& robot : impl_->robots) {
    try {
      robot->disconnect();
    } catch (...) {
      error = std::current_exception();  // the others are to stop nonetheless
    }
  }
  if (error) std::rethrow_exception(error);
}

WaitHandle World::sleep(Duration duration) { return impl_->begin(duration, WaitList::Kind::sleep); }
WaitHandle World::alarm(Duration duration) { return impl_->begin(duration, WaitList::Kind::alarm); }

WaitHandle World::Impl::begin(Duration duration, WaitList::Kind kind) {
  if (duration < Duration::zero()) throw ContractError("a wait cannot take a negative time");
  auto wait = std::make_shared<Wait>();
  waits.add(wait, kind, now + duration);
  waits.end_due(now);
  return wait;
}

void World::forget(const WaitHandle& wait) { impl_->waits.forget(wait); }
std::vector<WaitHandle> World::take_finished() { return impl_->waits.take_all(); }
bool World::has_pending() const { return impl_->waits.has_pending(); }
bool World::realtime() const { return impl_->paced || !impl_->lockstep; }

Duration World::due() const {
  if (impl_->lockstep) return impl_->paced ? impl_->pacer.due(now()) : Duration::zero();
  return std::max(Duration::zero(), now() + kControlPeriod - impl_->backend->now());
}

void World::open_hold() { ++impl_->holds; }

WaitHandle World::close_hold(Duration charge) {
  if (impl_->holds == 0) throw ContractError("no hold is open");
  if (charge < Duration::zero()) throw ContractError("thinking cannot take a negative time");
  --impl_->holds;
  return sleep(impl_->lockstep ? charge : Duration::zero());
}

bool World::held() const { return impl_->holds > 0 && impl_->lockstep; }

void World::Impl::begin_anew_at(Time time) {
  waits.begin_anew(time - now);
  now = time;
  pacer.forget();
  broken.clear();
}

void World::reset(const backend::ResetOptions& options) {
  impl_->require_no_tick();
  impl_->backend->reset(options);
  for (const auto& robot : impl_->robots) robot->restart();
  impl_->begin_anew_at(impl_->backend->now());
}

void World::teleport(std::size_t robot, const Pose2D& pose) {
  impl_->require_no_tick();
  if (robot >= robot_count()) throw ContractError("no robot " + std::to_string(robot));
  check_bounds("pose", pose);
  impl_->backend->teleport(robot, pose);
}

std::shared_ptr<const World::Snapshot> World::save() const {
  impl_->require_no_tick();
  auto snapshot = std::make_shared<Snapshot>();
  for (const auto& robot : impl_->robots) snapshot->robots.push_back(robot->save());
  snapshot->backend = impl_->backend->save();
  snapshot->now = now();
  snapshot->setup = impl_->setup;
  return snapshot;
}

std::vector<std::byte> World::save_backend() const {
  impl_->require_no_tick();
  return impl_->backend->save();
}

void World::restore(const std::shared_ptr<const Snapshot>& snapshot) {
  impl_->require_no_tick();
  if (!snapshot || snapshot->robots.size() != robot_count()) throw ContractError("the snapshot is of another world");
  require_like(snapshot->setup, impl_->setup);
  impl_->backend->restore(snapshot->backend);
  for (std::size_t i = 0; i < robot_count(); ++i) {
    impl_->robots[i]->restore(*snapshot->robots[i]);
    // a localizer that knows the truth comes with that of the world which was saved
    if (const auto* truths = truth_service()) {
      set_truth(*impl_->robots[i]->impl_->state->localizer, truths->truth(i));
    }
  }
  impl_->begin_anew_at(snapshot->now);
}

}  // namespace threewe
