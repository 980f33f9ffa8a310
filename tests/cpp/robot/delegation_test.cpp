// Robots that other programs localise and drive: what the runtime makes of what they say.
#include <doctest/doctest.h>

#include <algorithm>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include "core/exact.hpp"
#include "robot/toy_world.hpp"
#include "robot/warnings.hpp"
#include "threewe/core/errors.hpp"
#include "threewe/map/occupancy_grid.hpp"
#include "threewe/robot/robot.hpp"

using namespace threewe;
using namespace threewe::test;
using Outcome = backend::ExternalNavigator::Outcome;

namespace {

struct Localizer final : backend::ExternalLocalizer {
  Report said;
  Report report() const override { return said; }
};

struct Navigator final : backend::ExternalNavigator {
  std::vector<Goal> goals;
  int cancelled = 0;
  Report said;
  std::string wrong;
  void start(const Goal& goal) override {
    goals.push_back(goal);
    said = {};
  }
  void cancel() override { ++cancelled; }
  Report report() const override { return said; }
  std::string trouble() const override { return wrong; }
};

std::shared_ptr<const map::OccupancyGrid> free_map() {
  auto grid = std::make_shared<map::OccupancyGrid>();
  grid->width = grid->height = 160;
  grid->origin = {-4.0, -4.0};
  grid->data.assign(160 * 160, map::OccupancyGrid::kFree);
  return grid;
}

/// One robot with both, connected, whose localization goes on saying where it is.
struct Delegated {
  explicit Delegated(const std::string& navigation = "nav2") {
    auto owned = std::make_unique<ToyWorld>();
    toy = &owned->robot(0);
    toy->localizer = &localizer;
    toy->navigator = &navigator;
    localizer.said.map_from_odom = Pose2D{1.0, 2.0, 0.0};
    localizer.said.map = free_map();
    localizer.said.map_version = 1;
    localizer.said.missing = "no transform";
    toy->on_poll = [this](Time now) {
      if (speaks) localizer.said.updated = now;
    };
    world = std::make_unique<World>(std::move(owned), false, autonomy_with("slam_toolbox", navigation));
    robot().connect();
    world->settle();
  }
  Runtime& robot() { return world->robot(0); }
  void tick(int count) {
    for (int i = 0; i < count; ++i) world->tick();
  }

  Localizer localizer;
  Navigator navigator;
  bool speaks = true;
  ToyPort* toy = nullptr;
  std::unique_ptr<World> world;
};

}  // namespace

TEST_CASE("pose, covariance and map are those of the program, and odom is the odometry's") {
  Delegated d;
  d.localizer.said.covariance = {0.04, 0.0, 0.0, 0.0, 0.04, 0.0, 0.0, 0.0, 0.01};
  d.robot().set_velocity({0.2, 0.0, 0.0}, 1s);
  d.tick(20);
  CHECK(d.robot().map() == *free_map());
  const slam::PoseEstimate& pose = d.robot().pose();
  CHECK(pose.map_from_odom == Pose2D{1.0, 2.0, 0.0});
  CHECK(pose.odom_from_base.x == doctest::Approx(d.toy->pose.x).epsilon(0.02));
  CHECK(pose.map_from_base().y == doctest::Approx(2.0));
  CHECK(pose.position_uncertainty() == doctest::Approx(0.2 * 2.4477).epsilon(1e-3));
  CHECK_FALSE(pose.lost());
  const auto& health = d.robot().health();
  CHECK(health.size() == 6);
  CHECK(health[4].name == "slam_toolbox");
  CHECK(health[4].ok());
  CHECK(health[5].name == "nav2");
}

TEST_CASE("obstacles are where scans hit, in odom") {
  Delegated d;
  d.tick(10);
  REQUIRE(d.robot().obstacles().size() > 300);
  for (const Vec2 point : d.robot().obstacles()) {
    CHECK(std::max(std::abs(point.x), std::abs(point.y)) == doctest::Approx(ToyPort::kRoom).epsilon(0.01));
  }
}

TEST_CASE("goals and paths are driven by the program, which is not commanded meanwhile") {
  Delegated d;
  const MotionHandle motion = d.robot().start(nav::MoveTo{.goal = {2.5, 2.0}});
  REQUIRE(d.navigator.goals.size() == 1);
  CHECK(d.navigator.goals[0].path == std::vector<Pose2D>{{2.5, 2.0, 0.0}});
  CHECK(d.navigator.goals[0].way == backend::ExternalNavigator::Way::to_pose);
  CHECK(motion->progress().distance_left == doctest::Approx(1.5));

  d.toy->pushed = {0.3, 0.0, 0.0};
  d.navigator.said.distance_left = 1.2;
  d.navigator.said.time_left = 4.0;
  d.tick(240);  // nothing of what the wheels do contradicts what we command
  CHECK(d.robot().health()[1].ok());
  CHECK(motion->progress().distance_left == 1.2);
  CHECK(motion->progress().time_left == 4.0);
  CHECK(motion->progress().distance_driven == doctest::Approx(1.44).epsilon(0.05));
  CHECK(d.robot().commanded().command == Velocity{});
  CHECK_FALSE(motion->done());

  d.toy->pushed = {};
  d.navigator.said.outcome = Outcome::reached;
  d.world->wait(motion);
  CHECK(motion->result().reason == Reason::reached);
  CHECK(motion->result().distance_to_goal < 0.1);

  const MotionHandle path = d.robot().start(nav::FollowPath{{{2.5, 3.0}, {3.5, 3.0}}});
  REQUIRE(d.navigator.goals.size() == 2);
  CHECK(d.navigator.goals[1].way == backend::ExternalNavigator::Way::along_path);
  REQUIRE(d.navigator.goals[1].path.size() == 3);  // from where it stands
  CHECK(d.navigator.goals[1].path[0].x == doctest::Approx(2.44).epsilon(0.01));
  CHECK(d.navigator.goals[1].path[1].theta == doctest::Approx(0.0));
  CHECK(d.robot().path().size() == 3);
  path->cancel();
}

TEST_CASE("waypoints are one goal of the program, which says to which of them it drives") {
  Delegated d;
  const MotionHandle motion = d.robot().start(nav::FollowWaypoints{{{{2.0, 2.0}}, {{2.0, 3.0}, 1.5}, {{1.0, 3.0}}}});
  REQUIRE(d.navigator.goals.size() == 1);
  const backend::ExternalNavigator::Goal& goal = d.navigator.goals[0];
  CHECK(goal.way == backend::ExternalNavigator::Way::to_waypoints);
  REQUIRE(goal.path.size() == 3);
  CHECK(goal.path[0] == Pose2D{2.0, 2.0, 0.0});
  CHECK(goal.path[1] == Pose2D{2.0, 3.0, 1.5});
  CHECK(goal.path[2].theta == doctest::Approx(3.14159));  // that of the way there
  CHECK(motion->progress().distance_left == doctest::Approx(3.0));
  d.tick(2);
  CHECK(motion->progress().distance_left == doctest::Approx(3.0).epsilon(0.02));
  d.navigator.said.waypoint = 2;
  d.tick(2);
  CHECK(motion->progress().distance_left == doctest::Approx(1.0).epsilon(0.02));
  d.navigator.said.outcome = Outcome::no_path;
  d.navigator.said.detail = "Nav2: waypoint 3 of 3 was missed";
  d.world->wait(motion);
  CHECK(motion->result().reason == Reason::no_path);
  CHECK_THROWS_AS((void)d.robot().start(nav::FollowWaypoints{}), ContractError);
}

TEST_CASE("however a motion ends, the program is to end it too") {
  Delegated d;
  int expected = 0;
  const auto ends = [&](const std::function<void()>& end, Reason reason) {
    const MotionHandle motion = d.robot().start(nav::MoveTo{.goal = {3.0, 2.0}});
    d.tick(3);
    end();
    d.world->wait(motion);
    CHECK(motion->result().reason == reason);
    CHECK(d.navigator.cancelled == ++expected);
  };
  ends([&] { d.robot().motion()->cancel(); }, Reason::cancelled);
  ends([&] { d.robot().stop(); }, Reason::cancelled);
  ends([&] { d.navigator.said.outcome = Outcome::no_path; }, Reason::no_path);
  ends([&] { d.robot().estop(); }, Reason::estop);
  d.robot().release_estop();
  ends([&] { d.robot().fail("broken"); }, Reason::fault);
}

TEST_CASE("each outcome is a reason") {
  Delegated d;
  const std::vector<std::pair<Outcome, Reason>> all{
      {Outcome::no_path, Reason::no_path}, {Outcome::blocked, Reason::blocked},     {Outcome::timeout, Reason::timeout},
      {Outcome::lost, Reason::lost},       {Outcome::cancelled, Reason::cancelled}, {Outcome::fault, Reason::fault}};
  for (const auto& [outcome, reason] : all) {
    const MotionHandle motion = d.robot().start(nav::MoveTo{.goal = {3.0, 2.0}});
    d.navigator.said.outcome = outcome;
    d.navigator.said.detail = "in words";
    d.world->wait(motion);
    CHECK(motion->result().reason == reason);
    CHECK(motion->result().detail == "in words");
  }
}

TEST_CASE("one that says it is there but is not, by the tolerance that was asked for, is uncertain") {
  Delegated d;
  const MotionHandle motion = d.robot().start(nav::MoveTo{.goal = {1.2, 2.0}, .tolerance = 0.1});
  d.navigator.said.outcome = Outcome::reached;
  d.world->wait(motion);
  CHECK(motion->result().reason == Reason::uncertain);
  CHECK(motion->result().detail.find("more than the tolerance of 0.10 m") != std::string::npos);
}

TEST_CASE("whether it is there is judged by readings from after it said so, however late they come") {
  Delegated d;
  const Warnings warnings;
  const MotionHandle motion = d.robot().start(nav::MoveTo{.goal = {2.5, 2.0}, .tolerance = 0.1});
  std::vector<Sample> held;
  d.toy->on_samples = [&](std::vector<Sample>& samples) {  // odometry comes 0.6 s late
    const auto odometry = std::stable_partition(samples.begin(), samples.end(),
                                                [](const Sample& s) { return s.sensor != ToyPort::kOdometry; });
    std::move(odometry, samples.end(), std::back_inserter(held));
    samples.erase(odometry, samples.end());
    while (!held.empty() && d.world->now() - held.front().measured >= 600ms) {
      held.front().received = d.world->now();
      samples.push_back(std::move(held.front()));
      held.erase(held.begin());
    }
  };
  d.toy->pushed = {0.3, 0.0, 0.0};
  d.tick(60);
  CHECK_FALSE(d.robot().health()[1].ok());
  d.tick(190);
  d.toy->pushed = {};
  CHECK(d.toy->pose.x == doctest::Approx(1.5));
  d.navigator.said.outcome = Outcome::reached;
  d.world->wait(motion);
  CHECK(motion->result().reason == Reason::reached);
  CHECK(motion->result().pose.x == doctest::Approx(2.5));
}

TEST_CASE("one that says it is there while nothing says where it is, is uncertain") {
  for (const bool program : {true, false}) {
    Delegated d;
    const Warnings warnings;
    const MotionHandle motion = d.robot().start(nav::MoveTo{.goal = {1.1, 2.0}});
    d.tick(5);
    if (program) {
      d.speaks = false;
    } else {
      d.toy->silent[ToyPort::kOdometry] = true;
    }
    d.tick(1);
    const Time before = d.world->now();
    d.navigator.said.outcome = Outcome::reached;
    d.world->wait(motion);
    CHECK(motion->result().reason == Reason::uncertain);
    CHECK(motion->result().detail.find("no new reading says where the robot is") != std::string::npos);
    CHECK(d.world->now() - before < 2100ms);
  }
}

TEST_CASE("a pose without a stated covariance is not taken for a certain one") {
  Delegated d("own");
  const MotionHandle motion = d.robot().start(nav::MoveTo{.goal = {1.5, 2.0}});
  d.world->wait(motion);
  CHECK(motion->result().reason == Reason::uncertain);
  CHECK(motion->result().position_uncertainty == doctest::Approx(0.5 * 2.4477).epsilon(1e-3));
  CHECK(d.robot().health()[4].ok());
  CHECK(d.robot().health()[4].detail.starts_with("it states no covariance"));
}

TEST_CASE("turning and driving straight stay ours") {
  Delegated d;
  const MotionHandle motion = d.robot().start(nav::Rotate{0.5});
  d.world->wait(motion);
  CHECK(motion->result().success);
  CHECK(d.navigator.goals.empty());
  CHECK(d.navigator.cancelled == 0);
  CHECK(d.toy->pose.theta == doctest::Approx(0.5).epsilon(0.2));
}

TEST_CASE("sensors at fault are the program's to look at, a robot out of reach is ours") {
  Delegated d;
  const Warnings warnings;
  const MotionHandle motion = d.robot().start(nav::MoveTo{.goal = {3.0, 2.0}});
  d.toy->silent[ToyPort::kLidar] = true;
  d.tick(1000);
  CHECK_FALSE(d.robot().health()[3].ok());
  CHECK_FALSE(motion->done());
  d.toy->silent = {true, true, true, true};
  d.world->wait(motion);
  CHECK(motion->result().reason == Reason::fault);
  CHECK(motion->result().detail.find("the robot is out of reach") != std::string::npos);
  CHECK(d.navigator.cancelled == 1);
}

TEST_CASE("a motion of ours waits for a localization that has fallen silent, and is lost after 10 s") {
  Delegated d("own");
  const Warnings warnings;
  const MotionHandle motion = d.robot().start(nav::MoveTo{.goal = {3.0, 2.0}});
  d.tick(50);
  const double driven = d.toy->pose.x;
  CHECK(driven > 0.1);
  d.speaks = false;
  d.tick(100);
  CHECK(d.robot().pose().state == slam::LocalizationState::lost);
  CHECK(d.robot().health()[4].detail.starts_with("no transform for "));
  const Pose2D stood = d.toy->pose;
  d.tick(100);
  CHECK(d.toy->pose == stood);  // it does not look around
  d.speaks = true;
  d.tick(50);
  CHECK(d.toy->pose.x > stood.x);
  d.speaks = false;
  d.world->wait(motion);
  CHECK(motion->result().reason == Reason::lost);
  CHECK(motion->result().detail.starts_with("slam_toolbox: no transform for "));

  const MotionHandle turn = d.robot().start(nav::Rotate{0.5});  // needs no place
  d.world->wait(turn);
  CHECK(turn->result().success);
}

TEST_CASE("what cannot be delegated is refused") {
  CHECK_THROWS_WITH_AS(
      autonomy_with("slam", "nav2"),
      "navigation 'nav2' has its goals in the map of 'amcl' or 'slam_toolbox': localization must be one of "
      "these, not 'slam'",
      ConfigError);
  CHECK_THROWS_WITH_AS(autonomy_with("slam_tolbox"), "unknown localization 'slam_tolbox'; did you mean 'slam_toolbox'?",
                       ConfigError);
  CHECK_THROWS_WITH_AS(Toy({"3we_standard_v2"}, autonomy_with("amcl")),
                       "localization 'amcl' is a program on a robot: backend 'real' reaches it, this one does not",
                       ConfigError);
  Delegated d;
  CHECK_THROWS_WITH_AS(d.robot().set_zones({map::Zone{{{0, 0}, {1, 0}, {1, 1}}}}),
                       "zones: 'nav2' plans by its own costmaps; set keep-out zones and speed limits there",
                       ContractError);
}
