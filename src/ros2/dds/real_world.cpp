#include "ros2/dds/real_world.hpp"

#include <cstdlib>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include "ros2/dds/real_robot.hpp"
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

std::vector<Endpoint> discover_with_cyclone(Duration wall) {
  (void)library();
  Node node(our_discovery(), "/", "threewe_discover");
  std::this_thread::sleep_for(wall);
  return node.endpoints();
}

}  // namespace threewe::ros2
