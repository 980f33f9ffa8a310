// A robot whose sensors and wheels break while it drives from goal to goal, told case by case:
//
//   verify_faults KIND SEED COUNT [SCENE]  so many cases of a kind of fault, or of `pair`: two faults of any kind
//   verify_faults clean SEED SECONDS       nothing breaks; every sensor that is at fault all the same is printed
//   verify_faults honest SEED SECONDS      the same of robots, noise and randomisations of all kinds, in bare corridors
//                                          too, and straight ahead and back in between
//
// Without a scene one of the named ones is drawn. One line of JSON a case. Truth is looked at here and nowhere else.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/exact.hpp"
#include "number.hpp"
#include "robot/faulty_port.hpp"
#include "scene/episodes.hpp"
#include "threewe/backend/registry.hpp"
#include "threewe/robot/robot.hpp"
#include "threewe/robot/warning.hpp"

using namespace threewe;
using namespace threewe::test;

namespace {

constexpr Duration kCase = 10s;
constexpr double kMoves = 0.03;  // [m/s] or three times as many [rad/s]: a robot that moves
const std::vector<std::string> kScenes = {"office_v2",    "apartment_v1", "corridor_v1", "warehouse_v1",
                                          "cluttered_v1", "outdoor_v1",   "dynamic_v1"};

// Numbers of one case, drawn one after the other.
class Draws {
 public:
  explicit Draws(std::uint64_t seed) : key_{.seed = seed, .stream = Stream::sampler} {}
  double between(double low, double high) { return uniform(key_, count_++, 0, low, high); }
  std::size_t below(std::size_t n) { return static_cast<std::size_t>(between(0.0, static_cast<double>(n))); }
  double sign() { return below(2) == 0 ? -1.0 : 1.0; }

 private:
  RngKey key_;
  std::uint64_t count_ = 0;
};

// A robot in a place, used for one case after another.
class Place {
 public:
  Place(std::string in, std::string with, backend::WorldOptions options = {})
      : scene(std::move(in)), hardware(std::move(with)) {
    options.scene = scene;
    options.robots = {hardware};
    auto faulty = std::make_unique<WorldOfFaults>(backend::make_world("mock", options));
    port_ = &faulty->robot(0);
    world_ = std::make_unique<World>(std::move(faulty));
    robot_.emplace(*world_);
  }

  void begin(std::uint64_t seed) {
    port_->break_with({});
    Simulation& simulation = *robot_->simulation();
    simulation.reset(seed, simulation.sample_free_pose(seed));
    goals_ = Draws(seed ^ 0x90A15);
    if (!robot_->runtime().connected() || !robot_->runtime().fault().empty()) robot_->connect();
  }
  void break_with(const std::vector<InjectedFault>& faults) { port_->break_with(faults); }

  // One period on the way to somewhere, unless it is driven otherwise.
  void tick(bool may_be_driven = false) {
    const bool driven = may_be_driven && robot_->runtime().requested() != Velocity{};
    if (!driven && !robot_->runtime().motion() && robot_->runtime().fault().empty()) set_out();
    world_->tick();
  }
  Robot& robot() { return *robot_; }
  const Simulation& truth() { return *robot_->simulation(); }
  Time now() const { return world_->now(); }
  double error() {
    return distance((truth().start_pose() * robot_->runtime().pose().map_from_base()).position(),
                    truth().true_pose().position());
  }

  const std::string scene;
  const std::string hardware;

 private:
  void set_out() {
    const Pose2D goal = truth().sample_free_pose(goals_.below(1U << 30U));
    const Vec2 in_map = (inverse(truth().start_pose()) * goal).position();
    motion_ = robot_->move_to(in_map.x, in_map.y);
  }

  FaultyPort* port_ = nullptr;
  std::unique_ptr<World> world_;
  std::optional<Robot> robot_;
  MotionHandle motion_;
  Draws goals_{0};
};

bool moves(const Velocity& v) { return std::hypot(v.vx, v.vy) > kMoves || std::fabs(v.omega) > 3.0 * kMoves; }

// One of those that the mind uses; one chance for all ultrasonic ones together.
std::uint16_t draw_sensor(Draws& draws, const backend::Features& features, std::vector<SensorType> types) {
  std::erase_if(types, [&](SensorType type) { return !features.has(type); });
  if (features.has(SensorType::lidar)) std::erase(types, SensorType::ultrasonic);
  const SensorType type = types.at(draws.below(types.size()));
  std::vector<std::uint16_t> places;
  for (std::size_t i = 0; i < features.sensors.size(); ++i) {
    if (features.sensors[i].type == type) places.push_back(static_cast<std::uint16_t>(i));
  }
  return places.at(draws.below(places.size()));
}

const std::vector<double> kDropouts = {0.2, 0.5, 0.8, 0.9, 0.97, 0.99, 1.0};
const std::vector<std::string> kKinds = {"silent",  "frozen",     "nan",       "stamps_back", "stamps_ahead",
                                         "noise",   "lidar_bias", "gyro_bias", "delay",       "delay_restamped",
                                         "dropout", "covered",    "slip",      "wheel_slip",  "wheel_blocked"};

bool is_of_lidar(const std::string& kind) { return kind == "lidar_bias" || kind == "dropout" || kind == "covered"; }

InjectedFault draw_fault(const std::string& name, Draws& draws, const backend::Features& features) {
  using enum SensorType;
  InjectedFault fault;
  const bool is_bias = name == "lidar_bias" || name == "gyro_bias";
  const auto known = std::ranges::find(kFaultNames, is_bias ? std::string("bias") : name);
  fault.kind = static_cast<FaultKind>(known - kFaultNames.begin());
  std::vector<SensorType> types = {lidar, imu, odometry, ultrasonic};
  if (name == "noise") types = {lidar, imu, ultrasonic};
  if (is_of_lidar(name)) types = {lidar};
  if (name == "gyro_bias") types = {imu};
  if (fault.kind >= FaultKind::slip) types = {odometry};
  fault.sensor = draw_sensor(draws, features, types);
  switch (fault.kind) {
    case FaultKind::stamps_back:
    case FaultKind::stamps_ahead: fault.size = 0.3 * std::pow(30.0, draws.between(0.0, 1.0)); break;
    case FaultKind::noise: fault.size = 5.0; break;
    case FaultKind::bias: fault.size = draws.sign() * (name == "lidar_bias" ? 0.2 : 5.0 * exact::kPi / 180.0); break;
    case FaultKind::delay:
    case FaultKind::delay_restamped: fault.size = 0.5; break;
    case FaultKind::dropout: fault.size = kDropouts.at(draws.below(kDropouts.size())); break;
    case FaultKind::covered:
      fault.size = 0.5 * exact::kPi;
      fault.bearing = draws.below(2) == 0 ? 0.0 : draws.between(-exact::kPi, exact::kPi);
      break;
    default: break;
  }
  fault.wheel = draws.below(4);
  fault.seed = draws.below(1U << 30U);
  return fault;
}

// What came of one fault.
struct Outcome {
  std::string kind;
  InjectedFault fault;
  std::string sensor;
  double moved = 0.0;             // [s] of moving from its beginning until it was noticed
  std::optional<double> noticed;  // [s] after its beginning, by whatever sensor
  std::string reported;           // and what was said of it
  bool named = false;             // the right sensor is among those at fault
  std::optional<double> stopped;  // [s] after it was noticed
};

bool blames(const Outcome& outcome, const SensorHealth& health) {
  return !health.ok() && health.name == outcome.sensor;
}

void look(Outcome& outcome, Place& place) {
  if (place.now() <= outcome.fault.from) return;
  const double since = to_seconds(place.now() - outcome.fault.from);
  const bool moving = moves(place.truth().true_velocity());
  if (place.now() <= outcome.fault.until) {
    if (!outcome.noticed && moving) outcome.moved += to_seconds(kControlPeriod);
    for (const SensorHealth& health : place.robot().health()) {
      if (health.ok()) continue;
      if (!outcome.noticed) {
        outcome.noticed = since;
        outcome.reported = health.name + " " + std::string(to_string(health.fault));
      }
      outcome.named = outcome.named || blames(outcome, health);
    }
  }
  if (outcome.noticed && !outcome.stopped && !moving) outcome.stopped = since - *outcome.noticed;
}

std::string json(const std::optional<double>& value) { return value ? fmt::format("{:.3f}", *value) : "null"; }

std::string json(const Outcome& o, double rate, bool needed) {
  return fmt::format(
      R"({{"kind": "{}", "sensor": "{}", "size": {:.3f}, "rate": {:.3f}, "needed": {}, "noticed": {}, "moved": {:.3f}, "reported": "{}", "named": {}, "stopped": {}}})",
      o.kind, o.sensor, o.fault.size, rate, needed, json(o.noticed), o.moved, o.reported, o.named, json(o.stopped));
}

bool all_ok(Place& place) { return std::ranges::all_of(place.robot().health(), &SensorHealth::ok); }

// Ten seconds: on the way, then something breaks for a while, then all is well again.
void run_case(const std::vector<std::string>& kinds, std::uint64_t seed, Place& place) {
  place.begin(seed);
  Draws draws(seed);
  std::vector<Outcome> outcomes;
  std::vector<InjectedFault> faults;
  const backend::Features& features = place.robot().runtime().features();
  for (const std::string& kind : kinds) {
    Outcome outcome;
    outcome.kind = kind;
    outcome.fault = draw_fault(kind, draws, features);
    outcome.sensor = features.sensors[outcome.fault.sensor].name;
    // a lens may have been covered before anybody switched the robot on
    const bool at_once = (kind == "dropout" || kind == "covered") && draws.below(3) == 0;
    outcome.fault.from = place.now() + (at_once ? Duration{} : from_seconds(draws.between(2.0, 4.0)));
    outcome.fault.until = outcome.fault.from + 3s;
    faults.push_back(outcome.fault);
    outcomes.push_back(outcome);
  }
  place.break_with(faults);
  const Time end = place.now() + kCase;
  int alarms_before = 0;
  bool finite = true;
  double worst_error = 0.0;
  std::optional<double> recovered;
  const Time over = std::ranges::max(outcomes, {}, [](const Outcome& o) { return o.fault.until; }).fault.until;
  const Time begins = std::ranges::min(outcomes, {}, [](const Outcome& o) { return o.fault.from; }).fault.from;
  bool went_on = false;
  while (place.now() < end) {
    place.tick();
    if (place.now() <= begins && !all_ok(place)) ++alarms_before;
    for (Outcome& outcome : outcomes) look(outcome, place);
    finite = finite && is_finite(place.robot().runtime().commanded().command);
    worst_error = std::max(worst_error, place.error());
    if (place.now() > over && !recovered && all_ok(place)) recovered = to_seconds(place.now() - over);
    if (place.now() > over && moves(place.truth().true_velocity())) went_on = true;
  }
  std::string told;
  for (const Outcome& o : outcomes) {
    const SensorHealth& health = place.robot().health()[o.fault.sensor];
    told += (told.empty() ? "" : ", ") + json(o, features.sensors[o.fault.sensor].rate, health.needed);
  }
  fmt::print(
      R"({{"scene": "{}", "hardware": "{}", "seed": {}, "faults": [{}], "contact": {:.3f}, "worst_error": {:.3f}, "error": {:.3f}, "finite": {}, "alarms_before": {}, "recovered": {}, "went_on": {}, "fault": "{}"}})"
      "\n",
      place.scene, place.hardware, seed, told, place.truth().max_collision_speed(), worst_error, place.error(), finite,
      alarms_before, json(recovered), went_on, place.robot().runtime().fault());
}

// A corridor in which a lidar cannot tell how far along it is. Returns the file.
std::string bare_corridor(double width) {
  const std::string name = fmt::format("bare_corridor_{}", static_cast<int>(100.0 * width));
  const auto file = std::filesystem::temp_directory_path() / (name + ".yaml");
  std::ofstream(file) << fmt::format(
      "name: {2}\ndescription: A bare corridor of 60 m\nstarts:\n  - [30.0, {1:.2f}, 0]\nrooms:\n"
      "  - {{name: corridor, min: [0, 0], max: [60, {0:.2f}], floor: vinyl, anchor: [30.0, {1:.2f}]}}\nwalls:\n"
      "  - {{a: [0, 0], b: [60, 0], thickness: 0.15}}\n  - {{a: [60, 0], b: [60, {0:.2f}], thickness: 0.15}}\n"
      "  - {{a: [60, {0:.2f}], b: [0, {0:.2f}], thickness: 0.15}}\n  - {{a: [0, {0:.2f}], b: [0, 0], thickness: "
      "0.15}}\n",
      width, 0.5 * width, name);
  return file.string();
}

// Where the robot is driven straight ahead and back, if at all, and then drives from goal to goal.
void drive_straight(Time begun, Place& place) {
  constexpr Duration kPeriod = 20s;
  constexpr Duration kWay = 4s;
  const Duration phase = (place.now() - begun) % kPeriod;
  if (phase >= 2 * kWay || !place.robot().runtime().fault().empty()) return;
  place.robot().stop();
  place.robot().set_velocity(phase < kWay ? 0.2 : -0.2, 0.0, 0.0);
}

// Nothing breaks.
void run_clean(std::uint64_t seed, Duration duration, Place& place, bool straight = false) {
  place.begin(seed);
  const Time begun = place.now();
  std::vector<std::string> alarms;
  std::vector<bool> ok(place.robot().health().size(), true);
  while (place.now() - begun < duration) {
    if (straight) drive_straight(begun, place);
    place.tick(straight);
    for (std::size_t i = 0; i < ok.size(); ++i) {
      const SensorHealth& health = place.robot().health()[i];
      if (ok[i] && !health.ok()) {
        alarms.push_back(fmt::format(R"("{:.2f} s: {} {} {}")", to_seconds(place.now() - begun), health.name,
                                     to_string(health.fault), health.detail));
      }
      ok[i] = health.ok();
    }
  }
  fmt::print(
      R"({{"scene": "{}", "hardware": "{}", "seed": {}, "seconds": {}, "alarms": [{}], "error": {:.3f}, "contact": {:.3f}}})"
      "\n",
      place.scene, place.hardware, seed, to_seconds(place.now() - begun), fmt::join(alarms, ", "), place.error(),
      place.truth().max_collision_speed());
}

// Of all shipped robots with a lidar: one without bumps into things, whereupon gyro and wheels do contradict each
// other. SonarReturns without noise repeat themselves along any wall, which looks frozen.
void run_honest(std::uint64_t seed, Duration duration, Draws& draws) {
  backend::WorldOptions options;
  const bool ideal = draws.below(2) == 0;
  options.noise = ideal ? NoiseLevel::ideal : NoiseLevel::realistic;
  options.randomization = !ideal && draws.below(2) == 0 ? "hard" : "none";
  std::vector<std::string> robots = profile_names();
  std::erase_if(robots, [ideal](const std::string& name) {
    const RobotProfile profile = load_profile(name);
    return !profile.lidar || (ideal && profile.ultrasonics);
  });
  const std::string& hardware = robots[draws.below(robots.size())];
  const bool bare = draws.below(3) == 0;
  Place place(bare ? bare_corridor(draws.between(1.2, 3.0)) : kScenes[draws.below(kScenes.size())], hardware, options);
  run_clean(seed, duration, place, true);
}

}  // namespace

int main(int argc, char** argv) {
  const bool complete = argc == 4 || argc == 5;
  const std::string what = complete ? argv[1] : "";
  const auto seed = parse_number(complete ? argv[2] : "");
  const auto count = parse_number(complete ? argv[3] : "");
  const bool known =
      what == "clean" || what == "honest" || what == "pair" || std::ranges::find(kKinds, what) != kKinds.end();
  if (!seed || !count || !known) {
    std::fputs("usage: verify_faults KIND|pair SEED COUNT [SCENE] | clean|honest SEED SECONDS\n", stderr);
    return 2;
  }
  set_warning_handler([](std::string_view) {});
  Draws draws(*seed);
  if (what == "honest") {
    run_honest(*seed, std::chrono::seconds(*count), draws);
    return 0;
  }
  const std::string& named = kScenes[draws.below(kScenes.size())];
  const std::string scene = argc == 5 ? argv[4] : named;
  const double which = draws.between(0.0, 1.0);
  // without a lidar nothing tells how far a robot goes but its wheels: that all of them slip alike it cannot know
  const bool blind = which > 0.8 && !is_of_lidar(what) && what != "slip" && what != "clean";
  Place place(scene, blind ? "3we_base_v2" : which > 0.6 ? "turtlebot_like" : "3we_standard_v2");
  std::vector<std::string> kinds = kKinds;
  if (blind) std::erase_if(kinds, [](const std::string& kind) { return is_of_lidar(kind) || kind == "slip"; });
  if (what == "clean") {
    run_clean(*seed, std::chrono::seconds(*count), place);
    return 0;
  }
  for (std::uint64_t i = 0; i < *count; ++i) {
    std::vector<std::string> broken = {what};
    if (what == "pair") broken = {kinds[draws.below(kinds.size())], kinds[draws.below(kinds.size())]};
    run_case(broken, *seed * 1000003 + i, place);
  }
  return 0;
}
