// Stand-in for Gazebo Harmonic: another process, on Debian's library of Gazebo's transport, with the embedded simulator
// as its physics. It loads an exported world as Gazebo does, with libsdformat.
//
//   gazebo_simulator WORLD.sdf [-r] [--seed N] [--scene FILE] [--robot FILE] [FAULT]
//
// What it has of Gazebo's ways, by gz-sim 8's sources: it starts paused without -r; it goes round once a millisecond
// while paused; the clock is sent as a round begins, the statistics ten times a second; services answer when they have
// queued what they were asked for, and a later round does it; a reset loads most systems anew, so that their topics and
// services end and begin; it begins no episode with another seed; what is drawn comes from a thread of its own, late,
// and only where it has a subscriber; a velocity holds until the next.
//
// FAULT is one of --never-step, --runs-by-itself, --mute TOPIC, --wrong-type TOPIC, --name WORLD. People of a scene are
// not played.
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <csignal>
#include <cstdio>
#include <deque>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <random>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <ignition/transport/Node.hh>

#include "messages.pb.h"
#include "threewe/backend/registry.hpp"
#include "threewe/scene/truth_view.hpp"
#include "world_file.hpp"

using namespace threewe;
using WallClock = std::chrono::steady_clock;
namespace transport = ignition::transport;

namespace {

std::atomic<bool> g_ended = false;

struct Options {
  std::string file;
  std::string scene;
  std::string robot;
  std::string name;
  std::string mute;
  std::string wrong_type;
  std::uint64_t seed = 0;
  bool running = false;
  bool never_step = false;
  bool runs_by_itself = false;
};

Options parse(int count, char** arguments) {
  Options options;
  options.file = arguments[1];
  for (int i = 2; i < count; ++i) {
    const std::string_view name = arguments[i];
    if (name == "-r") {
      options.running = true;
    } else if (name == "--never-step") {
      options.never_step = true;
    } else if (name == "--runs-by-itself") {
      options.runs_by_itself = true;
    } else if (++i == count) {
      throw std::runtime_error("a value is missing");
    } else if (name == "--seed") {
      options.seed = std::stoull(arguments[i]);
    } else if (name == "--scene") {
      options.scene = arguments[i];
    } else if (name == "--robot") {
      options.robot = arguments[i];
    } else if (name == "--name") {
      options.name = arguments[i];
    } else if (name == "--mute") {
      options.mute = arguments[i];
    } else if (name == "--wrong-type") {
      options.wrong_type = arguments[i];
    } else {
      throw std::runtime_error("unknown option");
    }
  }
  return options;
}

void set(gz::msgs::Time& stamp, Time time) {
  stamp.set_sec(time.count() / 1'000'000'000);
  stamp.set_nsec(static_cast<std::int32_t>(time.count() % 1'000'000'000));
}

template <typename Message>
Message stamped(Time time) {
  Message message;
  set(*message.mutable_header()->mutable_stamp(), time);
  return message;
}

void set(gz::msgs::Pose& message, const Pose2D& pose) {
  message.mutable_position()->set_x(pose.x);
  message.mutable_position()->set_y(pose.y);
  message.mutable_orientation()->set_z(std::sin(0.5 * pose.theta));
  message.mutable_orientation()->set_w(std::cos(0.5 * pose.theta));
}

/// Publishes a topic, of the right type or, where that is the fault, of another.
class Topic {
 public:
  template <typename Message>
  static Topic of(transport::Node& node, const std::string& name, const Options& options) {
    Topic topic;
    if (name == options.mute) return topic;
    if (name == options.wrong_type) {
      topic.publisher_ = node.Advertise<gz::msgs::StringMsg>(name);
    } else {
      topic.publisher_ = node.Advertise<Message>(name);
      topic.right_ = true;
    }
    return topic;
  }
  bool is_taken() const { return right_ && publisher_.HasConnections(); }
  void publish(const google::protobuf::Message& message) {
    if (right_) publisher_.Publish(message);
  }

 private:
  mutable transport::Node::Publisher publisher_;
  bool right_ = false;
};

/// Sends what was drawn, later and one after the other.
class Renderer {
 public:
  explicit Renderer(std::uint64_t seed) : random_(static_cast<unsigned>(seed)), thread_([this] { run(); }) {}
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;
  ~Renderer() {
    {
      const std::scoped_lock lock(mutex_);
      ended_ = true;
    }
    changed_.notify_all();
    thread_.join();
  }
  /// Waits until what was drawn before has been sent.
  void draw(std::vector<std::function<void()>> jobs) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return jobs_.empty(); });
    jobs_ = std::move(jobs);
    changed_.notify_all();
  }

 private:
  void run() {
    std::unique_lock lock(mutex_);
    for (;;) {
      changed_.wait(lock, [this] { return ended_ || !jobs_.empty(); });
      if (ended_) return;
      lock.unlock();
      std::this_thread::sleep_for(std::chrono::microseconds(std::uniform_int_distribution(0, 4000)(random_)));
      for (const auto& job : jobs_) job();
      lock.lock();
      jobs_.clear();
      changed_.notify_all();
    }
  }
  std::mt19937 random_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<std::function<void()>> jobs_;
  bool ended_ = false;
  std::thread thread_;
};

/// When a sensor updates: each time that its period has passed, counted from 0.
struct Timer {
  Duration period{};
  Time next{};
  bool due(Time now) {
    if (now < next) return false;
    while (next <= now) next += period;
    return true;
  }
};

class Simulator {
 public:
  Simulator(const Options& options, const WorldFile& file)
      : options_(options), file_(file), random_(options.seed), renderer_(options.seed) {
    backend::WorldOptions world_options;
    world_options.scene = options.scene.empty() ? file.name : options.scene;
    world_options.robots = {options.robot.empty() ? file.model : options.robot};
    world_options.noise = NoiseLevel::ideal;
    world_ = backend::make_world("mock", world_options);
    const backend::TruthService* service = world_->truth_service();
    if (service == nullptr) throw std::runtime_error("a simulator without a truth");
    truth_ = &service->truth(0);
    port().connect();
    name_ = "/world/" + (options.name.empty() ? file.name : options.name);
    paused_ = !options.running;

    transport::AdvertiseMessageOptions throttled;
    throttled.SetMsgsPerSec(10);
    statistics_ = node_.Advertise<gz::msgs::WorldStatistics>(name_ + "/stats", throttled);
    clock_ = node_.Advertise<gz::msgs::Clock>(name_ + "/clock");
    root_clock_ = node_.Advertise<gz::msgs::Clock>("/clock");
    node_.Advertise(name_ + "/control", &Simulator::on_control, this);
    for (const SensorFile& sensor : file.sensors) {
      if (sensor.kind == SensorFile::Kind::lidar) {
        drawn_.push_back({sensor, {sensor.period}, {Topic::of<gz::msgs::LaserScan>(node_, sensor.topic, options_)}});
      } else if (sensor.kind == SensorFile::Kind::camera) {
        drawn_.push_back({sensor, {sensor.period}, {Topic::of<gz::msgs::Image>(node_, sensor.topic, options_)}});
      } else if (sensor.kind == SensorFile::Kind::rgbd) {
        drawn_.push_back({sensor,
                          {sensor.period},
                          {Topic::of<gz::msgs::Image>(node_, sensor.topic + "/image", options_),
                           Topic::of<gz::msgs::Image>(node_, sensor.topic + "/depth_image", options_)}});
      }
    }
    load_systems();
  }

  /// One round.
  void go_round() {
    if (std::exchange(reset_requested_, false)) {
      reset();
    } else if (!paused_) {
      now_ += file_.step;
    }
    publish_time();
    if (!was_reset_) update();
    was_reset_ = false;
    if (!paused_ && pending_ > 0 && --pending_ == 0) paused_ = true;
    take_controls();
    if (options_.runs_by_itself) paused_ = false;
    pace();
  }

 private:
  // Those that a reset destroys and loads anew.
  struct Systems {
    transport::Node node;
    std::deque<transport::Node> nodes;  // of odometries: each plugin has one, so that two may share a topic
    std::vector<std::pair<SensorFile, Topic>> imus;
    std::vector<Timer> imu_timers;
    std::vector<std::pair<OdometryFile, Topic>> odometries;
    std::vector<Time> published;
    std::optional<Topic> contacts;
  };
  struct Drawn {
    SensorFile sensor;
    Timer timer;
    std::vector<Topic> topics;
  };

  backend::RobotPort& port() { return world_->robot(0); }
  const scene::TruthView& truth() const { return *truth_; }

  void load_systems() {
    systems_ = std::make_unique<Systems>();
    for (const SensorFile& sensor : file_.sensors) {
      if (sensor.kind == SensorFile::Kind::imu) {
        systems_->imus.emplace_back(sensor, Topic::of<gz::msgs::IMU>(systems_->node, sensor.topic, options_));
        systems_->imu_timers.push_back({sensor.period});
      }
      if (sensor.kind == SensorFile::Kind::contact) {
        systems_->contacts = Topic::of<gz::msgs::Contacts>(systems_->node, sensor.topic, options_);
      }
    }
    for (const OdometryFile& odometry : file_.odometries) {
      systems_->odometries.emplace_back(
          odometry, Topic::of<gz::msgs::Odometry>(systems_->nodes.emplace_back(), odometry.topic, options_));
      systems_->published.emplace_back(-1h);
    }
    systems_->node.Subscribe(file_.command_topic, &Simulator::on_command, this);
    systems_->node.Advertise(name_ + "/set_pose", &Simulator::on_set_pose, this);
    const std::scoped_lock lock(mutex_);
    command_ = {};
    poses_.clear();
  }

  void reset() {
    now_ = {};
    was_reset_ = true;
    world_->reset({});
    last_velocity_ = {};
    last_acceleration_ = {};
    wheels_ = {};
    touched_ = 0.0;
    systems_.reset();
    load_systems();
    for (Drawn& drawn : drawn_) drawn.timer.next = {};
  }

  void publish_time() {
    gz::msgs::WorldStatistics statistics;
    set(*statistics.mutable_sim_time(), now_);
    statistics.set_paused(paused_);
    statistics_.Publish(statistics);
    gz::msgs::Clock clock;
    set(*clock.mutable_sim(), now_);
    clock_.Publish(clock);
    root_clock_.Publish(clock);
  }

  void update() {
    Velocity command;
    std::vector<gz::msgs::Pose> poses;
    {
      const std::scoped_lock lock(mutex_);
      command = command_;
      poses = std::exchange(poses_, {});
    }
    for (const gz::msgs::Pose& pose : poses) put_down(pose);
    if (!paused_) {
      port().command(command, world_->now() + 1h);
      world_->advance_to(now_);
      for (const Sample& sample : port().poll()) {
        if (const auto* odometry = std::get_if<Odometry>(&sample.data)) wheels_ = *odometry;
      }
      sense();
    }
    draw();
  }

  void put_down(const gz::msgs::Pose& message) {
    if (message.name() != file_.model) return;
    const auto& q = message.orientation();
    try {
      world_->teleport(0, {message.position().x(), message.position().y(), 2.0 * std::atan2(q.z(), q.w())});
    } catch (const std::exception& error) {
      std::fprintf(stderr, "set_pose: %s\n", error.what());  // where Gazebo would have it stand in a wall
    }
  }

  double noise(double sigma) { return sigma > 0.0 ? std::normal_distribution(0.0, sigma)(random_) : 0.0; }

  void sense() {
    const Pose2D pose = truth().true_pose();
    const Velocity v = truth().true_velocity();
    if (now_ % 10ms == 0ms) {  // as the physics behind it goes
      const double seconds = 0.01;
      last_acceleration_ = {(v.vx - last_velocity_.vx) / seconds - v.omega * v.vy,
                            (v.vy - last_velocity_.vy) / seconds + v.omega * v.vx};
      last_velocity_ = v;
    }
    for (std::size_t i = 0; i < systems_->imus.size(); ++i) {
      auto& [sensor, topic] = systems_->imus[i];
      if (!topic.is_taken() || !systems_->imu_timers[i].due(now_)) continue;
      auto imu = stamped<gz::msgs::IMU>(now_);
      imu.mutable_angular_velocity()->set_x(noise(sensor.sigma));
      imu.mutable_angular_velocity()->set_y(noise(sensor.sigma));
      imu.mutable_angular_velocity()->set_z(v.omega + noise(sensor.sigma));
      imu.mutable_linear_acceleration()->set_x(last_acceleration_.x + noise(sensor.accelerometer_sigma));
      imu.mutable_linear_acceleration()->set_y(last_acceleration_.y + noise(sensor.accelerometer_sigma));
      imu.mutable_linear_acceleration()->set_z(9.81 + noise(sensor.accelerometer_sigma));
      topic.publish(imu);
    }
    for (std::size_t i = 0; i < systems_->odometries.size(); ++i) {
      auto& [odometry, topic] = systems_->odometries[i];
      if (now_ - systems_->published[i] < odometry.period) continue;
      systems_->published[i] = now_;
      auto message = stamped<gz::msgs::Odometry>(now_);
      const bool of_wheels = odometry.of_wheels;
      set(*message.mutable_pose(), of_wheels ? wheels_.pose : pose);
      const Velocity& velocity = of_wheels ? wheels_.velocity : v;
      message.mutable_twist()->mutable_linear()->set_x(velocity.vx);
      message.mutable_twist()->mutable_linear()->set_y(velocity.vy);
      message.mutable_twist()->mutable_angular()->set_z(velocity.omega);
      topic.publish(message);
    }
    touch(pose);
  }

  /// A contact, where the robot has just hit something harder than before.
  void touch(const Pose2D& pose) {
    const double hardest = truth().max_collision_speed();
    if (hardest <= std::exchange(touched_, hardest) || !systems_->contacts) return;
    double nearest = std::numeric_limits<double>::infinity();
    double towards = 0.0;
    for (int i = 0; i < 360; ++i) {
      const double angle = i * std::acos(-1.0) / 180;
      const double range = truth().range({pose.x, pose.y, angle}, 0.05);
      if (range < nearest) {
        nearest = range;
        towards = angle;
      }
    }
    auto contacts = stamped<gz::msgs::Contacts>(now_);
    gz::msgs::Vector3d& normal = *contacts.add_contact()->add_normal();
    normal.set_x(-std::cos(towards));
    normal.set_y(-std::sin(towards));
    systems_->contacts->publish(contacts);
  }

  void draw() {
    std::vector<std::function<void()>> jobs;
    for (Drawn& drawn : drawn_) {
      const bool taken = std::ranges::any_of(drawn.topics, [](const Topic& topic) { return topic.is_taken(); });
      if (!taken || !drawn.timer.due(now_)) continue;
      if (drawn.sensor.kind == SensorFile::Kind::lidar) {
        jobs.emplace_back([topic = &drawn.topics.front(), scan = scan(drawn.sensor)] { topic->publish(scan); });
      } else {
        const SemanticImage seen = look(drawn.sensor);
        jobs.emplace_back([topic = &drawn.topics.front(), image = color(seen)] { topic->publish(image); });
        if (drawn.topics.size() < 2) continue;
        jobs.emplace_back([topic = &drawn.topics.back(), image = depth(seen, drawn.sensor)] { topic->publish(image); });
      }
    }
    if (!jobs.empty()) renderer_.draw(std::move(jobs));
  }

  gz::msgs::LaserScan scan(const SensorFile& sensor) {
    auto scan = stamped<gz::msgs::LaserScan>(now_);
    scan.set_angle_min(sensor.angle_min);
    scan.set_angle_max(sensor.angle_max);
    scan.set_angle_step((sensor.angle_max - sensor.angle_min) / (sensor.beams - 1));
    scan.set_range_min(sensor.range_min);
    scan.set_range_max(sensor.range_max);
    scan.set_count(sensor.beams);
    scan.set_vertical_count(1);
    const Pose2D lidar = truth().true_pose() * sensor.mount;
    for (unsigned i = 0; i < sensor.beams; ++i) {
      const double angle = sensor.angle_min + i * scan.angle_step();
      double range = truth().range({lidar.x, lidar.y, lidar.theta + angle}, sensor.height);
      if (std::isfinite(range)) range += noise(sensor.sigma);
      if (range > sensor.range_max) range = std::numeric_limits<double>::infinity();
      if (range < sensor.range_min) range = -std::numeric_limits<double>::infinity();
      scan.add_ranges(range);
      scan.add_intensities(0.0);
    }
    return scan;
  }

  SemanticImage look(const SensorFile& sensor) const {
    const CameraIntrinsics camera = make_intrinsics(sensor.width, sensor.height_in_pixels, sensor.fov);
    return truth().look(camera, truth().true_pose() * sensor.mount, sensor.height, false);
  }

  gz::msgs::Image color(const SemanticImage& seen) const {
    auto image = stamped<gz::msgs::Image>(now_);
    image.set_width(static_cast<std::uint32_t>(seen.image.intrinsics.width));
    image.set_height(static_cast<std::uint32_t>(seen.image.intrinsics.height));
    image.set_step(3 * image.width());
    image.set_pixel_format_type(3);  // RGB_INT8
    std::string& data = *image.mutable_data();
    data.resize(seen.image.color.size());
    for (std::size_t i = 0; i < data.size(); i += 3) {
      for (std::size_t k = 0; k < 3; ++k) data[i + k] = static_cast<char>(seen.image.color[i + 2 - k]);
    }
    return image;
  }

  gz::msgs::Image depth(const SemanticImage& seen, const SensorFile& sensor) const {
    auto image = stamped<gz::msgs::Image>(now_);
    image.set_width(static_cast<std::uint32_t>(seen.image.intrinsics.width));
    image.set_height(static_cast<std::uint32_t>(seen.image.intrinsics.height));
    image.set_step(4 * image.width());
    image.set_pixel_format_type(13);  // R_FLOAT32
    std::vector<float> depths = seen.image.depth;
    for (float& one : depths) {
      if (one <= 0.0F || one > static_cast<float>(sensor.range_max)) one = std::numeric_limits<float>::infinity();
      if (one < static_cast<float>(sensor.range_min)) one = -std::numeric_limits<float>::infinity();
    }
    image.set_data(depths.data(), depths.size() * sizeof(float));
    return image;
  }

  void take_controls() {
    std::deque<gz::msgs::WorldControl> controls;
    {
      const std::scoped_lock lock(mutex_);
      controls.swap(controls_);
    }
    for (const gz::msgs::WorldControl& control : controls) {
      paused_ = control.pause();
      if (paused_ && control.multi_step() > 0 && !options_.never_step) {
        pending_ += control.multi_step();
        paused_ = false;
      }
      reset_requested_ = control.reset().all();
    }
  }

  void pace() {
    if (paused_) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      next_ = WallClock::now();
      return;
    }
    if (file_.real_time_factor <= 0.0) return;
    next_ += std::chrono::duration_cast<WallClock::duration>(
        std::chrono::duration<double>(to_seconds(file_.step) / file_.real_time_factor));
    std::this_thread::sleep_until(next_);
  }

  // In threads of the transport's.

  bool on_control(const gz::msgs::WorldControl& request, gz::msgs::Boolean& reply) {
    const std::scoped_lock lock(mutex_);
    controls_.push_back(request);
    reply.set_data(true);
    return true;
  }
  bool on_set_pose(const gz::msgs::Pose& request, gz::msgs::Boolean& reply) {
    const std::scoped_lock lock(mutex_);
    poses_.push_back(request);
    reply.set_data(true);
    return true;
  }
  void on_command(const gz::msgs::Twist& twist) {
    const std::scoped_lock lock(mutex_);
    command_ = {twist.linear().x(), twist.linear().y(), twist.angular().z()};
  }

  const Options options_;
  const WorldFile file_;
  std::mt19937_64 random_;
  std::unique_ptr<backend::World> world_;
  const scene::TruthView* truth_ = nullptr;
  std::string name_;

  Time now_{};
  WallClock::time_point next_ = WallClock::now();
  bool paused_ = true;
  bool reset_requested_ = false;
  bool was_reset_ = false;
  std::uint64_t pending_ = 0;
  Velocity last_velocity_;
  Vec2 last_acceleration_;
  Odometry wheels_;
  double touched_ = 0.0;

  std::mutex mutex_;  // of what services and topics ask for
  std::deque<gz::msgs::WorldControl> controls_;
  std::vector<gz::msgs::Pose> poses_;
  Velocity command_;

  transport::Node node_;
  transport::Node::Publisher statistics_;
  transport::Node::Publisher clock_;
  transport::Node::Publisher root_clock_;
  std::vector<Drawn> drawn_;
  std::unique_ptr<Systems> systems_;
  Renderer renderer_;
};

}  // namespace

int main(int count, char** arguments) {
  if (count < 2) {
    std::fputs(
        "usage: gazebo_simulator WORLD.sdf [-r] [--seed N] [--scene FILE] [--robot FILE] [--never-step]\n"
        "                        [--runs-by-itself] [--mute TOPIC] [--wrong-type TOPIC] [--name WORLD]\n",
        stderr);
    return 2;
  }
  std::signal(SIGTERM, [](int) { g_ended = true; });
  std::signal(SIGINT, [](int) { g_ended = true; });
  try {
    const Options options = parse(count, arguments);
    Simulator simulator(options, read_world_file(options.file));
    std::puts("ready");
    std::fflush(stdout);
    while (!g_ended) simulator.go_round();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "gazebo_simulator: %s\n", error.what());
    return 1;
  }
  return 0;
}
