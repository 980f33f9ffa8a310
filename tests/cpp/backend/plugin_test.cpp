// What a plug-in may do wrong, and what becomes of the robot then.
#include "backend/plugin.hpp"

#include <atomic>
#include <cmath>
#include <condition_variable>
#include <limits>
#include <mutex>
#include <set>
#include <thread>

#include <doctest/doctest.h>

#include "backend/toy_plugin.hpp"
#include "core/exact.hpp"

namespace threewe::backend {
namespace {

using testing::Handler;
using testing::plugin_world;
using Call = PluginRequest::Call;

constexpr Velocity kForward{0.3, 0.0, 0.0};

RobotProfile standard() { return load_profile("3we_standard_v2"); }
Features features() { return testing::ToyRobot::features(standard()); }
Features realtime_features() {
  Features realtime = features();
  realtime.lockstep = realtime.deterministic = realtime.can_save = false;
  return realtime;
}

/// An honest plug-in that records what it was asked.
struct Recorder {
  std::mutex mutex;
  std::condition_variable changed;
  std::vector<PluginRequest> requests;
  Handler honest = testing::ToyRobot(standard(), NoiseLevel::ideal, 0);

  PluginReply operator()(const PluginRequest& request) {
    {
      const std::scoped_lock lock(mutex);
      requests.push_back(request);
    }
    changed.notify_all();
    return honest(request);
  }
  int count(Call call) {
    const std::scoped_lock lock(mutex);
    return static_cast<int>(
        std::count_if(requests.begin(), requests.end(), [call](const auto& request) { return request.call == call; }));
  }
  Velocity last_velocity() {
    const std::scoped_lock lock(mutex);
    return requests.back().velocity;
  }
  /// Waits until `condition` holds for a request.
  template <typename Condition>
  void wait_for(Condition condition) {
    std::unique_lock lock(mutex);
    changed.wait(lock, [&] { return std::any_of(requests.begin(), requests.end(), condition); });
  }
};

/// A gate that a plug-in can hang at.
struct Gate {
  std::mutex mutex;
  std::condition_variable changed;
  bool open = false;
  void wait() {
    std::unique_lock lock(mutex);
    changed.wait(lock, [this] { return open; });
  }
  void release() {
    const std::scoped_lock lock(mutex);
    open = true;
    changed.notify_all();
  }
};

std::unique_ptr<World> recorded(const std::shared_ptr<Recorder>& recorder, Features with = features()) {
  return plugin_world(std::move(with), standard(), [recorder](const auto& request) { return (*recorder)(request); });
}

/// A world whose plug-in does `bad` when asked for `call`, and is honest else.
std::unique_ptr<World> misbehaving(Call call, const Handler& bad, Duration patience = 2s, Features with = features()) {
  auto honest = std::make_shared<Recorder>();
  // NOLINTNEXTLINE(clang-analyzer-cplusplus.NewDeleteLeaks): it loses sight of a shared_ptr in a function object
  Handler handler = [call, bad, honest](const PluginRequest& request) {
    return request.call == call ? bad(request) : (*honest)(request);
  };
  return plugin_world(std::move(with), standard(), std::move(handler), patience);
}

/// A world whose plug-in answers each step with one reading that `spoil` has changed.
template <typename Data>
std::unique_ptr<World> answering(const Data& data, const std::function<void(PluginReading&, Data&)>& spoil) {
  return misbehaving(Call::step, [data, spoil](const PluginRequest& request) {
    constexpr std::array<const char*, 4> kNames = {"lidar", "imu", "odometry", "battery"};
    PluginReading reading{kNames[SampleData(data).index()], request.t, {}};
    Data changed = data;
    spoil(reading, changed);
    if (reading.data.index() == 0) reading.data = changed;
    return PluginReply{{reading}, {}};
  });
}

bool connects(World& world) {
  try {
    world.robot(0).connect();
    return true;
  } catch (const ConnectionError&) {
    return false;
  }
}

/// What the poll after a first period throws.
template <typename Error>
std::string poll_error(World& world) {
  world.robot(0).connect();
  world.robot(0).command(kForward, world.now() + 1s);
  world.advance_to(world.now() + kControlPeriod);
  try {
    world.robot(0).poll();
  } catch (const Error& error) {
    return error.what();
  }
  return "nothing thrown";
}

LaserScan good_scan() {
  const LidarSpec spec = *standard().lidar;
  return {.angle_min = 0.0,
          .angle_increment = 2.0 * exact::kPi / spec.beams,
          .time_increment = 0.0,
          .range_min = spec.range_min,
          .range_max = spec.range_max,
          .ranges = std::vector<float>(static_cast<std::size_t>(spec.beams), 1.0F)};
}

TEST_CASE("in lockstep a plug-in is asked once a period") {
  const auto recorder = std::make_shared<Recorder>();
  const auto world = recorded(recorder);
  world->robot(0).connect();
  for (int tick = 1; tick <= 10; ++tick) {
    world->robot(0).command(kForward, world->now() + 200ms);
    world->advance_to(tick * kControlPeriod);
    CHECK(recorder->count(Call::step) == tick);
    CHECK(recorder->last_velocity() == kForward);
  }
}

TEST_CASE("a command expires to the nanosecond, whatever the periods") {
  const auto recorder = std::make_shared<Recorder>();
  const auto world = recorded(recorder);
  world->robot(0).connect();
  world->robot(0).command(kForward, 33333333ns);
  world->advance_to(1s);
  Time driven{};
  Time last{};
  for (const PluginRequest& request : recorder->requests) {
    if (request.call != Call::step) continue;
    CHECK(request.t - last <= kControlPeriod);
    if (request.velocity != Velocity{}) driven = request.t;
    last = request.t;
  }
  CHECK(driven == 33333333ns);
  CHECK(last == 1s);
}

TEST_CASE("a plug-in never sees more than the hardware's limits") {
  const auto recorder = std::make_shared<Recorder>();
  const auto world = recorded(recorder);
  world->robot(0).connect();
  world->robot(0).command({30.0, 40.0, -50.0}, 1s);
  world->advance_to(20ms);
  const Limits limits = standard().hardware_limits;
  const Velocity seen = recorder->last_velocity();
  CHECK(seen.vx == doctest::Approx(0.6 * limits.linear));
  CHECK(seen.vy == doctest::Approx(0.8 * limits.linear));
  CHECK(seen.omega == -limits.angular);
}

TEST_CASE("a plug-in that raises is a fault that says so, and connecting again is a new attempt") {
  const auto failures = std::make_shared<std::atomic<int>>(1);
  const auto world = misbehaving(Call::step, [failures](const PluginRequest&) -> PluginReply {
    if ((*failures)-- > 0) throw std::runtime_error("the motor driver is gone");
    return {};
  });
  CHECK(poll_error<ConnectionError>(*world) == "backend 'toy': step() raised the motor driver is gone");
  CHECK_THROWS_AS(world->robot(0).command({}, 1s), ConnectionError);
  CHECK_THROWS_AS(world->robot(0).poll(), ConnectionError);
  world->advance_to(5s);
  CHECK(world->now() == 5s);

  world->robot(0).connect();
  world->advance_to(6s);
  CHECK(world->robot(0).poll().empty());
  world->robot(0).disconnect();
}

TEST_CASE("after a fault the plug-in is told to disconnect") {
  const auto recorder = std::make_shared<Recorder>();
  const auto world = plugin_world(features(), standard(), [recorder](const PluginRequest& request) -> PluginReply {
    (*recorder)(request);
    if (request.call == Call::step) throw std::runtime_error("broken");
    return {};
  });
  poll_error<ConnectionError>(*world);
  recorder->wait_for([](const PluginRequest& request) { return request.call == Call::disconnect; });
}

TEST_CASE("what raises outside of a step") {
  const Handler raise = [](const PluginRequest&) -> PluginReply { throw std::runtime_error("no"); };
  SUBCASE("connect") {
    const auto world = misbehaving(Call::connect, raise);
    CHECK_THROWS_WITH_AS(world->robot(0).connect(), "backend 'toy': connect() raised no", ConnectionError);
    CHECK_THROWS_AS(world->robot(0).poll(), ConnectionError);
    CHECK_THROWS_AS(world->robot(0).connect(), ConnectionError);
  }
  SUBCASE("disconnect") {
    const auto world = misbehaving(Call::disconnect, raise);
    world->robot(0).connect();
    CHECK_THROWS_WITH_AS(world->robot(0).disconnect(), "backend 'toy': disconnect() raised no", ConnectionError);
    CHECK_NOTHROW(world->robot(0).disconnect());
  }
  SUBCASE("reset") {
    const auto world = misbehaving(Call::reset, raise);
    CHECK_THROWS_WITH_AS(world->reset({}), "backend 'toy': reset() raised no", ConnectionError);
  }
  SUBCASE("save") {
    const auto world = misbehaving(Call::save, raise);
    CHECK_THROWS_WITH_AS((void)world->save(), "backend 'toy': save() raised no", ConnectionError);
  }
  SUBCASE("restore") {
    const auto world = misbehaving(Call::restore, raise);
    const std::vector<std::byte> state = world->save();
    CHECK_THROWS_WITH_AS(world->restore(state), "backend 'toy': restore() raised no", ConnectionError);
  }
}

TEST_CASE("a plug-in that hangs is a fault, nothing waits for it, and once it returns it can be connected again") {
  const auto gate = std::make_shared<Gate>();
  const auto world = misbehaving(
      Call::step,
      [gate](const PluginRequest&) -> PluginReply {
        gate->wait();
        return {};
      },
      20ms);
  CHECK(poll_error<ConnectionError>(*world) == "backend 'toy': step() has not returned within 0.02 s");
  world->advance_to(10s);
  CHECK(world->now() == 10s);
  CHECK_NOTHROW(world->robot(0).disconnect());
  CHECK_THROWS_WITH_AS(world->robot(0).connect(), "backend 'toy': step() has not returned", ConnectionError);

  gate->release();
  while (!connects(*world)) {  // while it is still on its way back
  }
  world->advance_to(11s);
  CHECK_NOTHROW(world->robot(0).poll());
}

TEST_CASE("every other call that hangs returns too") {
  const auto gate = std::make_shared<Gate>();
  const Handler hang = [gate](const PluginRequest&) -> PluginReply {
    gate->wait();
    return {};
  };
  {
    const auto world = misbehaving(Call::connect, hang, 20ms);
    CHECK_THROWS_AS(world->robot(0).connect(), ConnectionError);
    CHECK_NOTHROW(world->robot(0).disconnect());
  }
  {
    const auto world = misbehaving(Call::disconnect, hang, 20ms);
    world->robot(0).connect();
    CHECK_THROWS_WITH_AS(world->robot(0).disconnect(), "backend 'toy': disconnect() has not returned within 0.02 s",
                         ConnectionError);
  }
  {
    const auto world = misbehaving(Call::reset, hang, 20ms);
    CHECK_THROWS_AS(world->reset({}), ConnectionError);
  }
  {
    const auto world = misbehaving(Call::save, hang, 20ms);
    CHECK_THROWS_AS((void)world->save(), ConnectionError);
  }
  gate->release();
}

TEST_CASE("a world may end while its plug-in hangs") {
  const auto gate = std::make_shared<Gate>();
  {
    const auto world = misbehaving(
        Call::step,
        [gate](const PluginRequest&) -> PluginReply {
          gate->wait();
          return {};
        },
        20ms);
    poll_error<ConnectionError>(*world);
  }
  gate->release();
}

TEST_CASE("a connected plug-in is told to disconnect when its world ends") {
  const auto recorder = std::make_shared<Recorder>();
  recorded(recorder)->robot(0).connect();
  recorder->wait_for([](const PluginRequest& request) { return request.call == Call::disconnect; });
}

TEST_CASE("what a reading may have wrong: one error that names sensor and field") {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const auto scan = [](const std::function<void(LaserScan&)>& change) {
    return poll_error<ContractError>(*answering<LaserScan>(good_scan(), [&](auto&, LaserScan& s) { change(s); }));
  };
  const auto imu = [](const std::function<void(IMUData&)>& change) {
    return poll_error<ContractError>(*answering<IMUData>({}, [&](PluginReading& r, IMUData& i) {
      change(i);
      r.data = i;
    }));
  };
  const auto odometry = [](const std::function<void(Odometry&)>& change) {
    return poll_error<ContractError>(*answering<Odometry>({}, [&](PluginReading& r, Odometry& o) {
      change(o);
      r.data = o;
    }));
  };
  const auto battery = [](const std::function<void(BatteryState&)>& change) {
    return poll_error<ContractError>(*answering<BatteryState>({8.0, 1.0, 0.5}, [&](PluginReading& r, BatteryState& b) {
      change(b);
      r.data = b;
    }));
  };
  const auto reading = [](const std::function<void(PluginReading&)>& change) {
    return poll_error<ContractError>(*answering<Odometry>({}, [&](PluginReading& r, Odometry& o) {
      r.data = o;
      change(r);
    }));
  };
  CHECK(scan([](LaserScan&) {}) == "nothing thrown");
  CHECK(scan([](LaserScan& s) { s.ranges.resize(359); }) ==
        "backend 'toy': sensor 'lidar': ranges has shape (359,); the profile '3we_standard_v2' has (360,)");
  CHECK(scan([](LaserScan& s) { s.ranges[3] = std::numeric_limits<float>::quiet_NaN(); }) ==
        "backend 'toy': sensor 'lidar': ranges [3] is nan; it must be 0 (invalid) or within 0.02 to 12 m (no return: "
        "12)");
  CHECK(scan([](LaserScan& s) { s.ranges[3] = 13.0F; }).find("ranges [3] is 13") != std::string::npos);
  CHECK(scan([](LaserScan& s) { s.ranges[3] = -1.0F; }).find("ranges [3] is -1") != std::string::npos);
  CHECK(scan([](LaserScan& s) { s.time_increment = kNan; }) ==
        "backend 'toy': sensor 'lidar': time_increment is nan; it must be finite");
  CHECK(imu([](IMUData& i) { i.angular_velocity[2] = kNan; }) ==
        "backend 'toy': sensor 'imu': angular_velocity is nan; it must be finite");
  CHECK(imu([](IMUData& i) { i.linear_acceleration[0] = -1.0 / 0.0; }) ==
        "backend 'toy': sensor 'imu': linear_acceleration is -inf; it must be finite");
  CHECK(odometry([](Odometry& o) { o.pose.x = kNan; }) ==
        "backend 'toy': sensor 'odometry': pose is nan; it must be finite");
  CHECK(odometry([](Odometry& o) { o.velocity.omega = kNan; }) ==
        "backend 'toy': sensor 'odometry': velocity is nan; it must be finite");
  CHECK(scan([](LaserScan& s) { s.angle_min = 1e300; }).find("angle_min is 1e+300; it must be") != std::string::npos);
  CHECK(scan([](LaserScan& s) { s.time_increment = 1e3; }).find("time_increment is 1000; it") != std::string::npos);
  CHECK(imu([](IMUData& i) { i.angular_velocity[2] = 1e300; }) ==
        "backend 'toy': sensor 'imu': angular_velocity is 1e+300; it must be within +-1000 rad/s");
  CHECK(odometry([](Odometry& o) { o.pose.x = 1e12; }).find("'odometry': pose is 1") != std::string::npos);
  CHECK(odometry([](Odometry& o) { o.velocity.vx = 1e9; }).find("'odometry': velocity is 1") != std::string::npos);
  CHECK(odometry([](Odometry& o) { o.pose.theta = 4.0; }) ==
        "backend 'toy': sensor 'odometry': pose has a heading of 4, outside (-pi, pi]");
  CHECK(battery([](BatteryState& b) { b.charge = 50.0; }) ==
        "backend 'toy': sensor 'battery': charge is 50; it must be within 0 to 1");
  CHECK(battery([](BatteryState& b) { b.voltage = kNan; }) ==
        "backend 'toy': sensor 'battery': voltage is nan; it must be finite");
  CHECK(reading([](PluginReading& r) { r.sensor = "odometri"; }) ==
        "backend 'toy': unknown sensor 'odometri'; did you mean 'odometry'?");
  CHECK(reading([](PluginReading& r) { r.data = BatteryState{}; }) ==
        "backend 'toy': sensor 'odometry': another kind of data than it measures");
  CHECK(reading([](PluginReading& r) { r.measured += 1s; }) ==
        "backend 'toy': sensor 'odometry': measured is 1.02 s, in the future: now is 0.02 s");
}

TEST_CASE("stamps of a sensor must rise, and a bad answer delivers none of its readings") {
  const auto world = misbehaving(Call::step, [](const PluginRequest&) {
    return PluginReply{{{"odometry", 5ms, Odometry{}}, {"odometry", 5ms, Odometry{}}}, {}};
  });
  CHECK(poll_error<ContractError>(*world) ==
        "backend 'toy': sensor 'odometry': measured is 0.005 s, not after 0.005 s of the reading before");
  CHECK_THROWS_AS(world->robot(0).poll(), ContractError);
}

TEST_CASE("features that contradict themselves or the profile are refused when the link is made") {
  const auto refused = [](const std::function<void(Features&)>& change) -> std::string {
    Features bad = features();
    change(bad);
    try {
      PluginLink("toy", bad, standard());
    } catch (const ContractError& error) {
      return error.what();
    }
    return "accepted";
  };
  CHECK(refused([](Features&) {}) == "accepted");
  CHECK(refused([](Features& f) { f.sensors[0].name = "imu"; }) == "backend 'toy': two sensors are named 'imu'");
  CHECK(refused([](Features& f) { f.sensors[0].rate = -1.0; }) ==
        "backend 'toy': sensor 'lidar': rate is -1 Hz; it must be positive");
  CHECK(refused([](Features& f) { f.kinematics = Kinematics::differential; }) ==
        "backend 'toy': features and profile differ in their kinematics");
  CHECK(refused([](Features& f) { f.lockstep = false; }) == "backend 'toy': can be saved, but time runs by itself");
}

TEST_CASE("in real time the truth is what was answered, though a step follows at once") {
  const auto link = std::make_shared<PluginLink>("toy", realtime_features(), standard());
  PluginWorld world(link);
  const Handler handler = [&](const PluginRequest& request) -> PluginReply {
    PluginReply reply;
    if (request.call != Call::truth) return reply;
    const Time late = world.now() + kControlPeriod;
    while (world.now() < late) std::this_thread::yield();  // the next step is due by then
    reply.truth.pose = {1.0, 2.0, 0.5};
    return reply;
  };
  const std::jthread plugin([&] { testing::serve(*link, handler); });
  world.robot(0).connect();
  for (int i = 0; i < 50; ++i) CHECK(link->truth().pose == Pose2D{1.0, 2.0, 0.5});
  link->close();
}

TEST_CASE("a truth that nobody can believe is the plug-in's fault") {
  const auto link = std::make_shared<PluginLink>("toy", features(), standard());
  PluginWorld world(link);
  const Handler handler = [](const PluginRequest&) {
    PluginReply reply;
    reply.truth.distance_driven = -1.0;
    return reply;
  };
  const std::jthread plugin([&] { testing::serve(*link, handler); });
  CHECK_THROWS_WITH_AS(link->truth(), "backend 'toy': truth(): distance_driven is -1; it must be 0 or more",
                       ContractError);
  link->close();
}

TEST_CASE("each episode of a seed is a seed of its own to a plug-in") {
  const auto recorder = std::make_shared<Recorder>();
  const auto world = recorded(recorder);
  for (const std::uint32_t episode : {0U, 1U, 2U, 1U}) world->reset({.seed = 7, .poses = {}, .episode = episode});
  std::vector<std::uint64_t> seeds;
  for (const PluginRequest& request : recorder->requests) {
    if (request.call == Call::reset) seeds.push_back(request.seed);
  }
  REQUIRE(seeds.size() == 4);
  CHECK(seeds[0] == 7);
  CHECK(seeds[1] == seeds[3]);
  CHECK(std::set(seeds.begin(), seeds.end()).size() == 3);
}

TEST_CASE("samples that wait to be polled are part of a saved state") {
  const auto recorder = std::make_shared<Recorder>();
  const auto world = recorded(recorder);
  world->robot(0).connect();
  world->advance_to(200ms);
  const std::vector<std::byte> state = world->save();
  const std::vector<Sample> polled = world->robot(0).poll();
  world->advance_to(300ms);
  world->restore(state);
  const std::vector<Sample> again = world->robot(0).poll();
  REQUIRE(!polled.empty());
  REQUIRE(again.size() == polled.size());
  for (std::size_t i = 0; i < polled.size(); ++i) {
    CHECK(again[i].sensor == polled[i].sensor);
    CHECK(again[i].sequence == polled[i].sequence);
    CHECK(again[i].measured == polled[i].measured);
    CHECK(again[i].received == 200ms);
  }
}

TEST_CASE("a state that is cut short is refused, and nothing is restored") {
  const auto recorder = std::make_shared<Recorder>();
  const auto world = recorded(recorder);
  world->robot(0).connect();
  world->advance_to(100ms);
  world->robot(0).poll();
  std::vector<std::byte> state = world->save();
  state.resize(10);
  CHECK_THROWS_AS(world->restore(state), ContractError);
  CHECK(world->now() == 100ms);
  CHECK(recorder->count(Call::restore) == 0);
}

TEST_CASE("in real time a plug-in is stepped by the clock, and a command expires though the runtime is dead") {
  const auto recorder = std::make_shared<Recorder>();
  const auto world = recorded(recorder, realtime_features());
  world->robot(0).connect();
  world->robot(0).command(kForward, world->now() + 60ms);
  recorder->wait_for([](const auto& request) { return request.velocity == kForward; });
  const Time seen = world->now();
  recorder->wait_for([&](const auto& request) { return request.t > seen && request.velocity == Velocity{}; });
  const Time later = world->now() + 100ms;
  world->advance_to(later);
  CHECK(world->now() >= later);
  const std::vector<Sample> samples = world->robot(0).poll();
  CHECK(!samples.empty());
  for (const Sample& sample : samples) CHECK(sample.measured <= sample.received);
  world->robot(0).disconnect();
}

TEST_CASE("in real time readings may be pushed by any thread, between two steps") {
  const auto link = std::make_shared<PluginLink>("toy", realtime_features(), standard());
  PluginWorld world(link);
  const std::jthread plugin([&] { testing::serve(*link, [](const PluginRequest&) { return PluginReply{}; }); });
  const auto push = [&](Time measured) {
    std::jthread([&] { link->push({"odometry", measured, Odometry{}}); }).join();
  };
  push(link->robot_time());  // of a robot that is not connected yet
  world.robot(0).connect();
  CHECK(world.robot(0).poll().empty());
  const Time now = link->robot_time();
  push(now);
  const std::vector<Sample> samples = world.robot(0).poll();
  REQUIRE(samples.size() == 1);
  CHECK(samples.front().measured == now);
  push(now + 10s);
  CHECK_THROWS_AS(world.robot(0).poll(), ContractError);
  link->close();
}

TEST_CASE("in real time a plug-in that blocks beyond the end of its command is a fault") {
  const auto gate = std::make_shared<Gate>();
  const auto driven = std::make_shared<Recorder>();
  const auto world = plugin_world(realtime_features(), standard(), [gate, driven](const PluginRequest& request) {
    const PluginReply reply = (*driven)(request);
    if (request.velocity != Velocity{}) gate->wait();
    return reply;
  });
  world->robot(0).connect();
  world->robot(0).command(kForward, world->now() + 200ms);
  driven->wait_for([](const auto& request) { return request.velocity == kForward; });
  std::string fault;
  while (fault.empty()) {  // a healthy runtime goes on to renew the command
    try {
      world->robot(0).command(kForward, world->now() + 200ms);
      world->advance_to(world->now() + kControlPeriod);
      world->robot(0).poll();
    } catch (const ConnectionError& error) {
      fault = error.what();
    }
  }
  CHECK(fault == "backend 'toy': step() blocks beyond the end of its command");
  CHECK_NOTHROW(world->robot(0).disconnect());
  gate->release();
  driven->wait_for([](const auto& request) { return request.call == Call::disconnect; });
}

}  // namespace
}  // namespace threewe::backend
