// Robot: the calls of one connected robot. The same names as in Python; where Python awaits, C++ waits on a handle:
//
//   threewe::Robot robot;
//   threewe::MoveResult result = robot.wait(robot.move_to(2.0, 1.0));
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "threewe/nav/navigator.hpp"
#include "threewe/robot/runtime.hpp"
#include "threewe/robot/simulation.hpp"
#include "threewe/robot/world.hpp"

namespace threewe {

namespace agent {
class Agent;
}
namespace semantics {
struct MappedThing;
struct Place;
}  // namespace semantics

/// An exploration in progress: a motion whose result is an ExploreResult.
struct ExplorationHandle {
  MotionHandle motion;  ///< the motion that explores
};

/// One connected robot. Robot time advances only inside `wait`, `sleep`, `thinking` and `execute_action`.
/// It stays where it was made, since simulation() and observers refer to it.
class Robot {
 public:
  /// Where the robot is, and which.
  using Options = RobotOptions;
  /// A robot in a world of its own, connected and with every sensor's first sample at hand.
  Robot();
  /// The same, with options. Throws ConfigError naming the option that is wrong, and ConnectionError.
  explicit Robot(const Options& options);
  /// A robot of a world that others share; the world must outlive it.
  explicit Robot(World& world, std::size_t index = 0);
  ~Robot();
  Robot(const Robot&) = delete;
  Robot& operator=(const Robot&) = delete;

  /// Reaches the robot and waits for every sensor's first sample. Throws ConnectionError.
  void connect();
  /// Ends a motion as `cancelled`, stops the robot and lets it go.
  void disconnect();
  /// Robot time.
  Time now() const { return world_->now(); }

  // Readings: what arrived last. They never advance robot time.
  /// The newest scan. Throws HardwareError without a lidar, as all readings do of a sensor that is missing.
  const LaserScan& get_lidar_scan() const;
  /// The newest reading of the inertial unit.
  const IMUData& get_imu() const;
  Pose2D get_pose() const;  ///< in `map`, as the robot believes
  bool lost() const;        ///< it does not know where it is: `get_pose` is no more than where it was last
  /// Pose and velocity by the wheels alone.
  const Odometry& get_odometry() const;
  /// The estimated body velocity.
  Velocity get_velocity() const;
  /// The map so far; valid until robot time goes on.
  const map::OccupancyGrid& get_map() const;
  /// Writes the map as ROS has maps: `yaml`, which ends in .yaml, and the image next to it. Throws ConfigError.
  void save_map(const std::filesystem::path& yaml) const;
  /// The newest reading of the battery.
  const BatteryState& get_battery_state() const;
  /// The newest image of the camera: colour, and depth where it measures any.
  const RGBDImage& get_camera_image() const { return get_image("camera"); }
  /// The newest image of the camera of that name.
  const RGBDImage& get_image(std::string_view camera) const;
  /// The newest image of a camera that measures depth.
  const RGBDImage& get_rgbd_image() const;
  /// What each ultrasonic sensor measured last, by the sensors' names.
  std::map<std::string, RangeData> get_ultrasonic_ranges() const;
  /// Who walks around the robot, as its lidar sees them, in `odom`.
  std::span<const perception::TrackedPerson> get_people() const { return runtime_->people(); }
  /// The plan being followed and the samples that it was made of, in `odom`; see `Runtime::plan`.
  std::optional<nav::SampledPlan> get_plan() const { return runtime_->plan(); }
  /// How each sensor is; see `Runtime::health`.
  const std::vector<SensorHealth>& health() const { return runtime_->health(); }
  /// `target_from_source` among `map`, `odom`, `base` and the sensors' names.
  Pose2D get_transform(std::string_view target, std::string_view source) const;

  /// Drives at (vx, vy, omega) [m/s, m/s, rad/s] for at most `hold` [s].
  void set_velocity(double vx, double vy, double omega, double hold = 0.5, bool creep_mode = false);
  /// One control step: `action` in [-1, 1] scaled to the operating limits, held for `period` [s]; the velocity
  /// executed.
  Velocity execute_action(const std::array<double, 3>& action, double period = 0.02);
  /// Ends a motion as `cancelled` and brakes.
  void stop();

  /// How a motion to a place is to end.
  struct MoveOptions {
    std::optional<double> theta = {};    ///< [rad] final heading
    std::string frame = "map";           ///< of the goal: `map`, `odom` or `base`
    double tolerance = 0.25;             ///< [m]
    double angle_tolerance = 0.1;        ///< [rad] of the final heading
    std::optional<double> timeout = {};  ///< [s] of robot time; none where empty
  };
  // Motions begin at once and are driven by `wait`. They aim at their goals themselves; tolerances [m] and [rad] say
  // how far off they may end where something is in the way, see nav::MoveTo.
  /// Drives to (x, y) [m] in `map`. Throws ContractError, SafetyError or EmergencyStopError where no motion may begin.
  [[nodiscard]] MotionHandle move_to(double x, double y);
  /// The same with a heading, another frame, tolerances or a time limit.
  [[nodiscard]] MotionHandle move_to(double x, double y, const MoveOptions& options);
  /// Drives straight ahead by `distance` [m], backwards when negative; `timeout` [s].
  [[nodiscard]] MotionHandle move_forward(double distance, double tolerance = 0.05,
                                          std::optional<double> timeout = std::nullopt);
  /// Turns on the spot by `angle` [rad], counter-clockwise; `timeout` [s].
  [[nodiscard]] MotionHandle rotate(double angle, double angle_tolerance = 0.1,
                                    std::optional<double> timeout = std::nullopt);
  /// Drives along points [m] in `map`; `timeout` [s].
  [[nodiscard]] MotionHandle follow_path(const std::vector<Vec2>& path, double tolerance = 0.25,
                                         std::optional<double> timeout = std::nullopt);
  /// Drives to places in `map` one after the other, by whatever way, and stops at each; the first that is missed ends
  /// it; `timeout` [s] for all of them.
  [[nodiscard]] MotionHandle follow_waypoints(const std::vector<nav::MoveTo>& waypoints,
                                              std::optional<double> timeout = std::nullopt);
  /// Maps what can be reached and is worth the way; if `thorough` also the last corners, which may take as long as all
  /// the rest; `timeout` [s].
  [[nodiscard]] ExplorationHandle explore(std::optional<double> timeout = std::nullopt, bool thorough = false);

  /// Called every 0.1 s of robot time with how far a motion has come.
  using OnProgress = std::function<void(const Progress&)>;
  /// Lets robot time go by until the motion has ended. What `on_progress` throws cancels it.
  MoveResult wait(const MotionHandle& motion, const OnProgress& on_progress = {});
  /// The same for an exploration.
  ExploreResult wait(const ExplorationHandle& exploration, const OnProgress& on_progress = {});
  /// Lets `seconds` of robot time go by.
  void sleep(double seconds);
  /// Runs `work` while robot time stands still, then lets the `seconds` that it stands for go by.
  void thinking(double seconds, const std::function<void()>& work);

  /// How far an instruction may go.
  struct InstructionOptions {
    int max_steps = 30;      ///< of its plan
    double timeout = 900.0;  ///< [s] of robot time
  };
  /// Reads an instruction such as "find the red chair" and executes it, offline: by a grammar, its own object detector
  /// and its own map of things. Robot time goes by until it has ended; why it ended is in the result. Throws
  /// HardwareError for what needs a camera without one, ContractError for a text that is no text, SafetyError during a
  /// motion, EmergencyStopError.
  ExecutionResult execute_instruction(std::string_view instruction);
  /// The same with limits.
  ExecutionResult execute_instruction(std::string_view instruction, const InstructionOptions& options);
  /// Gives the place where the robot is a name, for instructions. Throws ContractError for a name that is none.
  void name_place(const std::string& name);
  /// Gives a polygon [m] in `map` a name. Throws ContractError also for one of fewer than three points.
  void name_place(const std::string& name, const std::vector<Vec2>& polygon);
  /// The places that have names, in the order in which they got them; see threewe/semantics/things.hpp.
  std::vector<semantics::Place> get_places();
  /// Gives the places of a file their names, besides those that are known; returns them. Throws ConfigError with
  /// file:line for what is wrong there.
  std::vector<semantics::Place> load_places(const std::filesystem::path& file);
  /// Writes the places that have names to a file that ends in .yaml. Throws ConfigError where it cannot be written.
  void save_places(const std::filesystem::path& file);
  /// The things that it has seen while it executed instructions, each from two poses or more.
  std::vector<semantics::MappedThing> get_things();
  /// The kinds of things, which `MappedThing::kind` is an index into.
  const std::vector<std::string>& get_thing_labels();

  /// Where motions may not lead, or only slowly, in `map`; in place of what was set before. See Runtime::set_zones.
  void set_zones(const std::vector<map::Zone>& zones) { runtime_->set_zones(zones); }

  /// Stops at once and refuses every motion until released.
  void emergency_stop();
  /// Allows motions again.
  void release_emergency_stop();

  /// The truth, in a simulated world; null on a real robot.
  Simulation* simulation();
  /// What runs the robot, for observers and for more readings.
  Runtime& runtime() { return *runtime_; }
  /// The world that it is in.
  World& world() { return *world_; }

 private:
  void drive(const MotionHandle& motion, const OnProgress& on_progress);
  agent::Agent& instructed();

  std::unique_ptr<World> owned_;
  World* world_ = nullptr;
  Runtime* runtime_ = nullptr;
  std::optional<Simulation> simulation_;
  std::shared_ptr<agent::Agent> agent_;  // from the first call of an instruction, a place or a thing on
};

}  // namespace threewe
