// Options of learning environments: observations, localization, gate, randomization and autoreset.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "threewe/core/time.hpp"
#include "threewe/hardware/profile.hpp"
#include "threewe/models/localization.hpp"
#include "threewe/models/randomization.hpp"
#include "threewe/scene/scene.hpp"
#include "threewe/task/task.hpp"

namespace threewe::env {

/// What a robot observes besides the fields of its task. Each costs time only when it is asked for.
struct Observed {
  bool image = false;    ///< (H, W, 3) uint8 BGR
  bool depth = false;    ///< (H, W) float32 [m] along the optical axis, invalid = 0
  bool lidar = true;     ///< (beams,) float32 [m], no return = range_max, invalid = 0
  bool pose = true;      ///< (3,) float32: x, y [m], theta [rad] in the map frame, by `Localization`
  bool velocity = true;  ///< (3,) float32: vx, vy [m/s], omega [rad/s] in the body frame
  /// Names of the task's fields that are wanted; all where left out.
  std::optional<std::vector<std::string>> task_fields;
  bool if_there = false;  ///< of sensors that a robot lacks nothing is observed; else it is an error
};

/// Where `pose`, `velocity` and goals in the robot's frame come from.
enum class Localization : std::uint8_t {
  noisy,     ///< odometry, corrected with the errors of a localisation model
  odometry,  ///< the wheels alone
  truth      ///< Habitat's GPS and compass
};

/// What stands between an action and the robot.
enum class Gate : std::uint8_t {
  full,   ///< limits, acceleration and the collision monitor, as in `Robot`
  limits  ///< limits and acceleration alone
};

/// What happens to a world whose episode is over.
enum class Autoreset : std::uint8_t {
  next_step,  ///< the next step begins its next episode, and does nothing else
  same_step,  ///< the step that ends it begins the next; `Batch::final_observations` keeps what was seen last
  disabled    ///< nothing: the caller resets it before its next step
};

/// Makes the task of a batch.
using TaskFactory = std::function<std::unique_ptr<task::Task>(const task::TaskContext& context)>;

/// What a batch is made of.
struct Options {
  std::vector<std::shared_ptr<const scene::Scene>> scenes;  ///< each episode is in one of them, drawn by its seed
  TaskFactory task;                                         ///< makes the task for all worlds
  RobotProfile hardware;                                    ///< with its noise, see `with_noise`
  /// Without: what the gate goes by, as a `Robot`'s does, which knows no noise. `hardware` where left out.
  std::optional<RobotProfile> data_sheet;
  Observed observed;      ///< which observations are made
  int lidar_beams = 0;    ///< every k-th of the profile's; 0 = all
  int image_width = 64;   ///< [px] of the profile's view, with its horizontal field of view and square pixels; to 2048
  int image_height = 64;  ///< [px], to 2048
  Localization localization = Localization::noisy;  ///< where `pose`, `velocity` and `goal` come from
  models::LocalizationSpec localization_model;      ///< of `Localization::noisy`
  models::Randomization randomization;              ///< how robots differ from the profile
  /// Where left out: `full`; `limits` for a robot without the lidar that the collision monitor of a batch goes by.
  std::optional<Gate> gate{};
  int max_steps = 500;                         ///< an episode is truncated after so many
  Duration control_period = 100ms;             ///< of one step; a whole number of control periods of the robot
  std::size_t worlds = 1;                      ///< up to a million
  std::size_t robots = 1;                      ///< in each world
  std::size_t threads = 1;                     ///< at most; none has less than a world
  Autoreset autoreset = Autoreset::next_step;  ///< what follows the end of an episode
};

}  // namespace threewe::env
