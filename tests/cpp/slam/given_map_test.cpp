// A robot in a map that was drawn before: it finds itself, keeps its place, and notices when it was carried away.
#include <doctest/doctest.h>

#include <cmath>
#include <initializer_list>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "slam/scan_matching_localizer.hpp"
#include "slam/tiny_world.hpp"

namespace threewe::slam {
namespace {

using testing::add_box;
using testing::TinyErrors;
using testing::TinyWall;
using testing::TinyWorld;

constexpr TinyErrors kErrors{1.01, 0.92, 0.004, 0.0017, 0.01, 0.02};

SensorModel model() {
  SensorModel sensors;
  sensors.lateral_scale = 0.915;
  sensors.lateral_scale_sigma = 0.04;
  return sensors;
}

// Two rooms that differ, and a door between them.
std::vector<TinyWall> flat() {
  std::vector<TinyWall> walls;
  add_box(walls, {-3, -2}, {7, 3});
  walls.push_back({{2, -2}, {2, -0.6}});
  walls.push_back({{2, 0.6}, {2, 3}});
  add_box(walls, {-2.6, 1.8}, {-1.2, 2.6});
  add_box(walls, {5.0, -2.0}, {5.8, -1.1});
  add_box(walls, {3.5, 2.2}, {4.2, 3.0});
  return walls;
}

// What the robot has drawn itself on a drive through both rooms, in its own frame: it began at the origin.
std::shared_ptr<const map::OccupancyGrid> drawn() {
  static const auto map = [] {
    TinyWorld world(flat(), {}, kErrors, 9);
    const auto localizer = make_scan_matching_localizer(model());
    const auto drive = [&](const Velocity& v, int ticks) {
      for (int tick = 0; tick < ticks; ++tick) {
        for (const Sample& s : world.tick(v)) localizer->add(s);
      }
    };
    drive({-0.3, 0.0, 0.0}, 200);
    drive({0.3, 0.0, 0.0}, 900);
    drive({0.0, 0.0, 0.6}, 500);
    return std::make_shared<const map::OccupancyGrid>(localizer->map());
  }();
  return map;
}

// One robot in that flat, and what it believes.
class Wakening {
 public:
  Wakening(const Pose2D& truth, const InitialState& initial, std::vector<TinyWall> walls = flat())
      : world_(std::move(walls), truth, kErrors, 11), localizer_(make_scan_matching_localizer(model(), initial)) {}

  void drive(const Velocity& v, int ticks) {
    for (int tick = 0; tick < ticks; ++tick) {
      for (const Sample& s : world_.tick(v)) localizer_->add(s);
      const PoseEstimate e = estimate();
      if (!e.lost()) worst_ = std::max(worst_, error());
      lost_ticks_ += e.lost() ? 1 : 0;
      if (states_.empty() || states_.back() != e.state) states_.push_back(e.state);
      CHECK(localizer_->map_version() >= version_);
      version_ = localizer_->map_version();
    }
  }
  PoseEstimate estimate() const { return localizer_->estimate(world_.now()); }
  double error() const { return distance(estimate().map_from_base().position(), world_.pose().position()); }

  TinyWorld world_;
  std::unique_ptr<Localizer> localizer_;
  std::uint64_t version_ = 0;
  double worst_ = 0.0;  // [m] while it claims to know
  int lost_ticks_ = 0;
  std::vector<LocalizationState> states_;  // one after the other
};

using States = std::vector<LocalizationState>;

std::string names(const States& states) {
  std::string all;
  for (const LocalizationState state : states) all += std::string(to_string(state)) + " ";
  return all;
}

TEST_CASE("without a word about where it is, a robot finds itself in half a second") {
  for (const Pose2D truth : {Pose2D{0.4, 0.9, 2.1}, Pose2D{5.2, 1.0, -0.8}, Pose2D{-2.0, -1.0, 0.3}}) {
    CAPTURE(truth.x);
    Wakening robot(truth, {drawn(), {}});
    CHECK(robot.estimate().lost());
    CHECK(robot.estimate().covariance[0] > 4.0);
    robot.drive({}, 30);
    CHECK_FALSE(robot.estimate().lost());
    robot.drive({0.2, 0.0, 0.4}, 600);
    CHECK(robot.worst_ < 0.08);
    CHECK(robot.estimate().covariance[0] < 0.01);
    CHECK(robot.lost_ticks_ < 30);
  }
}

TEST_CASE("a first pose that is roughly right is good enough, and one that is wrong is found out") {
  Wakening roughly({0.4, 0.9, 2.1}, {drawn(), Pose2D{0.8, 0.6, 1.9}});
  roughly.drive({}, 10);  // the first scan
  roughly.worst_ = 0.0;
  roughly.drive({0.2, 0.0, 0.4}, 300);
  CHECK(roughly.worst_ < 0.08);
  CHECK(roughly.lost_ticks_ == 0);

  Wakening wrong({0.4, 0.9, 2.1}, {drawn(), Pose2D{5.0, 0.5, 0.0}});
  wrong.drive({}, 200);
  CHECK_FALSE(wrong.estimate().lost());
  CHECK(wrong.error() < 0.08);
}

TEST_CASE("a robot that is carried to another room says so, and finds itself there") {
  Wakening robot({0.4, 0.9, 2.1}, {drawn(), Pose2D{0.4, 0.9, 2.1}});
  robot.drive({0.2, 0.0, 0.4}, 200);
  CHECK(robot.lost_ticks_ == 0);
  robot.world_.teleport({5.2, 1.0, -0.8});
  robot.drive({}, 100);
  CHECK(names(robot.states_) == "tracking doubting tracking ");
  CHECK(robot.error() < 0.08);
}

TEST_CASE("a robot that draws its own map finds back into it") {
  Wakening robot({}, {});
  robot.drive({-0.3, 0.0, 0.0}, 200);
  robot.drive({0.3, 0.0, 0.0}, 900);
  robot.drive({0.0, 0.0, 0.6}, 500);
  CHECK(robot.lost_ticks_ == 0);
  robot.world_.teleport({-1.0, 0.5, 2.0});
  robot.drive({}, 150);
  CHECK_FALSE(robot.estimate().lost());
  CHECK(robot.error() < 0.08);
}

constexpr Pose2D kHere{0.4, 0.9, 2.1};
constexpr Pose2D kThere{5.2, 1.0, -0.8};

// A screen around a place, of which some sides stand.
void put_screen(Wakening& robot, Vec2 place, std::initializer_list<int> sides) {
  std::vector<TinyWall> box;
  add_box(box, place - Vec2{0.8, 0.7}, place + Vec2{0.8, 0.7});
  std::vector<TinyWall> walls = flat();
  for (const int side : sides) walls.push_back(box[static_cast<std::size_t>(side)]);
  robot.world_.walls() = std::move(walls);
}

// Tracked, while more and more of a screen hides the map that was given.
Wakening doubting_robot() {
  Wakening robot(kHere, {drawn(), kHere});
  robot.drive({}, 50);
  for (const auto sides : {std::initializer_list<int>{0}, {0, 1}, {0, 1, 2}, {0, 1, 2, 3}}) {
    put_screen(robot, kHere.position(), sides);
    robot.drive({}, 150);
  }
  return robot;
}

TEST_CASE("a robot that wakes up in a map is lost, then relocating, then tracking") {
  Wakening robot(kHere, {drawn(), {}});
  robot.drive({}, 60);
  CHECK(names(robot.states_) == "lost relocating tracking ");
}

TEST_CASE("a robot that was put out of its map loses track, and is found where it is put back") {
  Wakening robot(kHere, {drawn(), kHere});
  robot.drive({}, 100);
  std::vector<TinyWall> elsewhere;
  add_box(elsewhere, {-30, -30}, {-27, -28});
  std::swap(robot.world_.walls(), elsewhere);
  robot.world_.teleport({-29, -29, 1.0});
  for (int tick = 0; tick < 500 && !robot.estimate().lost(); ++tick) robot.drive({}, 1);
  std::swap(robot.world_.walls(), elsewhere);
  robot.world_.teleport(kHere);
  robot.drive({}, 300);
  CHECK(names(robot.states_) == "tracking doubting lost relocating tracking ");
  CHECK(robot.error() < 0.08);
}

// A corridor of 20 m, 1.8 m wide, between whose walls a few posts stand and doorways open, none of them like another.
std::vector<TinyWall> corridor() {
  std::vector<TinyWall> walls = {{{-10, -0.9}, {-10, 0.9}}, {{10, -0.9}, {10, 0.9}}};
  const auto side = [&](double y, std::initializer_list<double> doors) {
    double from = -10.0;
    for (const double door : doors) {
      walls.push_back({{from, y}, {door, y}});
      walls.push_back({{door, y}, {door, y > 0 ? y + 1.5 : y - 1.5}});  // its leaf
      from = door + 0.85;
    }
    walls.push_back({{from, y}, {10, y}});
  };
  side(0.9, {-6.5, -1.1, 4.3});
  side(-0.9, {-4.2, 1.9, 7.0});
  add_box(walls, {-8.3, 0.5}, {-7.9, 0.9});
  add_box(walls, {0.6, -0.9}, {1.0, -0.6});
  add_box(walls, {5.9, 0.55}, {6.2, 0.9});
  return walls;
}

TEST_CASE("in a corridor, where nearly all beams fit anywhere, a robot that is carried along claims no wrong place") {
  const auto map = [] {
    TinyWorld world(corridor(), {-9.0, 0.0, 0.0}, kErrors, 9);
    const auto localizer = make_scan_matching_localizer(model(), {nullptr, Pose2D{-9.0, 0.0, 0.0}});
    for (int tick = 0; tick < 3000; ++tick) {
      for (const Sample& s : world.tick({0.3, 0.0, 0.0})) localizer->add(s);
    }
    return std::make_shared<const map::OccupancyGrid>(localizer->map());
  }();
  std::mt19937 random(5);
  std::uniform_real_distribution<double> along(-9.0, 9.0);
  int found = 0;
  constexpr int kCarried = 100;
  for (int i = 0; i < kCarried; ++i) {
    const Pose2D here{along(random), 0.0, 0.0};
    const Pose2D there{along(random), 0.1, i % 2 == 0 ? 0.05 : 3.0};
    CAPTURE(here.x);
    CAPTURE(there.x);
    Wakening robot(here, {map, here}, corridor());
    robot.drive({}, 30);
    robot.world_.teleport(there);
    robot.drive({}, 400);
    found += robot.error() < 0.3 ? 1 : 0;
    const States& states = robot.states_;
    const bool sure_again = states.size() > 1 && states.back() == LocalizationState::tracking;
    if (sure_again) CHECK(robot.error() < 0.3);
  }
  CHECK(found >= 85);  // where all but a few beams fit, no robot can tell
}

TEST_CASE("a pose that was found and does not fit the next scans is given up") {
  Wakening robot(kHere, {drawn(), {}});
  for (int tick = 0; tick < 60 && robot.estimate().state != LocalizationState::relocating; ++tick) robot.drive({}, 1);
  robot.world_.teleport(kThere);
  robot.drive({}, 10);
  CHECK(names(robot.states_) == "lost relocating lost ");
  robot.drive({}, 100);
  CHECK(names(robot.states_) == "lost relocating lost relocating tracking ");
  CHECK(robot.error() < 0.08);
}

TEST_CASE("a robot around which all has changed doubts, and no longer does when it looks as before") {
  Wakening robot = doubting_robot();
  CHECK(names(robot.states_) == "tracking doubting ");
  put_screen(robot, kHere.position(), {});
  robot.drive({}, 300);
  CHECK(names(robot.states_) == "tracking doubting tracking ");
  CHECK(robot.worst_ < 0.08);
}

TEST_CASE("a robot that doubts and is put elsewhere is lost, and finds itself there") {
  Wakening robot = doubting_robot();
  robot.world_.teleport(kThere);
  robot.drive({}, 200);
  CHECK(names(robot.states_) == "tracking doubting lost relocating tracking ");
  CHECK(robot.error() < 0.08);
}

TEST_CASE("a robot that doubts relocalizes where the map fits better") {
  Wakening robot = doubting_robot();
  const Pose2D moved{kThere.x, kThere.y, kHere.theta};
  robot.world_.teleport(moved);  // together with the screen: nothing seems to have changed
  for (const auto sides : {std::initializer_list<int>{0, 1, 2, 3}, {0, 1, 2}, {0, 1}, {0}, {}}) {
    put_screen(robot, moved.position(), sides);
    robot.drive({}, 150);
  }
  CHECK(names(robot.states_) == "tracking doubting tracking ");
  CHECK(robot.error() < 0.08);
}

TEST_CASE("what was moved since the map was drawn, and people, do not matter") {
  std::vector<TinyWall> changed = flat();
  changed.resize(changed.size() - 4);           // the shelf in the other room is gone
  add_box(changed, {-0.5, -1.9}, {0.3, -1.2});  // and these are new
  add_box(changed, {4.4, 0.9}, {4.9, 1.4});
  Wakening robot({0.4, 0.9, 2.1}, {drawn(), {}}, changed);
  const std::size_t walls = robot.world_.walls().size();
  for (int i = 0; i < 300; ++i) {  // somebody walks by
    robot.world_.walls().resize(walls);
    const double x = -2.0 + 0.01 * i;
    add_box(robot.world_.walls(), {x, 0.0}, {x + 0.4, 0.3});
    robot.drive({}, 1);
  }
  robot.world_.walls().resize(walls);
  robot.drive({0.0, 0.0, -1.0}, 105);  // faces along +x
  robot.drive({0.3, 0.0, 0.0}, 200);
  CHECK(robot.worst_ < 0.10);
  CHECK(robot.lost_ticks_ < 60);
  // what is new is in the map now
  const map::OccupancyGrid& map = robot.localizer_->map();
  CHECK(map.at(map.cell({-0.1, -1.21})) >= 65);
}

TEST_CASE("in a map of another place a robot stays lost") {
  std::vector<TinyWall> elsewhere;
  add_box(elsewhere, {-1.3, -4.0}, {1.6, 5.0});
  add_box(elsewhere, {0.2, 1.0}, {1.6, 1.8});
  Wakening robot({0.0, -1.0, 0.3}, {drawn(), {}}, elsewhere);
  robot.drive({}, 250);
  robot.drive({0.2, 0.0, 0.0}, 150);
  CHECK(robot.lost_ticks_ == 400);
}

TEST_CASE("a copy goes on with the same bits, lost or not") {
  for (const int ticks : {7, 12, 60}) {
    CAPTURE(ticks);
    TinyWorld world(flat(), {0.4, 0.9, 2.1}, kErrors, 11);
    auto localizer = make_scan_matching_localizer(model(), {drawn(), {}});
    for (int tick = 0; tick < ticks; ++tick) {
      for (const Sample& s : world.tick({})) localizer->add(s);
    }
    auto copy = localizer->clone();
    for (int tick = 0; tick < 120; ++tick) {
      for (const Sample& s : world.tick({0.1, 0.0, 0.3})) {
        localizer->add(s);
        copy->add(s);
      }
      const PoseEstimate a = localizer->estimate(world.now());
      const PoseEstimate b = copy->estimate(world.now());
      CHECK(a.map_from_odom == b.map_from_odom);
      CHECK(a.lost() == b.lost());
      CHECK(a.covariance == b.covariance);
    }
    CHECK(localizer->map() == copy->map());
  }
}

}  // namespace
}  // namespace threewe::slam
