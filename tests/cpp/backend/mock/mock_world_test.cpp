#include "backend/mock/mock_world.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include "core/rng.hpp"
#include "core/targets.hpp"
#include "draw.hpp"
#include "threewe/backend/conformance.hpp"
#include "threewe/backend/registry.hpp"
#include "threewe/core/errors.hpp"
#include "threewe/scene/scene.hpp"
#include "threewe/scene/truth_view.hpp"

using namespace threewe;
using namespace threewe::backend;

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::unique_ptr<World> make(const WorldOptions& options = {}) {
  auto world = make_world("mock", options);
  for (std::size_t i = 0; i < world->robot_count(); ++i) world->robot(i).connect();
  return world;
}

template <typename Error, typename Action>
std::string error_of(const Action& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

// Drives with random commands and returns all samples.
std::vector<Sample> drive(World& world, std::uint64_t seed, int periods, int first = 0) {
  const RngKey key{.seed = seed};
  std::vector<Sample> samples;
  for (int i = first; i < first + periods; ++i) {
    for (std::size_t r = 0; r < world.robot_count(); ++r) {
      const auto draw = static_cast<std::uint64_t>(i / 10);
      const bool holonomic = world.robot(r).profile().kinematics() == Kinematics::holonomic;
      world.robot(r).command({uniform(key, draw, 0, -0.5, 0.5), holonomic ? uniform(key, draw, 1, -0.5, 0.5) : 0.0,
                              uniform(key, draw, 2, -1.0, 1.0)},
                             world.now() + 200ms);
    }
    world.advance_to(world.now() + kControlPeriod);
    for (std::size_t r = 0; r < world.robot_count(); ++r) {
      for (Sample& sample : world.robot(r).poll()) samples.push_back(std::move(sample));
    }
  }
  return samples;
}

bool same(const LaserScan& a, const LaserScan& b) { return a.ranges == b.ranges && a.angle_min == b.angle_min; }
bool same(const IMUData& a, const IMUData& b) {
  return a.angular_velocity == b.angular_velocity && a.linear_acceleration == b.linear_acceleration;
}
bool same(const Odometry& a, const Odometry& b) { return a.pose == b.pose && a.velocity == b.velocity; }
bool same(const BatteryState& a, const BatteryState& b) { return a.voltage == b.voltage && a.charge == b.charge; }
bool same(const Picture& a, const Picture& b) { return a.image() == b.image(); }
bool same(const RangeData& a, const RangeData& b) { return a.range == b.range; }

bool same(const std::vector<Sample>& a, const std::vector<Sample>& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a[i].sensor != b[i].sensor || a[i].sequence != b[i].sequence || a[i].measured != b[i].measured ||
        a[i].received != b[i].received || a[i].data.index() != b[i].data.index()) {
      return false;
    }
    const bool equal = std::visit(
        [&](const auto& data) { return same(data, std::get<std::decay_t<decltype(data)>>(b[i].data)); }, a[i].data);
    if (!equal) return false;
  }
  return true;
}

}  // namespace

TEST_CASE("the mock backend keeps the contract, with either robot and either noise") {
  for (const char* robot : {"3we_standard_v2", "turtlebot_like"}) {
    for (const NoiseLevel noise : {NoiseLevel::realistic, NoiseLevel::ideal}) {
      if (kSanitized && noise == NoiseLevel::ideal) continue;
      WorldOptions options;
      options.robots = {robot};
      options.noise = noise;
      for (const CheckResult& result :
           check_backend([](const WorldOptions& o) { return make_world("mock", o); }, options)) {
        CAPTURE(robot);
        CAPTURE(result.name);
        CAPTURE(result.detail);
        CHECK(result.passed());
      }
    }
  }
}

TEST_CASE("unknown scenes, robots and impossible starts are refused with their reasons") {
  const auto error_for = [](const WorldOptions& options) {
    return error_of<ConfigError>([&] { make_world("mock", options); });
  };
  CHECK(error_for({.scene = "ofice_v2"}).find("'office_v2'") != std::string::npos);
  CHECK(error_for({.robots = {"turtlebot_lik"}}).find("'turtlebot_like'") != std::string::npos);
  CHECK(error_for({.robots = {}}).find("at least one") != std::string::npos);
  CHECK(error_for({.poses = {{}, {}}}).find("2 start poses for 1 robots") != std::string::npos);
  CHECK(error_for({.profiles = {{}, {}}}).find("profiles: 2 for 1 robots") != std::string::npos);
  const std::vector<std::string> four(4, "3we_standard_v2");
  CHECK(error_for({.robots = four}).find("names 3 start poses, too few for 4 robots") != std::string::npos);
  CHECK(error_for({.poses = {{kNaN, 0.0, 0.0}}}).find("not finite") != std::string::npos);
  CHECK(error_for({.poses = {{500.0, 0.0, 0.0}}}).find("outside scene") != std::string::npos);
  CHECK(error_for({.robots = {"3we_standard_v2", "turtlebot_like"}, .poses = {{}, {0.1, 0.0, 0.0}}})
            .find("start pose 1: (0.1, 0, 0) overlaps robot 0") != std::string::npos);

  const scene::Scene office = scene::Scene::load("office_v2");
  const scene::Wall& wall = office.walls.front();
  const Pose2D in_wall{0.5 * (wall.a.x + wall.b.x), 0.5 * (wall.a.y + wall.b.y), 0.0};
  CHECK(error_for({.poses = {in_wall}}).find("is inside a wall of scene 'office_v2'") != std::string::npos);
}

TEST_CASE("a refused reset leaves the world as it was") {
  const auto world = make();
  drive(*world, 1, 30);
  const auto before = world->save();
  CHECK_THROWS_AS(world->reset({.seed = 2, .poses = {{500.0, 0.0, 0.0}}}), ConfigError);
  CHECK(world->save() == before);
}

TEST_CASE("calls that the port must refuse") {
  const auto world = make_world("mock", {.robots = {"3we_standard_v2"}});
  RobotPort& robot = world->robot(0);
  CHECK_THROWS_AS(robot.poll(), ConnectionError);
  CHECK_THROWS_AS(robot.command({}, 1s), ConnectionError);
  robot.connect();
  robot.command({0.1, 0.1, 0.1}, 1s);
  for (const Velocity& bad : {Velocity{kNaN, 0, 0}, Velocity{0, kNaN, 0}, Velocity{0, 0, kNaN}}) {
    CHECK_THROWS_AS(robot.command(bad, 1s), ContractError);
  }
  robot.disconnect();
  CHECK_THROWS_AS(robot.poll(), ConnectionError);
  world->advance_to(1s);
  CHECK_THROWS_AS(world->advance_to(500ms), ContractError);

  const auto differential = make({.robots = {"turtlebot_like"}});
  CHECK(error_of<ContractError>([&] { differential->robot(0).command({0.0, 0.1, 0.0}, 1s); }).find("sideways") !=
        std::string::npos);
}

TEST_CASE("a robot that is disconnected while it drives comes to rest") {
  const auto world = make();
  world->robot(0).command({0.5, 0.0, 0.0}, 60s);
  world->advance_to(1s);
  CHECK(world->truth_service()->truth(0).true_velocity().vx > 0.4);
  world->robot(0).disconnect();
  world->advance_to(2s);
  CHECK(std::fabs(world->truth_service()->truth(0).true_velocity().vx) < 1e-3);
}

TEST_CASE("the port itself ends a command that nobody renews") {
  const auto world = make({.noise = NoiseLevel::ideal});
  world->robot(0).command({0.5, 0.0, 0.0}, 200ms);
  world->advance_to(5s);
  // 0.2 s at 0.5 m/s: what the lag costs at the start it gives back at the end
  CHECK(world->truth_service()->truth(0).distance_driven() == doctest::Approx(0.1).epsilon(0.01));
}

TEST_CASE("time between two physics steps belongs to the clock alone") {
  const auto fine = make();
  const auto coarse = make();
  fine->robot(0).command({0.3, 0.0, 0.2}, 1s);
  coarse->robot(0).command({0.3, 0.0, 0.2}, 1s);
  for (Time t{}; t < 1s; t += 3'333'333ns) fine->advance_to(t);
  fine->advance_to(1s);
  coarse->advance_to(1s);
  CHECK(fine->truth_service()->truth(0).true_pose() == coarse->truth_service()->truth(0).true_pose());
  CHECK(fine->save() == coarse->save());
}

TEST_CASE("a scan arrives 20 ms after its turn, its first beam measured last") {
  const auto world = make();
  world->advance_to(119ms);
  const auto scans_in = [](const std::vector<Sample>& samples) {
    std::vector<Sample> scans;
    for (const Sample& sample : samples) {
      if (std::holds_alternative<LaserScan>(sample.data)) scans.push_back(sample);
    }
    return scans;
  };
  CHECK(scans_in(world->robot(0).poll()).empty());
  world->advance_to(120ms);
  const auto scans = scans_in(world->robot(0).poll());
  REQUIRE(scans.size() == 1);
  CHECK(scans[0].received == 120ms);
  CHECK(scans[0].measured == 99'750'000ns);
  CHECK(std::get<LaserScan>(scans[0].data).time_increment == doctest::Approx(-0.1 / 360));
}

TEST_CASE("samples come in order of arrival") {
  const auto world = make();
  world->advance_to(3s);
  const auto samples = world->robot(0).poll();
  // 100 Hz, 50 Hz, 10 Hz less the turn that is still on its way, 1 Hz, a ping every 60 ms less the last, a picture
  // every 30 ms less three
  CHECK(samples.size() == 300 + 150 + 29 + 3 + 49 + 87);
  Time arrival{};
  for (const Sample& sample : samples) {
    const bool scan = std::holds_alternative<LaserScan>(sample.data);
    const bool echo = std::holds_alternative<RangeData>(sample.data);
    const bool picture = std::holds_alternative<Picture>(sample.data);
    const Duration latency = scan ? 250us + 20ms : echo ? 40ms : picture ? 80ms : 0ms;
    const Time arrived = sample.measured + latency;
    CHECK(arrived >= arrival);
    arrival = arrived;
  }
}

TEST_CASE("reset begins anew, to the bit") {
  const auto world = make();
  const auto first = drive(*world, 5, 100);
  world->reset({.seed = 0, .poses = {}});
  CHECK(world->now() == 0s);
  CHECK(world->truth_service()->truth(0).true_pose() == Pose2D{});
  CHECK(same(drive(*world, 5, 100), first));
  CHECK(same(drive(*make(), 5, 100), first));
  world->reset({.seed = 1, .poses = {}});
  CHECK_FALSE(same(drive(*world, 5, 100), first));
  world->reset({.seed = 0, .poses = {{0.3, 0.1, 1.0}}});
  CHECK(world->truth_service()->truth(0).start_pose() == Pose2D{0.3, 0.1, 1.0});
  // wherever it starts, odometry begins at zero
  world->advance_to(20ms);
  for (const Sample& sample : world->robot(0).poll()) {
    if (const auto* odometry = std::get_if<Odometry>(&sample.data)) CHECK(odometry->pose == Pose2D{});
  }
}

TEST_CASE("every vector target gives the same world, to the bit") {
  const std::vector<std::string> targets = available_targets();
  if (targets.size() < 2) MESSAGE("not shown: only one target, ", targets.front(), ", on this machine");
  std::vector<std::byte> expected;
  std::vector<Sample> expected_samples;
  for (const std::string& target : targets) {
    CAPTURE(target);
    force_target(target);
    // so close together that they run into one another
    const auto world = make({.robots = {"3we_standard_v2", "turtlebot_like", "3we_base_v2"},
                             .poses = {{}, {0.4, 0.0, 1.0}, {0.0, 0.5, 2.0}}});
    const auto samples = drive(*world, 3, kSanitized ? 20 : 150);
    if (expected.empty()) {
      expected = world->save();
      expected_samples = samples;
    }
    CHECK(world->save() == expected);
    CHECK(same(samples, expected_samples));
  }
  force_target("");
}

TEST_CASE("a world restored anywhere, with samples on their way, goes on to the bit") {
  for (const std::vector<std::string>& robots :
       {std::vector<std::string>{"3we_standard_v2"},
        std::vector<std::string>{"3we_standard_v2", "turtlebot_like", "3we_base_v2"}}) {
    WorldOptions options;
    options.robots = robots;
    if (robots.size() == 3) options.poses = {{}, {0.4, 0.0, 1.0}, {0.0, 0.5, 2.0}};
    const auto world = make(options);
    for (const int at : {0, 1, 5, 33}) {
      CAPTURE(at);
      drive(*world, 7, at);
      world->advance_to(world->now() + 105ms);  // not polled: a scan and many others wait
      const auto saved = world->save();
      const auto expected = drive(*world, 8, 60, at);
      const auto end = world->save();

      const auto other = make(options);
      drive(*other, 99, 20);
      other->restore(saved);
      CHECK(other->save() == saved);
      CHECK(same(drive(*other, 8, 60, at), expected));
      CHECK(other->save() == end);
      world->restore(saved);
      CHECK(same(drive(*world, 8, 60, at), expected));
    }
  }
}

TEST_CASE("a robot differs from its profile as its seed says, and again and again in an episode") {
  const auto state_after = [](World& world, int periods) {
    drive(world, 5, periods);
    return world.save();
  };
  const WorldOptions hard{.seed = 3, .randomization = "hard"};
  const auto world = make(hard);
  const auto early = state_after(*world, 150);
  const auto late = state_after(*world, 450);  // 9 s, in which floors and lamps have changed
  const auto other = make(hard);
  CHECK(state_after(*other, 150) == early);
  drive(*other, 9, 300);
  other->restore(early);
  CHECK(state_after(*other, 450) == late);
  other->reset({.seed = 3});
  CHECK(state_after(*other, 150) == early);
  other->reset({.seed = 4});
  CHECK(state_after(*other, 150) != early);

  const auto plain = make({.seed = 3});
  const Pose2D before = plain->truth_service()->truth(0).true_pose();
  CHECK(state_after(*plain, 150) != early);
  CHECK_FALSE(before == plain->truth_service()->truth(0).true_pose());
  CHECK(error_of<ContractError>([&] { plain->restore(early); }) ==
        "restore: saved from a world with another randomization");
  CHECK(error_of<ConfigError>([] { make({.randomization = "hrad"}); }).find("hard") != std::string::npos);
}

TEST_CASE("what arrives late by the draw arrives so late") {
  const auto arrival_of_scan = [](const std::string& randomization) {
    const auto world = make({.randomization = randomization});
    for (;;) {
      world->advance_to(world->now() + 2ms);
      for (const Sample& sample : world->robot(0).poll()) {
        if (std::holds_alternative<LaserScan>(sample.data)) return sample.received;
      }
    }
  };
  const auto file = std::filesystem::temp_directory_path() / "threewe_late.yaml";
  std::ofstream(file) << "description: Late\nreset: {sensor_latency: [2.0, 2.0]}\n";
  CHECK(arrival_of_scan("none") == 120ms);
  CHECK(arrival_of_scan(file.string()) == 140ms);
  std::filesystem::remove(file);
}

TEST_CASE("bytes that are no saved world of this kind change nothing") {
  const auto world = make();
  drive(*world, 1, 20);
  const auto saved = world->save();
  const auto refused = [&](const std::vector<std::byte>& bytes) {
    CHECK_THROWS_AS(world->restore(bytes), ContractError);
    CHECK(world->save() == saved);
  };
  refused({});
  refused(std::vector<std::byte>(1000));
  for (const std::size_t size : {saved.size() - 1, saved.size() / 2, std::size_t{40}, std::size_t{9}}) {
    CAPTURE(size);
    refused({saved.begin(), saved.begin() + static_cast<std::ptrdiff_t>(size)});
  }
  auto longer = saved;
  longer.push_back({});
  refused(longer);
  refused(make({.noise = NoiseLevel::ideal})->save());
  refused(make({.robots = {"turtlebot_like"}})->save());
  refused(make({.scene = "corridor_v1"})->save());
}

TEST_CASE("the truth: free places, shortest paths, and how hard the robot hit") {
  const auto world = make();
  const scene::TruthView& truth = world->truth_service()->truth(0);
  CHECK(truth.scene().name == "office_v2");
  CHECK(truth.geodesic({0.0, 0.0}, {0.5, 0.0}) == doctest::Approx(0.5).epsilon(0.02));
  CHECK(truth.geodesic({0.0, 0.0}, {2.0, 1.0}) >= std::sqrt(5.0) - 1e-9);
  CHECK(std::isinf(truth.geodesic({0.0, 0.0}, {500.0, 0.0})));
  for (std::uint64_t seed = 0; seed < cases(200); ++seed) {
    CAPTURE(seed);
    const Pose2D pose = truth.sample_free_pose(seed);
    CHECK(truth.sample_free_pose(seed) == pose);
    CHECK_NOTHROW(world->reset({.seed = seed, .poses = {pose}}));
    CHECK(truth.true_pose().position() == pose.position());
  }

  world->reset({.seed = 0, .poses = {}});
  CHECK(truth.max_collision_speed() == 0.0);
  world->robot(0).command({0.5, 0.0, 0.0}, 60s);
  world->advance_to(40s);
  CHECK(truth.max_collision_speed() > 0.4);
  CHECK(truth.max_collision_speed() < 0.55);
  CHECK(truth.distance_driven() > 1.0);
}
