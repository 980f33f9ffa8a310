// State of a world, for itself and for the runtimes of its robots.
#pragma once

#include <cstdint>
#include <exception>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "robot/real_time_pacer.hpp"
#include "robot/wait_list.hpp"
#include "threewe/robot/runtime.hpp"

namespace threewe {

/// What the minds of a world were made with, besides what the backend knows of: a state goes on only in a like one.
struct WorldSetup {
  std::string localization;
  std::shared_ptr<const map::OccupancyGrid> map;
  std::vector<Pose2D> initial_poses;
  std::vector<std::string> cameras;  // the size of each robot's pictures
};

struct World::Impl {
  std::unique_ptr<backend::World> backend;
  std::vector<std::unique_ptr<Runtime>> robots;
  WorldSetup setup;
  Autonomy autonomy;
  std::optional<World::Origin> origin;
  Time now{};              // the tick that begins next
  std::uint64_t seed = 0;  // of all noise, unless a reset is given another
  WaitList waits;
  int holds = 0;
  bool ticking = false;        // an observer may be running
  bool lockstep = true;        // time advances only when a caller advances it
  bool paced = false;          // to the wall clock
  bool one_map_frame = false;  // the robots' maps are in the same frame
  RealTimePacer pacer;
  std::string broken;                 // why time cannot go on; empty while it can
  std::exception_ptr observer_error;  // the first of this tick

  WaitHandle begin(Duration duration, WaitList::Kind kind);
  void require_no_tick() const;
  void require_possible(const WaitHandle& wait);
  Time current() const;  // of the tick that begins next, by a clock that may have gone on since the last one
  bool advance();        // false when the backend failed
  void begin_anew_at(Time time);
};

}  // namespace threewe
