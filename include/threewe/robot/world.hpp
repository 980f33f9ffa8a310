// A world and the robots in it, and robot time: when it may advance, and who waits for it.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "threewe/backend/world.hpp"
#include "threewe/core/time.hpp"

namespace threewe {

class Runtime;

/// Something that becomes true at a tick: a point in robot time, or the end of a motion.
class Wait {
 public:
  virtual ~Wait() = default;
  bool done() const { return done_; }
  /// When it was due: the time slept until, or the tick at which the motion ended.
  Time deadline() const { return deadline_; }
  std::uint64_t creation() const { return creation_; }

 private:
  friend class World;
  friend class Runtime;
  bool done_ = false;
  Time deadline_{};
  std::uint64_t creation_ = 0;
};
using WaitHandle = std::shared_ptr<Wait>;

/// One backend world with a runtime for each of its robots. Not thread-safe: one thread at a time may use it.
///
/// A tick is one control period (20 ms), and every robot in the world takes part:
///   act     plan, control, gate and command, with what was known at the tick's start
///   advance the backend moves time on by one period
///   sense   poll, localise, tell the observers, end what has ended
/// so that a command given between two ticks takes effect in the very next one.
class World {
 public:
  struct Options : backend::WorldOptions {
    std::string backend = "mock";
    bool realtime = false;  ///< pace a lockstep world to the wall clock
  };
  explicit World(const Options& options);
  World(std::unique_ptr<backend::World> backend, bool realtime);
  ~World();

  std::size_t robot_count() const;
  Runtime& robot(std::size_t index);
  Time now() const;

  /// One control period. Never blocks on anything but the backend.
  void tick();
  /// Ticks until a pending wait is done, no wait is pending, or `wall` has passed. True when a wait was done.
  bool run(Duration wall);
  /// Ticks until `wait` is done (C++ programs; Python waits through its pump).
  void wait(const WaitHandle& wait);

  /// Becomes done at the first tick at or after now + `duration`.
  WaitHandle sleep(Duration duration);
  /// The same, but time does not advance for its sake (`has_pending` ignores it): a limit on what others wait for.
  WaitHandle alarm(Duration duration);
  /// Nobody waits for it any more: a sleep or an alarm is dropped and never done. A motion is not affected.
  void forget(const WaitHandle& wait);
  /// The waits that were done since the last call, by (deadline, creation).
  std::vector<WaitHandle> take_finished();
  bool has_pending() const;
  /// True when time goes by on its own: a real-time backend, or a lockstep one that is paced to the wall clock.
  bool realtime() const;
  /// [wall] until the next tick is due, during which `tick` would block; zero in lockstep and when late.
  Duration due() const;

  /// While a hold is open, robot time stands still (`thinking`). Closing it charges `charge` of robot time, which the
  /// next ticks work off before anything else resumes.
  void open_hold();
  WaitHandle close_hold(Duration charge);
  bool held() const;

  void reset(const backend::ResetOptions& options);
  /// Everything the future depends on: the backend and every robot's mind and gate. Throws ContractError while a
  /// motion is in progress.
  struct Snapshot;
  std::shared_ptr<const Snapshot> save() const;
  void restore(const std::shared_ptr<const Snapshot>& snapshot);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace threewe
