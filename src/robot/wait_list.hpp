// Wait list of one world: who waits for what.
#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "threewe/robot/world.hpp"

namespace threewe {

/// The waits that are pending, and those that are done and not yet reported.
class WaitList {
 public:
  enum class Kind : std::uint8_t { sleep, alarm, motion };

  /// `deadline` is when a sleep or an alarm ends; a motion ends by `end`.
  void add(const WaitHandle& wait, Kind kind, Time deadline) {
    wait->creation_ = creations_++;
    wait->deadline_ = deadline;
    pending_.push_back({wait, kind});
  }
  /// Ends one wait now. Does nothing when it is not pending.
  void end(const WaitHandle& wait, Time now) {
    const auto entry = find(wait);
    if (entry == pending_.end()) return;
    wait->deadline_ = now;
    finish(entry);
  }
  /// Ends the sleeps and alarms that are due.
  void end_due(Time now) {
    end_if([&](const Entry& e) { return e.kind != Kind::motion && e.wait->deadline() <= now; });
  }
  /// Time jumps: sleeps are done, and alarms jump along, for a limit counts the time that goes by.
  void begin_anew(Duration jump) {
    end_if([](const Entry& e) { return e.kind == Kind::sleep; });
    for (const Entry& e : pending_) {
      if (e.kind == Kind::alarm) e.wait->deadline_ += jump;
    }
  }
  void forget(const WaitHandle& wait) {
    const auto entry = find(wait);
    if (entry != pending_.end() && entry->kind != Kind::motion) pending_.erase(entry);
  }

  bool contains(const WaitHandle& wait) { return find(wait) != pending_.end(); }
  bool has_pending() const {
    return std::any_of(pending_.begin(), pending_.end(), [](const Entry& e) { return e.kind != Kind::alarm; });
  }
  bool has_finished() const { return !finished_.empty(); }
  /// Those that are done, by (deadline, creation).
  std::vector<WaitHandle> take_all() {
    std::sort(finished_.begin(), finished_.end(), [](const WaitHandle& a, const WaitHandle& b) {
      return std::pair(a->deadline(), a->creation()) < std::pair(b->deadline(), b->creation());
    });
    return std::exchange(finished_, {});
  }
  /// This one is reported.
  void take(const WaitHandle& wait) { std::erase(finished_, wait); }

 private:
  struct Entry {
    WaitHandle wait;
    Kind kind{};
  };
  using Iterator = std::vector<Entry>::iterator;

  Iterator find(const WaitHandle& wait) {
    return std::find_if(pending_.begin(), pending_.end(), [&](const Entry& e) { return e.wait == wait; });
  }
  Iterator finish(Iterator entry) {
    entry->wait->done_ = true;
    finished_.push_back(entry->wait);
    return pending_.erase(entry);
  }
  template <class Condition>
  void end_if(Condition&& condition) {
    for (auto entry = pending_.begin(); entry != pending_.end();) entry = condition(*entry) ? finish(entry) : entry + 1;
  }

  std::vector<Entry> pending_;
  std::vector<WaitHandle> finished_;
  std::uint64_t creations_ = 0;
};

}  // namespace threewe
