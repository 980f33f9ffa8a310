// Trials of the recorder: processes that are killed, disks that fail, power that is cut. Each checks what is left on
// the disk against what the program had been promised.
#pragma once

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <vector>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include "record/file_system.hpp"
#include "record/journal_file.hpp"
#include "threewe/core/errors.hpp"
#include "threewe/record/recorder.hpp"
#include "threewe/robot/runtime.hpp"
#include "threewe/robot/warning.hpp"

namespace threewe::record::trials {

/// An empty folder for as long as it lives.
class ScratchFolder {
 public:
  ScratchFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "recorder_XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("no scratch folder");
    path_ = name;
  }
  ~ScratchFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// Without syncs, which only a power cut misses: a disk that others keep busy takes a tenth of a second for each.
class UnsyncedFiles : public FileSystem {
 public:
  int sync(int /*file*/) override { return 0; }
};

/// A world whose robot is ready.
inline std::unique_ptr<World> make_world(const std::string& hardware = "3we_standard_v2") {
  World::Options options;
  options.robots = {hardware};
  options.image_size = ImageSize{32, 24};
  auto world = std::make_unique<World>(options);
  world->robot(0).connect();
  world->settle();
  return world;
}

/// What the program was promised, where a parent sees it after its child was killed.
struct Promises {
  std::atomic<int> finished{0};        // episodes whose end_episode has returned
  std::atomic<int> started{0};         // whose start_episode has returned
  std::atomic<std::int64_t> ticks{0};  // of the current one
};

/// Records `episodes` of `ticks` ticks each and keeps the promises.
inline void record(World& world, Recorder& recorder, int episodes, int ticks, Promises& promises) {
  for (int i = 0; i < episodes; ++i) {
    promises.ticks = 0;
    recorder.start_episode("trial", {{"number", std::int64_t{i}}});
    ++promises.started;
    for (int t = 0; t < ticks; ++t) {
      world.robot(0).set_velocity({0.2, 0.0, 0.5}, 1s);
      world.tick();
      ++promises.ticks;
    }
    recorder.end_episode(true);
    ++promises.finished;
  }
}

/// Ticks that may be lost of the current episode: those of a second.
inline constexpr std::int64_t kMostLost = 50;

/// What is wrong with a folder after a crash; empty where all promises were kept. `most_lost` ticks of the current
/// episode may be missing.
inline std::string check_folder(const std::filesystem::path& folder, int finished, std::int64_t ticks_of_each,
                                std::int64_t ticks, std::int64_t most_lost = kMostLost) {
  try {
    (void)recover(folder, std::make_shared<UnsyncedFiles>());
    int whole = 0;
    std::int64_t rest = -1;
    for (const auto& file : journals(folder)) {
      const Journal journal = Journal::open(file);
      const auto count = static_cast<std::int64_t>(journal.robots().front().ticks.size());
      if (!journal.recovered() && count != ticks_of_each) return fmt::format("{} has {} ticks", file.string(), count);
      if (count == ticks_of_each && static_cast<int>(journal.episode()) < finished) ++whole;
      if (static_cast<int>(journal.episode()) == finished) rest = count;
    }
    if (whole != finished) return fmt::format("{} of {} finished episodes", whole, finished);
    if (ticks > most_lost && rest < ticks - most_lost) return fmt::format("{} of {} ticks of the last", rest, ticks);
    return {};
  } catch (const std::exception& error) {
    return error.what();
  }
}

// Kills

/// Kills its process at one of its calls: before it, after it, or in the middle of a write.
class KillingFiles : public UnsyncedFiles {
  [[noreturn]] static void die() {
    ::raise(SIGKILL);
    std::abort();
  }
  template <typename Call>
  auto around(const Call& call) {
    const int number = calls_++;
    if (number == call_ && when_ != When::after) die();
    const auto result = call();
    if (number == call_ && when_ == When::after) die();
    return result;
  }

 public:
  enum class When { before, middle, after };
  KillingFiles(int call, When when) : call_(call), when_(when) {}
  int open(const char* path, int flags, unsigned mode) override {
    return around([&] { return FileSystem::open(path, flags, mode); });
  }
  ssize_t write(int file, const void* data, std::size_t size) override {
    if (calls_ == call_ && when_ == When::middle) {
      (void)FileSystem::write(file, data, size / 2);
      die();
    }
    return around([&] { return FileSystem::write(file, data, size); });
  }
  int sync(int file) override {
    return around([&] { return UnsyncedFiles::sync(file); });
  }
  int close(int file) override {
    return around([&] { return FileSystem::close(file); });
  }
  int rename(const char* from, const char* to) override {
    return around([&] { return FileSystem::rename(from, to); });
  }

 private:
  std::atomic<int> calls_{0};
  int call_;
  When when_;
};

/// Forks a process that records, and kills it: at a random time, or at one of its calls of the operating system.
/// Returns what is wrong then; empty where nothing is.
inline std::string kill_trial(World& world, std::uint64_t seed) {
  constexpr int kEpisodes = 4;
  constexpr int kTicks = 120;
  std::mt19937_64 draw(seed);
  const ScratchFolder folder;
  void* shared = ::mmap(nullptr, sizeof(Promises), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  auto* promises = new (shared) Promises();
  const bool at_a_call = draw() % 2 == 0;
  RecorderOptions options;
  options.sensors = {"lidar", "imu", "odometry"};
  options.files = std::make_shared<UnsyncedFiles>();
  if (at_a_call) {
    const auto when = static_cast<KillingFiles::When>(draw() % 3);
    options.files = std::make_shared<KillingFiles>(static_cast<int>(draw() % 60), when);
  }
  const pid_t child = ::fork();
  if (child == 0) {
    try {
      Recorder recorder(world, folder.path(), options);
      record(world, recorder, kEpisodes, kTicks, *promises);
    } catch (...) {
      std::_Exit(1);
    }
    std::_Exit(0);
  }
  if (!at_a_call) {
    ::usleep(static_cast<useconds_t>(draw() % 60'000));
    ::kill(child, SIGKILL);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  std::string wrong = WIFEXITED(status) && WEXITSTATUS(status) != 0 ? "the recorder failed" : "";
  const int finished = promises->finished;
  const std::int64_t ticks = promises->started > finished ? promises->ticks.load() : 0;
  if (wrong.empty()) wrong = check_folder(folder.path(), finished, kTicks, ticks);
  ::munmap(shared, sizeof(Promises));
  return wrong.empty() ? "" : fmt::format("seed {}: {}", seed, wrong);
}

// Disks that fail

/// Lets one call fail, or a write be short.
class FailingFiles : public UnsyncedFiles {
 public:
  FailingFiles(int call, int error) : call_(call), error_(error) {}
  int open(const char* path, int flags, unsigned mode) override {
    return fails() && error_ != 0 ? -1 : FileSystem::open(path, flags, mode);
  }
  ssize_t write(int file, const void* data, std::size_t size) override {
    if (!fails()) return FileSystem::write(file, data, size);
    return error_ == 0 ? FileSystem::write(file, data, (size + 1) / 2) : -1;  // 0: a short write
  }
  int sync(int file) override { return fails() && error_ != 0 ? -1 : UnsyncedFiles::sync(file); }
  int close(int file) override {
    const bool failed = fails() && error_ != 0;
    const int result = FileSystem::close(file);
    if (failed) errno = error_;
    return failed ? -1 : result;
  }
  int rename(const char* from, const char* to) override {
    return fails() && error_ != 0 ? -1 : FileSystem::rename(from, to);
  }
  int calls() const { return calls_; }

 private:
  bool fails() {
    if (calls_++ != call_) return false;
    errno = error_;
    return true;
  }
  std::atomic<int> calls_{0};
  int call_;
  int error_;
};

/// Records three episodes on a disk whose call number `call` fails with `error` (0: a short write; -1: none). Returns
/// what is wrong then: an error that is none of ours, or what was promised and is not there. `calls` are those made.
inline std::string fault_trial(World& world, int call, int error, int& calls) {
  constexpr int kEpisodes = 3;
  constexpr int kTicks = 60;
  const ScratchFolder folder;
  const auto files = std::make_shared<FailingFiles>(call, error);
  RecorderOptions options;
  options.files = files;
  Promises promises;
  std::set<int> finished;
  const auto warnings = set_warning_handler([](std::string_view) {});
  std::string wrong;
  try {
    Recorder recorder(world, folder.path(), options);
    for (int i = 0; i < kEpisodes; ++i) {
      try {
        const auto number = static_cast<int>(recorder.start_episode("trial"));
        for (int t = 0; t < kTicks; ++t) world.tick();
        recorder.end_episode(true);
        finished.insert(number);
      } catch (const RecordingError&) {  // as it should: and the next may work again
      }
    }
  } catch (const RecordingError&) {
  } catch (const std::exception& other) {
    wrong = other.what();
  }
  (void)set_warning_handler(warnings);
  calls = files->calls();
  if (!wrong.empty()) return wrong;
  if (error == 0 && finished.size() != kEpisodes) return "a short write is no error";
  if (static_cast<int>(finished.size()) < kEpisodes - 1 && call > 0) return "one failure spoilt more than one episode";
  try {
    (void)recover(folder.path(), std::make_shared<UnsyncedFiles>());
    std::set<int> there;
    for (const auto& file : journals(folder.path())) {
      const Journal journal = Journal::open(file);
      if (journal.robots().front().ticks.size() == kTicks) there.insert(static_cast<int>(journal.episode()));
    }
    for (const int number : finished) {
      if (!there.contains(number)) return fmt::format("episode {} is not there", number);
    }
  } catch (const std::exception& unreadable) {
    return unreadable.what();
  }
  return {};
}

// Power cuts

/// Keeps what a disk was told, in order.
class LoggedFiles : public UnsyncedFiles {
 public:
  struct Call {
    enum class Kind { create, write, sync, rename, unlink, sync_folder } kind;
    std::string path, to;
    std::vector<char> data;
    int finished = 0;  // episodes that the program had been promised when it was made
    std::int64_t ticks = 0;
  };
  explicit LoggedFiles(const Promises& promises) : promises_(promises) {}

  int open(const char* path, int flags, unsigned mode) override {
    const int file = FileSystem::open(path, flags, mode);
    const std::scoped_lock lock(mutex_);
    names_[file] = path;
    folders_.erase(file);
    if ((flags & O_DIRECTORY) != 0) folders_.insert(file);
    if ((flags & O_CREAT) != 0) log({Call::Kind::create, path, {}, {}});
    return file;
  }
  ssize_t write(int file, const void* data, std::size_t size) override {
    const std::scoped_lock lock(mutex_);
    const auto* bytes = static_cast<const char*>(data);
    log({Call::Kind::write, names_[file], {}, {bytes, bytes + size}});
    return FileSystem::write(file, data, size);
  }
  int sync(int file) override {
    const int result = UnsyncedFiles::sync(file);
    const std::scoped_lock lock(mutex_);
    log({folders_.contains(file) ? Call::Kind::sync_folder : Call::Kind::sync, names_[file], {}, {}});
    return result;
  }
  int rename(const char* from, const char* to) override {
    const std::scoped_lock lock(mutex_);
    log({Call::Kind::rename, from, to, {}});
    return FileSystem::rename(from, to);
  }
  int unlink(const char* path) override {
    const std::scoped_lock lock(mutex_);
    log({Call::Kind::unlink, path, {}, {}});
    return FileSystem::unlink(path);
  }
  std::vector<Call> calls() {
    const std::scoped_lock lock(mutex_);
    return calls_;
  }

 private:
  void log(Call call) {
    call.finished = promises_.finished;
    call.ticks = promises_.started > call.finished ? promises_.ticks.load() : 0;
    calls_.push_back(std::move(call));
  }
  const Promises& promises_;
  std::mutex mutex_;
  std::vector<Call> calls_;
  std::map<int, std::string> names_;
  std::set<int> folders_;
};

/// What a disk may hold after the first `count` calls and a power cut: what was synced; of the rest each write there,
/// torn, or not, in any order; each name there or not.
inline void make_disk(const std::vector<LoggedFiles::Call>& calls, std::size_t count, std::mt19937_64& draw,
                      const std::filesystem::path& from, const std::filesystem::path& to) {
  using Kind = LoggedFiles::Call::Kind;
  struct Content {
    std::vector<char> bytes;
    std::size_t synced = 0;
  };
  std::map<std::string, std::shared_ptr<Content>> now, durable;        // names, as programs see them and as synced
  std::vector<std::map<std::string, std::shared_ptr<Content>>> since;  // names after each change since
  for (std::size_t i = 0; i < count; ++i) {
    const LoggedFiles::Call& call = calls[i];
    switch (call.kind) {
      case Kind::create:
        if (!now.contains(call.path)) now[call.path] = std::make_shared<Content>();
        since.push_back(now);
        break;
      case Kind::write: {
        auto& bytes = now[call.path]->bytes;
        bytes.insert(bytes.end(), call.data.begin(), call.data.end());
        break;
      }
      case Kind::sync: now[call.path]->synced = now[call.path]->bytes.size(); break;
      case Kind::rename:
        now[call.to] = now[call.path];
        now.erase(call.path);
        since.push_back(now);
        break;
      case Kind::unlink:
        now.erase(call.path);
        since.push_back(now);
        break;
      case Kind::sync_folder:
        durable = now;
        since.clear();
        break;
    }
  }
  const std::size_t reached = draw() % (since.size() + 1);  // changes of names happen in order, up to some point
  const auto& names = reached == 0 ? durable : since[reached - 1];
  constexpr std::size_t kSector = 512;
  for (const auto& [name, content] : names) {
    std::vector<char> bytes = content->bytes;
    std::size_t size = content->synced + draw() % (bytes.size() - content->synced + 1);
    if (draw() % 3 == 0) size = bytes.size();
    bytes.resize(size);
    for (std::size_t at = content->synced; at < size; at += kSector) {  // sectors that were not written are zeros
      if (draw() % 3 != 0) continue;
      const std::size_t end = std::min(size, at + kSector);
      std::fill(bytes.begin() + static_cast<std::ptrdiff_t>(at), bytes.begin() + static_cast<std::ptrdiff_t>(end), 0);
    }
    const auto path = to / std::filesystem::path(name).lexically_relative(from);
    std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  }
}

/// Records three episodes, cuts the power after each call that the disk was given, `disks` times each, and checks what
/// is left. Returns what is wrong, and counts the disks.
inline std::string power_cut_trial(World& world, std::uint64_t seed, int disks, int& made) {
  constexpr int kEpisodes = 3;
  constexpr int kTicks = 80;
  const ScratchFolder folder;
  Promises promises;
  const auto files = std::make_shared<LoggedFiles>(promises);
  {
    RecorderOptions options;
    options.files = files;
    Recorder recorder(world, folder.path(), options);
    record(world, recorder, kEpisodes, kTicks, promises);
  }
  const auto calls = files->calls();
  std::mt19937_64 draw(seed);
  for (std::size_t count = 0; count <= calls.size(); ++count) {
    for (int disk = 0; disk < disks; ++disk) {
      const ScratchFolder left;
      make_disk(calls, count, draw, folder.path(), left.path());
      ++made;
      // a promise that was given after a call holds for the power cuts behind the next one
      const int finished = count == 0 ? 0 : calls[count - 1].finished;
      const std::string wrong = check_folder(left.path(), finished, kTicks, 0);
      if (!wrong.empty()) return fmt::format("seed {}, after {} calls: {}", seed, count, wrong);
    }
  }
  return {};
}

}  // namespace threewe::record::trials
