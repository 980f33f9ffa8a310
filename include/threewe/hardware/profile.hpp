// Robot profile: body, limits, sensors and their noise. Read from assets/robots/NAME.yaml.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "threewe/core/camera.hpp"
#include "threewe/core/footprint.hpp"
#include "threewe/core/kinematics.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/core/samples.hpp"
#include "threewe/core/time.hpp"

namespace threewe {

/// Bounds on a body velocity and on how fast it may change.
struct Limits {
  double linear = 0.0;                ///< [m/s], of the vector (vx, vy)
  double angular = 0.0;               ///< [rad/s]
  double linear_acceleration = 0.0;   ///< [m/s^2], speeding up
  double linear_braking = 0.0;        ///< [m/s^2], slowing down
  double angular_acceleration = 0.0;  ///< [rad/s^2], both ways
  friend bool operator==(const Limits&, const Limits&) = default;
};

/// A ball that rolls any way and bears what two driven wheels cannot.
struct Caster {
  Vec2 position;        ///< [m] of where it stands on the floor
  double radius = 0.0;  ///< [m]
  friend bool operator==(const Caster&, const Caster&) = default;
};

/// How wheels pull that spin freely once they slip, as measured on one robot or simulator.
struct TractionSpec {
  // the share of a commanded velocity that the body reaches
  double ahead = 1.0;        ///< of a velocity ahead
  double sideways = 1.0;     ///< of four wheels; two have none
  double turning = 1.0;      ///< of a turn
  Duration turning_lag{};    ///< time constant of turns, besides `motor_lag`: a body is easier to turn than to push
  double load = 1.0;         ///< the share of the weight that stands on driven wheels
  double mass_height = 0.0;  ///< [m] of the centre of mass: by accelerations, load moves from wheel to wheel
  double shift = 0.0;        ///< of a mecanum wheel's load, what the diagonal pair that slips takes from the other
  double shift_speed = 0.0;  ///< [m/s] of slip at which it takes all of that; 0 where there is no shift
};

/// The body and its drive.
struct Body {
  Footprint footprint;              ///< outline in the base frame
  double height = 0.0;              ///< [m]
  double mass = 0.0;                ///< [kg]
  double inertia = 0.0;             ///< [kg m^2] about the vertical axis
  WheelGeometry wheels;             ///< kind, size and place of the driven wheels
  std::vector<Caster> casters;      ///< of a differential base, at least one
  double friction = 0.0;            ///< coefficient between wheel and floor
  double rolling_resistance = 0.0;  ///< the share of the weight that opposes rolling; it costs energy alone
  double stall_torque = 0.0;        ///< [N m] of one wheel's motor at the wheel
  double no_load_speed = 0.0;       ///< [rad/s] of one wheel at nominal voltage
  Duration motor_lag{};             ///< time constant of the speed loop
  /// Without it wheels keep to what their motors do, whatever they pull.
  std::optional<TractionSpec> traction;
};

/// A lidar that turns, and the scan that is made of its turn.
struct LidarSpec {
  Pose2D base_from_lidar;   ///< where it is mounted; beams count from its x axis
  double height = 0.0;      ///< [m] of the scan plane above the floor
  int points_per_turn = 0;  ///< measured by the device
  bool clockwise = false;   ///< how the device turns; the scan is always counter-clockwise
  int beams = 0;            ///< in the scan that is delivered
  Duration turn{};          ///< of one revolution
  double range_min = 0.0;   ///< [m]
  double range_max = 0.0;   ///< [m]
  double sigma = 0.0;       ///< [m] of each range
  double bias = 0.0;        ///< [m], each unit's constant offset lies in [-bias, bias]
  double dropout = 0.0;     ///< probability that a point is invalid
  Duration latency{};       ///< from the end of a turn to its arrival
  bool rolling = true;      ///< points are taken one after the other during the turn, not all at its end
};

/// An inertial unit at the base.
struct IMUSpec {
  Duration period{};                 ///< from sample to sample
  double gyro_sigma = 0.0;           ///< [rad/s] of each sample
  double gyro_bias = 0.0;            ///< [rad/s], the bias at the start lies in [-gyro_bias, gyro_bias]
  double gyro_bias_walk = 0.0;       ///< [rad/s/sqrt(s)]
  double accelerometer_sigma = 0.0;  ///< [m/s^2]
  double accelerometer_bias = 0.0;   ///< [m/s^2]
  Duration latency{};                ///< from a measurement to its arrival
};

/// Wheel odometry: encoders, and what is assumed of the wheels.
struct OdometrySpec {
  Duration period{};               ///< from sample to sample
  double wheel_scale = 0.0;        ///< the radius assumed of each wheel is off by a factor in 1 +- this, per episode
  double lateral_scale_min = 1.0;  ///< of what the wheels roll sideways, the body moves a share from here ...
  double lateral_scale_max = 1.0;  ///< ... to here, per episode; odometry does not know
  int ticks_per_turn = 0;          ///< encoder counts of one wheel turn; 0 = a perfect encoder
  Duration latency{};              ///< from a measurement to its arrival
};

/// How well a camera measures depth along its optical axis.
struct DepthSpec {
  double range_min = 0.0;  ///< [m], nearer is invalid
  double range_max = 0.0;  ///< [m], farther is invalid
  double sigma = 0.0;      ///< [m] at 1 m; it grows with the square of the depth, as for all that triangulates
};

/// A camera: what its level, rectified pinhole view shows, and how well.
struct CameraSpec {
  Pose2D base_from_camera;         ///< it looks along its x axis
  double mount_height = 0.0;       ///< [m] of its optical axis above the floor
  int width = 0;                   ///< [px]
  int height = 0;                  ///< [px]
  double horizontal_fov = 0.0;     ///< [rad]; pixels are square
  Duration period{};               ///< from image to image
  double sigma = 0.0;              ///< [levels of 255] of each pixel's colours
  Duration latency{};              ///< from an image to its arrival
  std::optional<DepthSpec> depth;  ///< empty for a camera without depth

  /// Of its rectified view.
  CameraIntrinsics intrinsics() const { return make_intrinsics(width, height, horizontal_fov); }
};

/// Ultrasonic sensors of one kind, pinged in turn so that none receives another's sound.
struct UltrasonicSpec {
  /// Where one of them is.
  struct Mount {
    std::string name;             ///< of the sensor, such as "ultrasonic_front_left"
    Pose2D base_from_ultrasonic;  ///< its x axis is the axis of the cone
  };
  std::vector<Mount> mounts;   ///< in the order in which they are pinged
  double height = 0.0;         ///< [m] of all of them above the floor
  Duration interval{};         ///< from one ping to the next, of another sensor
  double field_of_view = 0.0;  ///< [rad] of the cone of sound, from edge to edge
  double max_incidence = 0.0;  ///< [rad] off a surface's normal, beyond which no sound comes back
  double range_min = 0.0;      ///< [m]
  double range_max = 0.0;      ///< [m]
  double sigma = 0.0;          ///< [m] of each range
  Duration latency{};          ///< from a ping to the arrival of its range

  /// From one ping of a sensor to its next.
  Duration period() const { return static_cast<Duration::rep>(mounts.size()) * interval; }
};

/// A battery, and what the robot takes from it.
struct BatterySpec {
  double capacity = 0.0;          ///< [Wh]
  double voltage_full = 0.0;      ///< [V]
  double voltage_empty = 0.0;     ///< [V]
  double resistance = 0.0;        ///< [ohm], makes the voltage sag under load
  double idle_power = 0.0;        ///< [W] of everything but the drive
  double drive_efficiency = 1.0;  ///< mechanical power over electrical power of the drive
  Duration period{};              ///< from sample to sample
};

/// One ROS 2 topic of a robot.
struct TopicSpec {
  std::string sensor;     ///< as in `Features`; "depth" for the camera's depth image; "command" for velocities
  std::string topic;      ///< with its namespace, such as "/robot/scan"
  std::string type;       ///< such as "sensor_msgs/msg/LaserScan"
  bool reliable = false;  ///< lost samples are sent again; best effort receives from everyone
};

/// How the real robot is reached, and who stops it.
struct LinkSpec {
  std::string driver;                    ///< "ros2"
  std::string name_space;                ///< before every topic, such as "/robot"; may be empty
  std::vector<TopicSpec> topics;         ///< of the sensors that it delivers
  TopicSpec command;                     ///< where it takes velocities
  bool shared_command = false;           ///< other nodes may publish them as well, such as a joystick's
  std::string map_frame = "map";         ///< of other programs that localise the robot
  std::string odom_frame = "odom";       ///< in messages of transforms: odometry is the transform from there ...
  std::string base_frame = "base_link";  ///< ... to here
  std::string stopped_by;                ///< who stops the robot once commands cease, in words
  Duration stopped_after{};              ///< how long commands must have ceased for that
};

/// What a profile's `autonomy:` section sets in place of what follows from the rest of the profile.
struct ParameterOverride {
  std::string module;  ///< "nav", "slam", "health" or "safety"
  std::string name;    ///< of a parameter of that module, such as "recovery.same_place"
  double value = 0.0;  ///< in the parameter's unit; times in seconds
  std::string place;   ///< where it stands, for messages: "file:line: field"
  friend bool operator==(const ParameterOverride&, const ParameterOverride&) = default;
};

/// A robot, complete. Sensors it lacks are empty.
struct RobotProfile {
  std::string name;                           ///< that of its file
  std::string description;                    ///< one line
  Body body;                                  ///< outline, mass, wheels and motors
  Limits hardware_limits;                     ///< what the drive can do
  Limits operating_limits;                    ///< what it is asked to do by default
  Duration command_latency{};                 ///< from a command to its effect
  std::optional<LidarSpec> lidar;             ///< a planar lidar
  std::optional<IMUSpec> imu;                 ///< gyro and accelerometer
  std::optional<UltrasonicSpec> ultrasonics;  ///< all of one kind
  std::optional<CameraSpec> camera;           ///< colour, and depth where it measures any
  OdometrySpec odometry;                      ///< every robot has it
  std::optional<BatterySpec> battery;         ///< empty: it never runs out
  std::optional<LinkSpec> link;               ///< empty for one that is simulated alone
  std::vector<ParameterOverride> autonomy;    ///< parameters of the autonomy stack that this robot sets
  std::string yaml;                           ///< the text that it was read from; empty for one made in code

  /// Which velocities the base can drive.
  Kinematics kinematics() const { return body.wheels.kinematics; }
  /// Whether the robot has a sensor of a kind.
  bool has(SensorType type) const;
  /// Where a sensor of some kind and name is mounted; the base itself for those whose place does not matter.
  Pose2D base_from_sensor(SensorType type, std::string_view sensor) const;
  /// From a command to its effect, at most: latency, motor lag, and the control period in which it is given.
  Duration reaction() const { return command_latency + body.motor_lag + kControlPeriod; }
};

/// Reads assets/robots/NAME.yaml, or the file itself where `name` ends in .yaml. Throws ConfigError.
RobotProfile load_profile(std::string_view name);
/// The same of a text; `file` names the profile, and stands in messages. Throws ConfigError.
RobotProfile parse_profile(std::string yaml, const std::filesystem::path& file);
/// The names of all profiles.
std::vector<std::string> profile_names();

/// "realistic": every imperfection on. "ideal": each switched off, the sensors themselves left on.
enum class NoiseLevel : std::uint8_t { realistic, ideal };
/// Throws ConfigError naming the nearest right one.
NoiseLevel noise_level(std::string_view name);
/// The profile with the imperfections of its sensors and of its link switched off where `noise` is ideal. What the
/// body obeys (motor lag, torque, friction) stays.
RobotProfile with_noise(RobotProfile profile, NoiseLevel noise);

/// Width and height of an image [px].
struct ImageSize {
  int width = 0;   ///< [px]
  int height = 0;  ///< [px]
};

/// The same robot, whose camera delivers pictures of another size: with the same horizontal field of view and square
/// pixels. A robot without a camera stays as it is. Throws ConfigError for a size that no picture has.
RobotProfile with_image_size(RobotProfile profile, const ImageSize& size);

}  // namespace threewe
