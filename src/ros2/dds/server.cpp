#include "ros2/dds/server.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include "hardware/link.hpp"
#include "ros2/dds/real_world.hpp"
#include "ros2/dds/served_robot.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::ros2 {
namespace {

using Clock = std::chrono::steady_clock;

constexpr Duration kStep = kControlPeriod / 4;  // of robot time, as readings of 100 Hz should not come in pairs; of an
                                                // autonomy stack that is what it is
constexpr Duration kLate = 200ms;               // what is not made up for: a computer that is too slow slows time down
constexpr Duration kSettle = 1s;                // wall, from one look at the graph to the next

const backend::TruthService& check(const backend::World& world, const ServeOptions& options) {
  const auto fail = [](const std::string& what) { throw ConfigError("ros2 serve: " + what); };
  const backend::TruthService* truth = world.truth_service();
  if (truth == nullptr) throw ConfigError("ros2 serve: the world is real; only simulated robots can be served");
  if (!(options.speed >= 0.0 && options.speed <= 1000.0)) {
    fail(fmt::format("speed is {}; it must lie in [0, 1000], 0 being as fast as can be", options.speed));
  }
  if (options.map && !options.autonomies.empty())
    fail("the scene's map and the robot's own are one topic: only one of them");
  const auto& names = options.namespaces;
  if (names.size() != world.robot_count()) {
    fail(fmt::format("{} namespaces for {} robots", names.size(), world.robot_count()));
  }
  for (auto name = names.begin(); name != names.end(); ++name) {
    if (!name->empty() && !is_ros_name(*name)) {
      fail(fmt::format("namespace '{}'; expected one such as /robot_1, of letters, digits, _ and /", *name));
    }
    if (std::find(names.begin(), name, *name) != name) fail(fmt::format("two robots in namespace '{}'", *name));
  }
  return *truth;
}

class CycloneServer : public Server {
 public:
  CycloneServer(std::unique_ptr<backend::World> world, const backend::TruthService& truth, const ServeOptions& options)
      : world_(std::move(world)), options_(options), step_(options.autonomies.empty() ? kStep : kControlPeriod) {
    for (std::size_t i = 0; i < options.namespaces.size(); ++i) {
      robots_.push_back(
          std::make_unique<ServedRobot>(*world_, truth, i, options.namespaces[i], options, our_discovery(), bell_));
    }
  }

  Time now() const override { return world_->now(); }

  void run(Duration wall) override {
    const auto end = Clock::now() + wall;
    publish_clock();
    if (options_.lockstep) {
      run_in_lockstep(end);
    } else {
      run_at_speed(end);
    }
    refresh();
  }

 private:
  void run_in_lockstep(Clock::time_point end) {
    const auto ready = [this] { return std::ranges::all_of(robots_, &ServedRobot::has_command); };
    for (;;) {
      {
        std::unique_lock lock(bell_.mutex);
        if (!bell_.rung.wait_until(lock, end, [&] { return ready(); })) return;
      }
      for (const auto& robot : robots_) robot->step(world_->now());
      advance(kControlPeriod);
      if (Clock::now() > end) return;
    }
  }

  void run_at_speed(Clock::time_point end) {
    for (auto now = Clock::now(); now < end; now = Clock::now()) {
      if (options_.speed > 0.0) {
        if (now > due_ + kLate) due_ = now;
        if (due_ > end) return std::this_thread::sleep_until(end);
        std::this_thread::sleep_until(due_);
        due_ += std::chrono::duration_cast<Clock::duration>(
            std::chrono::duration<double>(to_seconds(step_) / options_.speed));
      }
      for (const auto& robot : robots_) robot->drive(world_->now());
      advance(step_);
    }
  }

  void advance(Duration step) {
    world_->advance_to(world_->now() + step);
    for (const auto& robot : robots_) robot->publish();
    publish_clock();
  }

  void publish_clock() {
    for (const auto& robot : robots_) robot->publish_clock(world_->now());
  }

  void refresh() {
    if (Clock::now() < look_) return;
    look_ = Clock::now() + kSettle;
    for (const auto& robot : robots_) robot->refresh();
  }

  std::unique_ptr<backend::World> world_;
  ServeOptions options_;
  Duration step_;
  Bell bell_;
  Clock::time_point due_{};   // wall, of the next step
  Clock::time_point look_{};  // wall
  std::vector<std::unique_ptr<ServedRobot>> robots_;
};

}  // namespace

std::unique_ptr<Server> serve_with_cyclone(std::unique_ptr<backend::World> world, const ServeOptions& options) {
  (void)library();
  const backend::TruthService& truth = check(*world, options);
  return std::make_unique<CycloneServer>(std::move(world), truth, options);
}

}  // namespace threewe::ros2
