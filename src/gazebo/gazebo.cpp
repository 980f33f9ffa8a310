#include "gazebo/gazebo.hpp"

#include <cstdlib>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include "backend/simulated/plugin_truth.hpp"
#include "gazebo/robot.hpp"
#include "gazebo/zmq.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::gazebo {
namespace {

constexpr Duration kPatience = 120s;  // beyond all of the robot's own, which say what is wrong

// What a caller asks for that a world which runs already has settled.
void check(const backend::WorldOptions& options) {
  const auto fail = [](std::string_view what) { throw ConfigError(fmt::format("backend 'gazebo': {}", what)); };
  if (options.robots.size() != 1) {
    fail(fmt::format("a world of {} robots; an exported world has one", options.robots.size()));
  }
  if (options.noise != NoiseLevel::realistic) {
    fail("noise is 'ideal'; sensors have the noise that the exported world states, it must be 'realistic'");
  }
  if (options.image_size) fail("a size of images: cameras deliver what the exported world states");
  if (options.randomization != "none") {
    fail(fmt::format("randomization is '{}'; it must be 'none'", options.randomization));
  }
}

/// People stand where the export put them.
class Truth : public backend::simulated::PluginTruthView {
 public:
  using PluginTruthView::PluginTruthView;
  std::vector<scene::PersonPose> people() const override {
    std::vector<scene::PersonPose> people;
    for (const scene::Person& person : scene().people) {
      people.push_back({person.name, {person.route.front().x, person.route.front().y, 0.0}, person.radius});
    }
    return people;
  }
};

class GazeboWorld : public backend::PluginWorld {
 public:
  GazeboWorld(const std::shared_ptr<backend::PluginLink>& mailbox, std::shared_ptr<const scene::Scene> scene,
              const Settings& settings, const Pose2D& start)
      : PluginWorld(mailbox, std::make_unique<Truth>(mailbox, scene)),
        mailbox_(mailbox),
        robot_(mailbox, settings, scene->name, start),
        thread_([this] { robot_.run(); }) {}
  GazeboWorld(const GazeboWorld&) = delete;
  GazeboWorld& operator=(const GazeboWorld&) = delete;
  ~GazeboWorld() override {
    mailbox_->close();
    thread_.join();  // after the robot was commanded to stand
  }

 private:
  std::shared_ptr<backend::PluginLink> mailbox_;
  Robot robot_;
  std::thread thread_;
};

}  // namespace

std::unique_ptr<backend::World> make_world(const backend::WorldOptions& options) {
  check(options);
  zmq::load();  // throws here, where the caller can see what to install
  auto scene = std::make_shared<const scene::Scene>(scene::Scene::load(options.scene));
  RobotProfile profile = options.profiles.empty() ? load_profile(options.robots.front()) : options.profiles.front();
  backend::Features features = features_of(profile);
  auto mailbox = std::make_shared<backend::PluginLink>("gazebo", std::move(features), std::move(profile), kPatience);
  const Pose2D start = options.poses.empty() ? Pose2D{} : options.poses.front();
  const Settings settings = read_settings([](const char* name) { return std::getenv(name); });
  return std::make_unique<GazeboWorld>(mailbox, std::move(scene), settings, start);
}

}  // namespace threewe::gazebo
