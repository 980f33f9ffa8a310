#include "gazebo/robot.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <thread>
#include <type_traits>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "backend/simulated/port.hpp"
#include "core/exact.hpp"
#include "hardware/sample_checks.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::gazebo {
namespace {

using Call = backend::PluginRequest::Call;
using namespace std::string_literals;

// Patience [wall].
constexpr Duration kReach = 6s;      // until all topics are found: they are said anew each second
constexpr Duration kAnswer = 5s;     // of a service
constexpr Duration kStall = 10s;     // of a world that does not step, or of an image that is not drawn
constexpr Duration kAwake = 40s;     // of sensors whose rendering is still starting
constexpr Duration kReload = 100ms;  // after a reset, until what was said of systems that were loaded anew has come

// Simulated before an episode begins: wheels come to rest on the floor, velocities forget that the robot was put down.
constexpr Duration kSettle = 200ms;
constexpr Duration kLook = 100ms;          // simulated between two looks at which sensors have begun
constexpr double kStandsThere = 0.05;      // [m] and [rad] that a robot may be off from where it was put
constexpr Duration kBeforeContact = 10ms;  // when a contact's speed is taken: a step later it has braked already
constexpr Duration kSilent = 1s;           // simulated without a reading of a sensor that is not drawn

constexpr std::string_view kWorld = "/world/";
constexpr const char* kCommand = "/cmd_vel";
constexpr const char* kTruth = "/true_odom";
constexpr const char* kContacts = "/contacts";

// From update to update of a sensor, in whole milliseconds: gz-sensors cuts off the rest.
Duration period_of(Duration period) {
  const double rate = 1.0 / to_seconds(period);
  return std::max<Duration>(std::chrono::milliseconds(static_cast<std::int64_t>(1e3 * (1.0 / rate))), 1ms);
}

std::string seconds(Duration d) { return fmt::format("{:.3f} s", to_seconds(d)); }

msgs::Twist to_twist(const Velocity& velocity) {
  return {.linear = {velocity.vx, velocity.vy, 0.0}, .angular = {0.0, 0.0, velocity.omega}};
}

// When a sensor's update after the one of `newest` is measured, by steps of the world.
Time next_due(Time newest, Duration period, Duration step) {
  const Time nominal = (newest / period + 1) * period;
  return (nominal + step - Duration{1}) / step * step;
}

}  // namespace

backend::Features features_of(const RobotProfile& profile) {
  backend::Features features = backend::simulated::features_of(profile);
  features.deterministic = features.can_save = false;
  std::erase_if(features.sensors, [](const SensorInfo& sensor) { return sensor.type == SensorType::battery; });
  return features;
}

Robot::Robot(std::shared_ptr<backend::PluginLink> mailbox, Settings settings, const std::string& world, Pose2D start)
    : mailbox_(std::move(mailbox)),
      settings_(std::move(settings)),
      profile_(mailbox_->profile()),
      world_(std::string(kWorld) + world),
      start_(start) {}

void Robot::run() {
  while (const auto request = mailbox_->take()) {
    try {
      backend::PluginReply reply;
      switch (request->call) {
        case Call::connect: connect(); break;
        case Call::disconnect: disconnect(); break;
        case Call::step: reply.readings = step(request->t, request->velocity); break;
        case Call::reset: reset(request->pose); break;
        case Call::truth: reply.truth = truth(); break;
        case Call::save:
        case Call::restore: break;  // not claimed, and so not asked for
      }
      mailbox_->answer(std::move(reply));
    } catch (const std::exception& error) {
      mailbox_->fail(error.what());
    }
  }
}

// Connecting.

void Robot::connect() {
  try {
    subscribe();
    find_all();
    const Time before = time_;
    pause();
    if (begun_) {
      const std::scoped_lock lock(mutex_);
      origin_ += time_ - before;  // robot time goes on, whatever the simulator did in the meantime
      for (Source& source : sources_) source.newest = time_;
      readings_.clear();
    } else {
      measure_step();
      hear_all();  // rendering takes Gazebo a while to start
      reset(start_);
    }
  } catch (...) {
    node_.reset();
    throw;
  }
}

void Robot::subscribe() {
  {
    const std::scoped_lock lock(mutex_);
    make_sources();
    clocks_ = repeats_ = 0;
    known_ = false;
    odom_from_theirs_.reset();
  }
  node_ = std::make_unique<Node>(settings_);
  node_->subscribe(world_ + "/clock", msgs::Clock::kType, [this](ByteView bytes) { receive_clock(bytes); });
  node_->subscribe(kTruth, msgs::Odometry::kType, [this](ByteView bytes) { receive_truth(bytes); });
  node_->subscribe(kContacts, msgs::Contacts::kType, [this](ByteView bytes) { receive_contacts(bytes); });
  for (std::size_t i = 0; i < sources_.size(); ++i) {
    node_->subscribe(sources_[i].topic, sources_[i].type, [this, i](ByteView bytes) { receive(i, bytes); });
  }
  node_->look_for(world_ + "/control");
  node_->look_for(world_ + "/set_pose");
  node_->advertise(kCommand, msgs::Twist::kType);
}

/// Finds the world and all of its topics.
void Robot::find_all() {
  const auto give_up = WallClock::now() + kReach;
  for (std::string still = missing(); !still.empty(); still = missing()) {
    if (WallClock::now() > give_up) throw ConnectionError(still);
    std::unique_lock lock(mutex_);
    arrived_.wait_for(lock, 5ms);
  }
}

void Robot::make_sources() {
  sources_.clear();
  pictures_.reset();
  if (profile_.camera) pictures_.emplace(*profile_.camera);
  const auto add = [this]<typename M>(std::type_identity<M>, const std::string& sensor, const std::string& topic,
                                      bool drawn, Duration period, auto convert) -> Source& {
    Source& source = sources_.emplace_back();
    source.sensor = sensor;
    source.topic = "/" + topic;
    source.type = M::kType;
    source.period = period_of(period);
    source.drawn = drawn;
    source.read = [convert](ByteView bytes) -> std::optional<ReadingOrMistake> {
      auto message = decode<M>(bytes);
      if (!message) return tl::unexpected(fmt::format("bytes that are no {}", M::kType));
      return convert(std::move(*message));
    };
    return source;
  };
  using std::type_identity;
  std::int64_t ping = 0;
  for (const SensorInfo& sensor : mailbox_->features().sensors) {
    switch (sensor.type) {
      case SensorType::lidar:
        add(type_identity<msgs::LaserScan>(), sensor.name, sensor.name, true, profile_.lidar->turn,
            [this](const msgs::LaserScan& scan) { return to_reading(scan, *profile_.lidar); });
        break;
      case SensorType::imu:
        add(type_identity<msgs::Imu>(), sensor.name, sensor.name, false, profile_.imu->period,
            [](const msgs::Imu& imu) { return to_reading(imu); });
        break;
      case SensorType::odometry:
        add(type_identity<msgs::Odometry>(), sensor.name, "odom", false, profile_.odometry.period,
            [](const msgs::Odometry& odometry) { return to_reading(odometry); });
        break;
      case SensorType::ultrasonic: {
        // Gazebo's are updated at once, each interval: one of them pings
        Source& source =
            add(type_identity<msgs::LaserScan>(), sensor.name, sensor.name, true, profile_.ultrasonics->interval,
                [this](const msgs::LaserScan& scan) { return to_reading(scan, *profile_.ultrasonics); });
        source.turn = ping++;
        source.turns = std::ssize(profile_.ultrasonics->mounts);
        break;
      }
      case SensorType::camera: {
        const bool with_depth = profile_.camera->depth.has_value();
        add(type_identity<msgs::Image>(), sensor.name, sensor.name + (with_depth ? "/image" : ""), true,
            profile_.camera->period, [this](msgs::Image image) { return pictures_->add_color(std::move(image)); });
        if (with_depth) {
          add(type_identity<msgs::Image>(), sensor.name, sensor.name + "/depth_image", true, profile_.camera->period,
              [this](msgs::Image image) { return pictures_->add_depth(std::move(image)); });
        }
        break;
      }
      case SensorType::battery: break;
    }
  }
}

/// What of the world is not there; empty where all of it is.
std::string Robot::missing() const {
  const std::string service = world_ + "/control";
  const std::string types = fmt::format("{} -> {}", msgs::WorldControl::kType, msgs::Boolean::kType);
  const std::string found = node_->service_types(service);
  if (found.empty()) return other_worlds();
  if (found != types) return fmt::format("{} is a service {}, not {}", service, found, types);
  if (const std::size_t count = node_->offers(service); count > 1) {
    return fmt::format("{} simulators run the world '{}': give one a GZ_PARTITION of its own", count,
                       world_.substr(kWorld.size()));
  }

  std::vector<std::string> absent;
  if (node_->service_types(world_ + "/set_pose").empty()) {
    absent.push_back(fmt::format("reset: there is no service {}/set_pose", world_));
  }
  const auto look = [&](const std::string& what, const std::string& topic, const std::string& type) {
    const std::string there = node_->type_of(topic);
    if (there.empty()) absent.push_back(fmt::format("{}: nothing is published on {}", what, topic));
    if (!there.empty() && there != type) {
      absent.push_back(fmt::format("{}: {} carries {}, not {}", what, topic, there, type));
    }
    if (const std::size_t count = node_->publishers(topic, type); count > 1) {
      absent.push_back(fmt::format("{}: {} publish on {}: each needs a topic of its own", what, count, topic));
    }
  };
  look("clock", world_ + "/clock", msgs::Clock::kType);
  look("truth", kTruth, msgs::Odometry::kType);
  look("contacts", kContacts, msgs::Contacts::kType);
  for (const Source& source : sources_) look(source.sensor, source.topic, source.type);
  if (!node_->is_taken(kCommand)) absent.push_back(fmt::format("command: nothing subscribes to {}", kCommand));
  if (absent.empty()) {
    const std::scoped_lock lock(mutex_);
    return clocks_ > 0 ? "" : fmt::format("{}/clock is silent", world_);
  }
  return fmt::format(
      "Gazebo's {} is not as `threewe gazebo launch` and `threewe export --format sdf` make it for '{}':\n  {}",
      world_.substr(1), profile_.name, fmt::join(absent, "\n  "));
}

/// Where the world is not there: what is.
std::string Robot::other_worlds() const {
  std::vector<std::string> worlds;
  std::vector<std::string> partitions;
  for (const auto& [partition, service] : node_->services()) {
    constexpr std::string_view kAfter = "/control";
    if (!service.starts_with(kWorld) || !service.ends_with(kAfter)) continue;
    const std::size_t length = service.size() - kWorld.size() - kAfter.size();
    const std::string name = service.substr(kWorld.size(), length);
    if (partition == settings_.partition) {
      worlds.push_back(fmt::format("'{}'", name));
    } else {
      partitions.push_back(fmt::format("'{}' in partition '{}'", name, partition));
    }
  }
  const std::string ours = world_.substr(kWorld.size());
  if (!worlds.empty()) {
    return fmt::format("Gazebo runs the world {}, not '{}': is `scene` right?", fmt::join(worlds, ", "), ours);
  }
  if (!partitions.empty()) {
    return fmt::format("Gazebo runs the world {}; this process is in partition '{}': set GZ_PARTITION alike",
                       fmt::join(partitions, ", "), settings_.partition);
  }
  return fmt::format(
      "no Gazebo was found within {:.0f} s, in partition '{}': start it with\n"
      "threewe gazebo launch --scene {} --robot {}",
      to_seconds(kReach), settings_.partition, ours, profile_.name);
}

void Robot::measure_step() {
  drive({});
  const Time before = time_;
  control(1);
  wait_for_clock([&] { return clock_ > before; }, "a first step");
  pause();
  step_ = time_ - before;
  if (step_ <= Duration{}) {
    fail(fmt::format("Gazebo's clock went from {} to {} in a step", seconds(before), seconds(time_)));
  }
}

/// Simulates until every sensor has delivered.
void Robot::hear_all() {
  const Time begin = time_;
  const auto give_up = WallClock::now() + kAwake;
  for (Silent silent = silent_ones(); !silent.ones.empty(); silent = silent_ones()) {
    if (WallClock::now() > give_up || (silent.wrong && time_ > begin + kSilent)) {
      throw ConnectionError(fmt::format("Gazebo's sensors do not deliver:\n  {}", fmt::join(silent.ones, "\n  ")));
    }
    simulate(time_ + kLook);
  }
}

Robot::Silent Robot::silent_ones() const {
  const std::scoped_lock lock(mutex_);
  Silent silent;
  const auto add = [&](const std::string& what, const std::string& topic, const std::string& mistake) {
    silent.wrong = silent.wrong || !mistake.empty();
    silent.ones.push_back(mistake.empty() ? fmt::format("{}: nothing has come on {}", what, topic)
                                          : fmt::format("{}: {} delivers {}", what, topic, mistake));
  };
  for (const Source& source : sources_) {
    if (!source.delivered) add(source.sensor, source.topic, source.mistake);
  }
  if (!truth_) add("truth", kTruth, truth_mistake_);
  return silent;
}

void Robot::disconnect() {
  if (!node_) return;
  try {
    drive({});
  } catch (const ConnectionError&) {  // NOLINT(bugprone-empty-catch)
    // a simulator that is gone drives no robot
  }
  node_.reset();
}

// Stepping.

std::vector<backend::PluginReading> Robot::step(Time t, const Velocity& velocity) {
  drive(velocity);
  simulate(origin_ + t);
  wait_for_drawn();
  return take_readings();
}

/// Sends a velocity that differs from the last, and makes sure that it has arrived before what follows.
void Robot::drive(const Velocity& velocity) {
  if (known_ && velocity == commanded_) return;
  known_ = false;
  node_->publish(kCommand, msgs::Twist::kType, encode(to_twist(velocity)));
  // topics confirm nothing; the service's answer has passed through the same threads after it
  control();
  commanded_ = velocity;
  known_ = true;
}

/// Pauses the world, after so many steps or a reset.
void Robot::control(std::uint32_t steps, const std::optional<msgs::WorldReset>& reset) {
  const msgs::WorldControl control{.pause = true, .multi_step = steps, .reset = reset};
  ask("/control", msgs::WorldControl::kType, encode(control));
}

/// Asks a service of the world that answers yes.
void Robot::ask(const std::string& service, const char* type, ByteView request) {
  const std::string name = world_ + service;
  Bytes reply;
  try {
    reply = node_->request(name, type, msgs::Boolean::kType, request,
                           std::chrono::duration_cast<std::chrono::milliseconds>(kAnswer));
  } catch (const ConnectionError&) {
    if (node_->offers(name) > 0) throw;
    throw ConnectionError(fmt::format("Gazebo has gone: nothing answers {} any more", name));
  }
  const auto answer = decode<msgs::Boolean>(reply);
  if (!answer || !answer->data) throw ConnectionError(fmt::format("Gazebo refused {}", name));
}

/// Stops the clock, and takes down where.
void Robot::pause() {
  control();
  const auto give_up = WallClock::now() + kAnswer;
  wait_for_clock([&] { return repeats_ > 1 || WallClock::now() > give_up; }, "to pause");
  std::unique_lock lock(mutex_);
  if (repeats_ < 2) {
    lock.unlock();
    fail(fmt::format("Gazebo does not pause {}: does another program run it?", world_));
  }
  time_ = clock_;
}

/// Throws what is wrong with the world's topics by now, or else what was seen of it.
void Robot::fail(const std::string& seen) const {
  const std::string cause = missing();
  throw ConnectionError(cause.empty() ? seen : cause);
}

/// Runs the steps that end by then; less than one is left for the next time.
void Robot::simulate(Time until) {
  const auto steps = (until - time_) / step_;
  if (steps <= 0) return;
  const Time end = time_ + steps * step_;
  control(static_cast<std::uint32_t>(steps));
  wait_for_clock([&] { return clock_ > end || (clock_ == end && repeats_ > 0); },
                 fmt::format("{} steps, from {} to {}", steps, seconds(time_), seconds(end)));
  std::unique_lock lock(mutex_);
  const Time clock = clock_;
  lock.unlock();
  if (clock > end) {
    fail(fmt::format(
        "Gazebo's clock stands at {} where {} was asked for: does another program, or its window, run the world?",
        seconds(clock), seconds(end)));
  }
  time_ = end;
}

/// Waits for the clock; what has not happened by then is a fault, named by what became of the simulator.
void Robot::wait_for_clock(const std::function<bool()>& reached, const std::string& what) {
  std::unique_lock lock(mutex_);
  Time last = clock_;
  auto moved = WallClock::now();
  while (!reached()) {
    arrived_.wait_for(lock, 100ms);
    const auto now = WallClock::now();
    if (std::exchange(last, clock_) != clock_) moved = now;
    const std::string stands = fmt::format("its clock stands at {}", seconds(clock_));
    lock.unlock();
    if (node_->type_of(world_ + "/clock").empty()) {
      throw ConnectionError(fmt::format("Gazebo has gone, while it was asked for {}: {}", what, stands));
    }
    if (now - moved > kStall) {
      throw ConnectionError(fmt::format("Gazebo does not step, though it was asked for {}: {}", what, stands));
    }
    lock.lock();
  }
}

/// Waits for what is due by now of sensors that are drawn.
void Robot::wait_for_drawn() {
  std::unique_lock lock(mutex_);
  const auto give_up = WallClock::now() + kStall;
  for (const Source& source : sources_) {
    if (!source.drawn) {
      if (time_ - source.newest <= std::max(kSilent, 5 * source.period)) continue;
      throw ConnectionError(fmt::format("{}: nothing has come on {} since {}; the clock stands at {}", source.sensor,
                                        source.topic, seconds(source.newest), seconds(time_)));
    }
    for (Time due = next_due(source.newest, source.period, step_); due <= time_;
         due = next_due(source.newest, source.period, step_)) {
      if (source.newest < due) arrived_.wait_until(lock, give_up);
      if (source.newest >= due || WallClock::now() < give_up) continue;
      throw ConnectionError(fmt::format("{}: what was due at {} has not come on {} within {:.0f} s{}", source.sensor,
                                        seconds(due), source.topic, to_seconds(kStall),
                                        source.mistake.empty() ? "" : ": it delivers " + source.mistake));
    }
  }
}

/// What was measured until now, by robot time.
std::vector<backend::PluginReading> Robot::take_readings() {
  const std::scoped_lock lock(mutex_);
  std::vector<Arrived> arrived = std::exchange(readings_, {});
  std::ranges::stable_sort(arrived, [](const Arrived& a, const Arrived& b) {
    return std::pair(a.reading.stamp, a.source) < std::pair(b.reading.stamp, b.source);
  });
  std::vector<backend::PluginReading> readings;
  for (Arrived& one : arrived) {
    if (one.reading.stamp <= origin_) continue;  // of before the episode
    if (auto* odometry = std::get_if<Odometry>(&one.reading.data)) {
      // it begins at its own origin, and goes on from where it was when the simulator begins anew
      if (!odom_from_theirs_) odom_from_theirs_ = odom_from_base_ * inverse(odometry->pose);
      odometry->pose = odom_from_base_ = *odom_from_theirs_ * odometry->pose;
    }
    readings.push_back({.sensor = sources_[one.source].sensor,
                        .measured = one.reading.stamp - origin_,
                        .data = std::move(one.reading.data)});
  }
  return readings;
}

// Episodes.

void Robot::reset(const std::optional<Pose2D>& pose) {
  if (!node_) {  // before it was connected: it begins there
    if (pose) start_ = *pose;
    begun_ = false;
    return;
  }
  drive({});
  control(0, msgs::WorldReset{.all = true});
  const std::uint64_t answered = [this] {
    const std::scoped_lock lock(mutex_);
    return clocks_;
  }();
  wait_for_clock([&] { return clock_ == Time{} && repeats_ > 1 && clocks_ > answered + 3; }, "a reset");
  time_ = {};
  // most of Gazebo's systems are loaded anew by it: their topics and services end and begin
  std::this_thread::sleep_for(kReload);
  find_all();
  put_down(pose.value_or(Pose2D{}));
  begin();
}

void Robot::put_down(const Pose2D& pose) {
  const auto [sin, cos] = exact::sincos(0.5 * pose.theta);
  const msgs::Pose there{.name = profile_.name, .position = {pose.x, pose.y, 0.0}, .orientation = {0.0, 0.0, sin, cos}};
  ask("/set_pose", msgs::Pose::kType, encode(there));
  {
    const std::scoped_lock lock(mutex_);
    for (Source& source : sources_) {
      source.newest = {};
      source.delivered = false;
    }
    readings_.clear();
    truth_.reset();
    recent_.clear();
    repeats_ = 0;
  }
  wait_for_clock([this] { return repeats_ > 2; }, "a robot to be put down");  // queued, too
  simulate(time_ + kSettle);
  hear_all();
  const std::scoped_lock lock(mutex_);
  const Pose2D off = inverse(pose) * truth_->pose;
  if (norm(off.position()) > kStandsThere || std::abs(off.theta) > kStandsThere) {
    throw ConnectionError(
        fmt::format("put down at ({:.2f}, {:.2f}, {:.2f}), the model '{}' stands at ({:.2f}, {:.2f}, "
                    "{:.2f}): is there room for it?",
                    pose.x, pose.y, pose.theta, profile_.name, truth_->pose.x, truth_->pose.y, truth_->pose.theta));
  }
}

/// Robot time begins, with a robot at rest whose sensors have delivered.
void Robot::begin() {
  wait_for_drawn();
  const std::scoped_lock lock(mutex_);
  begun_ = true;
  origin_ = time_;
  start_ = truth_->pose;
  distance_ = collision_speed_ = 0.0;
  odom_from_base_ = {};
  odom_from_theirs_.reset();
  for (const Arrived& one : readings_) {
    if (const auto* odometry = std::get_if<Odometry>(&one.reading.data)) odom_from_theirs_ = inverse(odometry->pose);
  }
  readings_.clear();
}

backend::PluginTruth Robot::truth() {
  const std::scoped_lock lock(mutex_);
  backend::PluginTruth truth{.start = start_, .pose = start_, .velocity = {}};
  if (begun_ && truth_) {
    truth.pose = truth_->pose;
    truth.velocity = truth_->velocity;
    truth.distance_driven = distance_;
    truth.max_collision_speed = collision_speed_;
  }
  return truth;
}

// In the node's thread.

void Robot::receive_clock(ByteView message) {
  const auto clock = decode<msgs::Clock>(message);
  if (!clock) return;
  const Time time = msgs::to_time(clock->sim);
  const std::scoped_lock lock(mutex_);
  repeats_ = clocks_ > 0 && time == clock_ ? repeats_ + 1 : 0;
  clock_ = time;
  ++clocks_;
  arrived_.notify_all();
}

void Robot::receive_truth(ByteView message) {
  const auto odometry = decode<msgs::Odometry>(message);
  auto reading = odometry ? to_reading(*odometry) : tl::unexpected("bytes that are no "s + msgs::Odometry::kType);
  const std::scoped_lock lock(mutex_);
  if (!reading) {
    truth_mistake_ = reading.error();
    return;
  }
  const auto& [pose, velocity] = std::get<Odometry>(reading->data);
  if (truth_) distance_ += distance(truth_->pose.position(), pose.position());
  truth_ = Truth{reading->stamp, pose, velocity};
  recent_.push_back(*truth_);
  while (recent_.front().stamp < reading->stamp - 2 * kBeforeContact) recent_.pop_front();
}

/// A contact's speed is the robot's own, along the contact's normal, just before it.
void Robot::receive_contacts(ByteView message) {
  const auto contacts = decode<msgs::Contacts>(message);
  const std::scoped_lock lock(mutex_);
  if (!contacts) return;
  const Time before = msgs::to_time(contacts->header.stamp) - kBeforeContact;
  const auto later = std::ranges::find_if(recent_, [&](const Truth& truth) { return truth.stamp > before; });
  if (later == recent_.begin()) return;  // nothing is known of the time before
  const Truth& truth = *std::prev(later);
  const Vec2 velocity = rotate({truth.velocity.vx, truth.velocity.vy}, truth.pose.theta);
  for (const msgs::Contact& contact : contacts->contacts) {
    for (const msgs::Vector3d& normal : contact.normals) {
      const double speed = std::abs(dot(velocity, {normal.x, normal.y}));
      if (std::isfinite(speed)) collision_speed_ = std::max(collision_speed_, speed);
    }
  }
}

void Robot::receive(std::size_t index, ByteView message) {
  const std::scoped_lock lock(mutex_);
  Source& source = sources_[index];
  auto reading = source.read(message);
  if (!reading) return;  // of a picture, the other half is to come
  if (!*reading) {
    source.mistake = reading->error();
    return;
  }
  const auto& sensors = mailbox_->features().sensors;
  const auto sensor = std::ranges::find(sensors, source.sensor, &SensorInfo::name);
  try {
    check_data(*sensor, (*reading)->data, profile_);
  } catch (const ContractError& error) {
    source.mistake = error.what();
    return;
  }
  // both images of a picture came with it
  bool is_new = true;
  for (Source& same : sources_) {
    if (same.sensor != source.sensor) continue;
    if ((*reading)->stamp <= same.newest && same.delivered && same.newest > Time{}) is_new = false;
    same.newest = std::max(same.newest, (*reading)->stamp);
    same.delivered = true;
  }
  if ((*reading)->stamp / source.period % source.turns != source.turn) is_new = false;
  if (is_new) readings_.push_back({index, std::move(**reading)});
  arrived_.notify_all();
}

}  // namespace threewe::gazebo
