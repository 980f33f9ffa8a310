// A scene with robots and people, as MuJoCo moves it: robots are free bodies on wheels with rollers, driven by torque;
// people are led.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "backend/mujoco/world/library.hpp"
#include "export/mjcf.hpp"
#include "export/transform.hpp"
#include "sim/model.hpp"
#include "sim/people.hpp"
#include "threewe/core/kinematics.hpp"
#include "threewe/core/pose.hpp"
#include "threewe/models/randomization.hpp"

namespace threewe::backend::mujoco {

using exports::Transform;

/// The commands of a robot's motors for one step.
struct Drive {
  WheelSpeeds setpoints{};         ///< [rad/s]
  double supply = 1.0;             ///< the battery's voltage over the nominal one
  std::array<double, 4> shares{};  ///< of the torque that comes of it
};

/// What happened to a body in one step, beyond where it is in the end.
struct Passage {
  double approach_speed = 0.0;   ///< [m/s], the fastest of its own motion into what it touched
  double distance_driven = 0.0;  ///< [m]
  // as the inertial unit has it, the mean over the step: contacts of rollers shake it faster than it is read
  double yaw_rate = 0.0;  ///< [rad/s]
  Vec2 acceleration;      ///< [m/s^2]
};

/// The name of a robot in the model.
std::string robot_name(std::size_t robot);
/// Where the seven numbers of a free joint put its body.
Transform placement(const double* qpos);

class Physics {
 public:
  /// Throws ConfigError where MuJoCo cannot be loaded or refuses the model.
  explicit Physics(std::shared_ptr<const sim::Model> world);

  /// All robots stand at rest, and people are where they are. Rays may be cast at once.
  void place(std::span<const Pose2D> poses, std::span<const sim::PersonState> people);
  /// Lifts a robot and puts it down at a pose, where it stands still; its wheels have turned as far as before.
  void teleport(std::size_t robot, const Pose2D& pose);
  /// A robot has another mass, its wheels another friction, its motors another lag.
  void vary(std::size_t robot, const models::Variation& variation);
  /// Where people are.
  void lead(std::span<const sim::PersonState> people);
  /// Moves everything on by `sim::kStep`; what happened to each robot is valid until the next call. Throws ThreeweError
  /// when the physics has come apart.
  std::span<const Passage> step(std::span<const Drive> drives);

  // A robot now, in the scene's frame.

  Pose2D pose(std::size_t robot) const;
  Velocity velocity(std::size_t robot) const;                   ///< in the base frame
  WheelSpeeds wheel_speeds(std::size_t robot) const;            ///< [rad/s]
  std::array<double, 4> wheel_angles(std::size_t robot) const;  ///< [rad] turned since it was placed
  /// Its base at the beginning of the last step, after each of MuJoCo's in it, and hence now, tilted as it may be.
  const std::vector<Transform>& track(std::size_t robot) const { return robots_[robot].track; }

  /// From now on `cast` looks for this robot, which passes through itself.
  void look_for(std::size_t robot);
  /// What a ray along a unit vector meets. One by one: `mj_multiRay` first works out the angles at which every geom is
  /// seen, which costs more than hundreds of rays do.
  struct Hit {
    double distance = 0.0;  ///< [m]; negative where nothing is met
    exports::Vec3 normal;   ///< of the surface
  };
  Hit cast(const exports::Vec3& from, const exports::Vec3& direction) const;

  /// What it steps, where robots are as their profiles say.
  const mjModel& model() const { return *nominal_; }
  /// All that its future depends on but for how robots vary.
  std::vector<double> state() const;
  /// Throws ContractError where the state is of another world.
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
    std::vector<int> treads;  // geoms that roll on the floor
  };
  struct Robot {
    int base = 0;    // its body; those of its wheels and rollers follow
    int bodies = 0;  // how many they are
    int qpos = 0;    // where the base's pose begins
    int dof = 0;     // and its velocity; those of all its joints follow
    int dofs = 0;    // how many they are
    int gyro = -1;   // where its readings begin; -1 without one
    int accelerometer = -1;
    std::vector<Wheel> wheels;
    std::vector<int> geoms;
    exports::WheelDrive drive;  // by the profile ...
    double friction = 0.0;
    double gain = 0.0;  // ... and as it varies
    double wheel_friction = 0.0;
    std::vector<Transform> track;
  };
  // Bodies that MuJoCo does not move.
  struct Person {
    int trunk = 0;
    std::array<int, 2> legs{};
  };

  int id(mjtObj type, const std::string& name) const;
  Robot find_robot(const exports::PlacedRobot& placed);
  Wheel find_wheel(const std::string& name) const;
  Person find_person(const scene::Person& person) const;
  void set_priorities();
  void set_pose(const Robot& robot, const Pose2D& pose);
  void set_friction(std::size_t robot);
  void set_motors(const Robot& robot, const Drive& drive);
  void note_contacts();
  void note_motion(std::size_t robot, std::size_t substep);
  Vec2 velocity_at(const Robot& robot, const double* point) const;
  Transform base(std::size_t robot) const;
  void require_sane() const;

  const Library& mj_;
  std::shared_ptr<const sim::Model> world_;
  std::unique_ptr<mjModel, Free> model_;  // what varies of it follows from the robots' variations and the state
  std::unique_ptr<mjData, Free> data_;
  std::unique_ptr<mjModel, Free> nominal_;  // as it was compiled
  std::vector<Robot> robots_;
  std::vector<Person> people_;
  std::vector<int> robot_of_;  // by geom; -1 for what belongs to none
  std::vector<bool> floor_;    // likewise
  std::size_t looking_ = 0;
  int substeps_ = 0;
  std::vector<Passage> passages_;
};

}  // namespace threewe::backend::mujoco
