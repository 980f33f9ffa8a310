// One robot in a scene, as MuJoCo moves it: a free body on wheels with rollers, driven by torque.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "backend/mujoco/world/library.hpp"
#include "threewe/core/kinematics.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/core/time.hpp"
#include "threewe/export/transform.hpp"
#include "threewe/hardware/profile.hpp"
#include "threewe/scene/scene.hpp"

namespace threewe::backend::mujoco {

/// What sensors read in; a whole number of MuJoCo's own, shorter steps. Two make a control period.
inline constexpr Duration kStep = 10ms;

using exports::Transform;

/// What happened to the body in one step, beyond where it is in the end.
struct Passage {
  double approach_speed = 0.0;   ///< [m/s], the fastest of its own motion into what it touched
  double distance_driven = 0.0;  ///< [m]
  // as the inertial unit has it, the mean over the step: contacts of rollers shake it faster than it is read
  double yaw_rate = 0.0;  ///< [rad/s]
  Vec2 acceleration;      ///< [m/s^2]
};

class Physics {
 public:
  /// Throws ConfigError where MuJoCo cannot be loaded or refuses the model.
  Physics(const scene::Scene& scene, const RobotProfile& profile);

  /// The world as a robot that stands at a pose finds it, at rest.
  void place(const Pose2D& pose);
  /// Somebody lifts the robot and puts it down at a pose, where it stands still; its wheels have turned as far as
  /// before.
  void carry(const Pose2D& pose);
  /// The first thing that a robot at a pose would stand in, if any. Changes nothing.
  std::optional<std::string> find_collision(const Pose2D& pose);
  /// Moves everything on by `kStep`, while motors turn the wheels to `setpoints` [rad/s] on a battery of `supply` times
  /// its nominal voltage. Throws ThreeweError when the physics has come apart.
  Passage step(const WheelSpeeds& setpoints, double supply);

  // The robot now, in the scene's frame.

  Pose2D pose() const;
  Velocity velocity() const;                   ///< in the base frame
  WheelSpeeds wheel_speeds() const;            ///< [rad/s]
  std::array<double, 4> wheel_angles() const;  ///< [rad] turned since it was placed
  /// Its base at the beginning of the last step, after each of MuJoCo's in it, and hence now, tilted as it may be.
  const std::vector<Transform>& track() const { return track_; }

  /// What a ray along a unit vector meets that is not the robot. One by one: `mj_multiRay` first works out the angles
  /// at which every geom is seen, which costs more than hundreds of rays do.
  struct Hit {
    double distance = 0.0;  ///< [m]; negative where nothing is met
    exports::Vec3 normal;   ///< of the surface
  };
  Hit cast(const exports::Vec3& from, const exports::Vec3& direction) const;

  /// All that its future depends on.
  std::vector<double> state() const;
  std::size_t state_size() const;
  void restore(std::span<const double> state);

 private:
  struct Free {
    const Library* library;
    void operator()(mjModel* model) const { library->mj_deleteModel(model); }
    void operator()(mjData* data) const { library->mj_deleteData(data); }
  };
  struct Wheel {
    int qpos = 0;
    int dof = 0;
    int actuator = 0;
  };

  void compile(const std::string& xml);
  void delete_rangefinders(mjSpec* spec) const;
  int id(mjtObj type, const std::string& name) const;
  void find_parts();
  void set_pose(const Pose2D& pose);
  void set_motors(const WheelSpeeds& setpoints, double supply);
  double approach_speed() const;
  bool is_obstacle(int geom) const {
    return !of_robot_[static_cast<std::size_t>(geom)] && !floor_[static_cast<std::size_t>(geom)];
  }
  Transform base() const;
  void require_sane() const;

  const Library& mj_;
  std::unique_ptr<mjModel, Free> model_;  // const but for the motors' limits, which follow from the state
  std::unique_ptr<mjData, Free> data_;
  double stall_torque_ = 0.0;   // [N m]
  double motor_damping_ = 0.0;  // [N m s/rad]
  int qpos_ = 0;                // where the base's pose begins
  int dof_ = 0;                 // and its velocity
  int gyro_ = -1;               // where its readings begin; -1 without one
  int accelerometer_ = -1;
  std::vector<Wheel> wheels_;
  std::vector<bool> of_robot_;  // of each geom
  std::vector<bool> floor_;
  int substeps_ = 0;
  std::vector<Transform> track_;
};

}  // namespace threewe::backend::mujoco
