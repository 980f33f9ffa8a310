#include "ros2/dds/real_world.hpp"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include "ros2/dds/real_robot.hpp"
#include "ros2/diagnosis.hpp"
#include "ros2/message_types.hpp"
#include "ros2/network_interfaces.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::ros2 {
namespace {

// What a caller asks for that no real robot can do.
void check(const backend::WorldOptions& options) {
  const auto fail = [](std::string_view what) { throw ConfigError(fmt::format("backend 'real': {}", what)); };
  if (options.robots.size() != 1) fail(fmt::format("a world of {} robots; it has one", options.robots.size()));
  if (!options.poses.empty()) fail("a start pose: the robot starts where it stands");
  if (options.image_size) fail("a size of images: the camera delivers those of its profile");
  if (options.randomization != "none") {
    fail(fmt::format("randomization is '{}'; no real robot can be randomized, it must be 'none'",
                     options.randomization));
  }
}

/// How often a topic's messages come; noted in threads of Cyclone's.
class Meter {
 public:
  using Clock = std::chrono::steady_clock;
  void note() {
    const std::scoped_lock lock(mutex_);
    last_ = Clock::now();
    if (count_++ == 0) first_ = last_;
  }
  /// [Hz]; 0 for fewer than two.
  double rate() {
    const std::scoped_lock lock(mutex_);
    return count_ < 2 ? 0.0 : (count_ - 1) / std::chrono::duration<double>(last_ - first_).count();
  }

 private:
  std::mutex mutex_;
  int count_ = 0;
  Clock::time_point first_{}, last_{};
};

bool is_known(std::string_view type) {
  return std::ranges::find(message_types(), type, &MessageType::name) != message_types().end();
}

class RealWorld : public backend::PluginWorld {
 public:
  RealWorld(std::shared_ptr<backend::PluginLink> mailbox, const Discovery& discovery)
      : PluginWorld(mailbox),
        mailbox_(std::move(mailbox)),
        robot_(mailbox_, discovery),
        thread_([this] { robot_.run(); }) {}
  RealWorld(const RealWorld&) = delete;
  RealWorld& operator=(const RealWorld&) = delete;
  ~RealWorld() override {
    mailbox_->close();
    thread_.join();  // after the robot was commanded to stand
  }

  backend::ExternalLocalizer& delegate_localization(std::string_view program,
                                                    const std::optional<Pose2D>& map_from_start) override {
    return robot_.delegate_localization(program, map_from_start);
  }
  backend::ExternalNavigator& delegate_navigation(std::string_view program) override {
    return robot_.delegate_navigation(program);
  }

 private:
  std::shared_ptr<backend::PluginLink> mailbox_;
  RealRobot robot_;
  std::thread thread_;
};

}  // namespace

Discovery our_discovery() {
  return read_discovery([](const char* name) { return std::getenv(name); });
}

std::unique_ptr<backend::World> make_real_world(const backend::WorldOptions& options) {
  check(options);
  (void)library();  // throws here, where the caller can see what to install
  RobotProfile profile = options.profiles.empty() ? load_profile(options.robots.front()) : options.profiles.front();
  backend::Features features = features_of(profile);
  auto mailbox = std::make_shared<backend::PluginLink>("real", std::move(features), std::move(profile));
  return std::make_unique<RealWorld>(std::move(mailbox), our_discovery());
}

Graph discover_with_cyclone(Duration wall) {
  (void)library();
  const Discovery discovery = our_discovery();
  std::map<std::string, Meter> meters;  // by topic; outlive the node
  Node node(discovery, "/", "threewe_discover");
  Graph graph;
  const auto end = Meter::Clock::now() + wall;
  while (Meter::Clock::now() < end) {
    std::this_thread::sleep_for(100ms);
    graph.endpoints = node.endpoints();
    for (const Endpoint& endpoint : graph.endpoints) {
      if (!endpoint.publishes || !is_known(endpoint.type) || !endpoint.topic.starts_with('/')) continue;
      const auto [at, added] = meters.try_emplace(endpoint.topic);
      if (!added) continue;
      node.subscribe(endpoint.topic, endpoint.type, {.reliable = false},
                     [meter = &at->second](std::span<const std::uint8_t>, std::uint64_t) { meter->note(); });
    }
  }
  for (Endpoint& endpoint : graph.endpoints) {
    const auto meter = meters.find(endpoint.topic);
    if (meter != meters.end()) endpoint.rate = meter->second.rate();
  }
  if (graph.endpoints.empty()) {
    graph.silence = diagnose_silence(discovery, {wall, node.participants(), network_interfaces()});
  }
  return graph;
}

}  // namespace threewe::ros2
