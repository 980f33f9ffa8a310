#include "threewe/record/recorder.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <deque>
#include <exception>
#include <limits>
#include <mutex>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include "record/folder.hpp"
#include "record/journal_file.hpp"
#include "record/records.hpp"
#include "threewe/core/errors.hpp"
#include "threewe/robot/runtime.hpp"
#include "threewe/robot/warning.hpp"
#include "threewe/scene/truth_view.hpp"

namespace threewe::record {
namespace {

using Wall = std::chrono::steady_clock;

constexpr Duration kBlock = 250ms;                          // of robot time in a block
constexpr std::chrono::milliseconds kSync{400};             // of wall time between syncs, at least
constexpr std::size_t kMostFrames = 8;                      // on their way to the encoder
constexpr std::size_t kMostBlocks = 1;                      // on their way to the disk, in lockstep time
constexpr std::size_t kMostBytes = std::size_t{64} << 20U;  // the same in real time, where ticks cannot wait
constexpr std::size_t kLargeBlock = std::size_t{4} << 20U;  // [bytes] of which a block is no longer collected

void check_finite(const Metadata& metadata) {
  for (const auto& [name, value] : metadata) {
    const double* number = std::get_if<double>(&value);
    if (number != nullptr && !std::isfinite(*number)) {
      throw ContractError(fmt::format("metadata '{}' must be finite, got {}", name, *number));
    }
  }
}

std::span<const std::byte> bytes_of(const std::vector<std::uint8_t>& values) {
  return std::as_bytes(std::span(values));
}

FrameKey key_of(const Frame& frame) {
  const CameraIntrinsics& camera = frame.picture.image().intrinsics;
  return {static_cast<std::uint8_t>(frame.robot), frame.sensor, frame.sequence,
          static_cast<std::uint32_t>(camera.width), static_cast<std::uint32_t>(camera.height)};
}

}  // namespace

// One lock guards what the threads share: the ticks' own, the writer's, the encoder's. Only the writer touches the
// file while an episode is being recorded; no thread holds the lock while drawing, compressing or writing.
struct Recorder::Impl {
  Impl(World& of, const std::filesystem::path& where, const RecorderOptions& options);

  World& world;
  std::shared_ptr<FileSystem> files;
  std::optional<FolderLock> folder;  // until it is closed
  std::vector<std::size_t> robots;
  std::vector<std::string> sensors;

  std::mutex mutex;
  std::condition_variable changed;  // whatever is below
  RecordWriter pending;             // of the block that is being collected
  Time block_began{};
  std::deque<std::vector<std::byte>> blocks;  // complete, and not written
  std::size_t block_bytes = 0;
  std::deque<Frame> frames;  // not compressed
  std::size_t drawing = 0;   // frames that were taken from there, and are in no block yet
  bool writing = false;
  bool encoder = false;  // one takes frames
  bool closed = false;
  std::exception_ptr error;  // of the current episode
  bool warned = false;

  std::unique_ptr<JournalFile> file;  // while an episode is being recorded
  std::size_t tick_count = 0;
  std::vector<Time> last;  // of each robot's ticks
  std::vector<std::size_t> action_sizes;
  std::vector<char> takeover;
  Wall::time_point synced;

  // The observer of one robot, for as long as it lives.
  struct Observation {
    Observation(Impl& impl, std::uint8_t robot)
        : of(impl.world.robot(impl.robots[robot])),
          id(of.observe([&impl, robot](const TickView& view) { impl.on_tick(robot, view); })) {}
    ~Observation() { of.unobserve(id); }
    Observation(const Observation&) = delete;
    Observation& operator=(const Observation&) = delete;
    Runtime& of;
    std::uint64_t id;
  };
  // The thread that writes, for as long as it lives.
  struct Writer {
    explicit Writer(Impl& it) : impl(it), thread([&it] { it.write_until_closed(); }) {}
    ~Writer();
    Writer(const Writer&) = delete;
    Writer& operator=(const Writer&) = delete;
    Impl& impl;
    std::thread thread;
  };
  std::optional<Writer> writer;          // these two
  std::deque<Observation> observations;  // go first

  void on_tick(std::uint8_t robot, const TickView& view);
  bool chosen(const Runtime& robot, std::uint16_t sensor) const;
  void close_block();
  void wait_for_room(std::unique_lock<std::mutex>& lock);
  void fail(std::exception_ptr why);
  void warn_of_error(std::unique_lock<std::mutex>& lock);
  void write_until_closed();
  void write_block(std::unique_lock<std::mutex>& lock);
  void keep_raw(std::unique_lock<std::mutex>& lock);
  bool may_keep_raw() const;
  void put_color(const Frame& frame, bool encoded, std::span<const std::byte> color);
  void put_depth(const Frame& frame);
  void queue(RecordWriter& records);
  template <typename Work>
  void finish_frame(const Work& work);
  void drain(std::unique_lock<std::mutex>& lock);
  void end();
  void require_open() const;
  template <typename Work>
  void guarded(const Work& work);
};

Recorder::Impl::Impl(World& of, const std::filesystem::path& where, const RecorderOptions& options)
    : world(of),
      files(options.files ? options.files : std::make_shared<FileSystem>()),
      folder(std::in_place, *files, where),
      robots(options.robots),
      sensors(options.sensors),
      encoder(options.encoder) {
  if (robots.empty()) {
    for (std::size_t i = 0; i < world.robot_count(); ++i) robots.push_back(i);
  }
  for (const std::size_t i : robots) (void)world.robot(i);
  if (robots.size() > std::numeric_limits<std::uint8_t>::max()) throw ContractError("at most 255 robots are recorded");
  for (const std::string& name : sensors) {
    const auto has = [&](std::size_t i) {
      return std::ranges::any_of(world.robot(i).features().sensors, [&](const auto& s) { return s.name == name; });
    };
    if (std::ranges::none_of(robots, has)) throw ConfigError("no recorded robot has a sensor '" + name + "'");
  }
  takeover.assign(robots.size(), 0);
  writer.emplace(*this);
  for (std::size_t i = 0; i < robots.size(); ++i) observations.emplace_back(*this, static_cast<std::uint8_t>(i));
}

Recorder::Impl::Writer::~Writer() {
  {
    const std::scoped_lock lock(impl.mutex);
    impl.closed = true;
  }
  impl.changed.notify_all();
  thread.join();
}

Recorder::Recorder(World& world, const std::filesystem::path& folder, const RecorderOptions& options)
    : impl_(std::make_unique<Impl>(world, folder, options)) {}
Recorder::~Recorder() = default;

void Recorder::close() {
  impl_->observations.clear();
  impl_->writer.reset();
  impl_->file.reset();
  impl_->folder.reset();
}

// What ticks do

void Recorder::Impl::on_tick(std::uint8_t robot, const TickView& view) {
  std::unique_lock lock(mutex);
  if (!file) return;
  if (error) return warn_of_error(lock);
  if (view.now <= last[robot]) {
    fail(std::make_exception_ptr(RecordingError("the world began anew during an episode: end_episode before reset")));
    return warn_of_error(lock);
  }
  guarded([&] {
    if (pending.size() == 0) block_began = view.now;
    const backend::TruthService* service = world.truth_service();
    const scene::TruthView* truth = service == nullptr ? nullptr : &service->truth(robots[robot]);
    const RecordedTick tick{.now = view.now,
                            .map_from_base = view.pose.map_from_base(),
                            .odom_from_base = view.pose.odom_from_base,
                            .velocity = view.pose.velocity,
                            .requested = view.requested,
                            .executed = view.commanded.command,
                            .intervention = static_cast<std::uint8_t>(view.commanded.intervention),
                            .lost = view.pose.lost(),
                            .takeover = takeover[robot] != 0,
                            .simulated = truth != nullptr,
                            .true_pose = truth == nullptr ? Pose2D{} : truth->true_pose(),
                            .true_velocity = truth == nullptr ? Velocity{} : truth->true_velocity()};
    pending.put(robot, tick);
    for (const Sample& sample : view.samples) {
      if (!chosen(view.robot, sample.sensor)) continue;
      pending.put(robot, sample);
      if (const auto* picture = std::get_if<Picture>(&sample.data)) {
        frames.push_back({robot, sample.sensor, sample.sequence, *picture});
      }
    }
    last[robot] = view.now;
    if (robot == 0) ++tick_count;
    if (view.now - block_began >= kBlock || pending.size() >= kLargeBlock) close_block();
  });
  if (!blocks.empty() || !frames.empty()) changed.notify_all();
  wait_for_room(lock);
}

bool Recorder::Impl::chosen(const Runtime& robot, std::uint16_t sensor) const {
  return sensors.empty() || std::ranges::find(sensors, robot.features().sensors[sensor].name) != sensors.end();
}

void Recorder::Impl::close_block() {
  if (pending.size() == 0) return;
  blocks.push_back(pending.take());
  block_bytes += blocks.back().size();
}

// In lockstep time ticks wait for the disk and the encoder; in real time they cannot.
void Recorder::Impl::wait_for_room(std::unique_lock<std::mutex>& lock) {
  const auto full = [this] { return blocks.size() > kMostBlocks || frames.size() + drawing > kMostFrames; };
  if (!world.realtime()) changed.wait(lock, [&] { return error || !full(); });
  if (block_bytes <= kMostBytes) return;
  fail(std::make_exception_ptr(RecordingError("the disk does not keep up: 64 MiB wait to be written")));
  warn_of_error(lock);
}

void Recorder::Impl::fail(std::exception_ptr why) {
  if (!error) error = std::move(why);
  blocks.clear();
  block_bytes = 0;
  frames.clear();
  (void)pending.take();
  changed.notify_all();
}

template <typename Work>
void Recorder::Impl::guarded(const Work& work) {
  try {
    work();
  } catch (...) {
    fail(std::current_exception());
  }
}

// Once an episode, without the lock, since a handler may do anything.
void Recorder::Impl::warn_of_error(std::unique_lock<std::mutex>& lock) {
  if (std::exchange(warned, true)) return;
  const std::exception_ptr why = error;
  lock.unlock();
  try {
    std::rethrow_exception(why);
  } catch (const std::exception& it) {
    warn(std::string("this episode is not recorded any further: ") + it.what());
  }
  lock.lock();
}

// The thread that writes

void Recorder::Impl::write_until_closed() {
  std::unique_lock lock(mutex);
  while (true) {
    changed.wait(lock, [this] { return closed || !blocks.empty() || may_keep_raw(); });
    if (!blocks.empty()) {
      write_block(lock);
    } else if (may_keep_raw()) {
      keep_raw(lock);
    } else {
      break;  // closed
    }
  }
}

void Recorder::Impl::write_block(std::unique_lock<std::mutex>& lock) {
  const std::vector<std::byte> block = std::move(blocks.front());
  blocks.pop_front();
  block_bytes -= block.size();
  writing = true;
  lock.unlock();
  std::exception_ptr failed;
  try {
    file->append(block);
    if (Wall::now() - synced >= kSync) {
      file->sync();
      synced = Wall::now();
    }
  } catch (...) {
    failed = std::current_exception();
  }
  lock.lock();
  writing = false;
  if (failed) fail(failed);
  changed.notify_all();
}

// Without an encoder, and where it falls behind in real time.
bool Recorder::Impl::may_keep_raw() const {
  return !frames.empty() && (!encoder || (world.realtime() && frames.size() > kMostFrames));
}

void Recorder::Impl::keep_raw(std::unique_lock<std::mutex>& lock) {
  const Frame frame = std::move(frames.front());
  frames.pop_front();
  ++drawing;
  lock.unlock();
  finish_frame([&] {
    put_depth(frame);
    put_color(frame, false, bytes_of(frame.picture.image().color));
  });
  lock.lock();
}

// The last that is done for a frame: what it throws is an error of the episode.
template <typename Work>
void Recorder::Impl::finish_frame(const Work& work) {
  std::exception_ptr failed;
  try {
    work();
  } catch (...) {
    failed = std::current_exception();
  }
  const std::scoped_lock lock(mutex);
  --drawing;
  if (failed) fail(failed);
  changed.notify_all();
}

void Recorder::Impl::put_color(const Frame& frame, bool encoded, std::span<const std::byte> color) {
  RecordWriter records;
  records.put_color(key_of(frame), encoded, color);
  queue(records);
}

void Recorder::Impl::put_depth(const Frame& frame) {
  const RGBDImage& image = frame.picture.image();
  if (image.depth.empty()) return;
  RecordWriter records;
  records.put_depth(key_of(frame), image.depth);
  queue(records);
}

// Images get blocks of their own, which the ticks' buffer does not wait for.
void Recorder::Impl::queue(RecordWriter& records) {
  std::vector<std::byte> block = records.take();
  const std::scoped_lock lock(mutex);
  if (error) return;
  blocks.push_back(std::move(block));
  block_bytes += blocks.back().size();
  changed.notify_all();
}

// What the encoder does

std::optional<Frame> Recorder::next_frame() {
  Impl& it = *impl_;
  std::unique_lock lock(it.mutex);
  it.changed.wait(lock, [&] { return it.closed || !it.encoder || !it.frames.empty(); });
  if (it.closed || !it.encoder) return {};
  Frame frame = std::move(it.frames.front());
  it.frames.pop_front();
  ++it.drawing;
  return frame;
}

void Recorder::put_packet(const Frame& frame, std::span<const std::byte> packet) {
  impl_->finish_frame([&] {
    impl_->put_depth(frame);
    impl_->put_color(frame, true, packet);
  });
}

void Recorder::put_raw(const Frame& frame) {
  impl_->finish_frame([&] {
    impl_->put_depth(frame);
    impl_->put_color(frame, false, bytes_of(frame.picture.image().color));
  });
}

void Recorder::detach_encoder() {
  {
    const std::scoped_lock lock(impl_->mutex);
    impl_->encoder = false;
  }
  impl_->changed.notify_all();
}

// Episodes

std::size_t Recorder::start_episode(const std::string& task, const Metadata& metadata) {
  Impl& it = *impl_;
  if (!it.folder) throw ContractError("this recorder is closed: make another");
  if (it.file) throw ContractError("an episode has begun already: end_episode or discard_episode first");
  check_finite(metadata);
  Header header;
  header.task = task;
  header.metadata = metadata;
  header.began = it.world.now();
  header.origin = it.world.origin();
  header.started = std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
  bool can_save = true;
  for (const std::size_t i : it.robots) {
    const Runtime& robot = it.world.robot(i);
    can_save = can_save && robot.features().can_save;
    RecordedRobot& to = header.robots.emplace_back();
    to.profile = robot.profile().name;
    to.hardware = robot.profile().yaml;
    to.scene_from_map = it.world.scene_from_map(i);
    to.sensors = robot.features().sensors;
    for (const SensorInfo& sensor : to.sensors) {
      const bool camera = sensor.type == SensorType::camera && robot.profile().camera;
      to.cameras.push_back(camera ? robot.profile().camera->intrinsics() : CameraIntrinsics{});
    }
  }
  header.episode = it.folder->next_episode();
  RecordWriter first;
  first.put(header);
  if (can_save) first.put_state(it.world.save_backend());

  auto file = std::make_unique<JournalFile>(*it.files, it.folder->stem(header.episode));
  file->append(first.take());
  file->sync();
  sync_folder(*it.files, it.folder->path());

  const std::scoped_lock lock(it.mutex);
  it.file = std::move(file);
  it.error = nullptr;
  it.warned = false;
  it.tick_count = 0;
  it.last.assign(it.robots.size(), header.began);
  it.action_sizes.assign(it.robots.size(), 0);
  it.synced = Wall::now();
  return header.episode;
}

// Waits until all that was seen so far is in the file, or an error says why not.
void Recorder::Impl::drain(std::unique_lock<std::mutex>& lock) {
  guarded([&] { close_block(); });
  changed.notify_all();
  changed.wait(lock, [this] { return !writing && drawing == 0 && (error || (blocks.empty() && frames.empty())); });
}

void Recorder::Impl::end() {
  file.reset();
  takeover.assign(robots.size(), 0);
}

void Recorder::end_episode(std::optional<bool> success, const Metadata& more) {
  Impl& it = *impl_;
  it.require_open();
  check_finite(more);
  RecordWriter footer;
  footer.put({success, more});
  std::unique_lock lock(it.mutex);
  it.drain(lock);
  const std::exception_ptr error = it.error;
  try {
    if (error) std::rethrow_exception(error);
    it.file->append(footer.take());
    it.file->finish();
  } catch (...) {
    it.end();
    throw;
  }
  it.end();
}

void Recorder::discard_episode() {
  Impl& it = *impl_;
  it.require_open();
  std::unique_lock lock(it.mutex);
  it.fail(std::make_exception_ptr(RecordingError("discarded")));
  it.drain(lock);
  const auto file = std::move(it.file);
  it.end();
  file->discard();
}

void Recorder::Impl::require_open() const {
  if (!file) throw ContractError("no episode has begun: start_episode first");
}

World& Recorder::world() const { return impl_->world; }
bool Recorder::recording() const { return impl_->file != nullptr; }
std::size_t Recorder::ticks() const { return impl_->tick_count; }

void Recorder::record_step(std::size_t robot, std::span<const double> action) {
  Impl& it = *impl_;
  it.require_open();
  if (robot >= it.robots.size()) throw ContractError("no recorded robot " + std::to_string(robot));
  if (action.empty() || !std::ranges::all_of(action, [](double a) { return std::isfinite(a); })) {
    throw ContractError("action must hold finite numbers");
  }
  const std::scoped_lock lock(it.mutex);
  std::size_t& size = it.action_sizes[robot];
  if (size == 0) size = action.size();
  if (size != action.size()) throw ContractError(fmt::format("action has {} numbers, had {}", action.size(), size));
  it.guarded([&] {
    it.pending.put(static_cast<std::uint8_t>(robot), RecordedStep{it.world.now(), {action.begin(), action.end()}});
  });
}

void Recorder::set_instruction(std::size_t robot, const std::string& instruction) {
  Impl& it = *impl_;
  it.require_open();
  if (robot >= it.robots.size()) throw ContractError("no recorded robot " + std::to_string(robot));
  check_text(instruction);
  const std::scoped_lock lock(it.mutex);
  it.guarded(
      [&] { it.pending.put(static_cast<std::uint8_t>(robot), RecordedInstruction{it.world.now(), instruction}); });
}

void Recorder::set_takeover(std::size_t robot, bool takeover) {
  if (robot >= impl_->robots.size()) throw ContractError("no recorded robot " + std::to_string(robot));
  const std::scoped_lock lock(impl_->mutex);
  impl_->takeover[robot] = takeover ? 1 : 0;
}

}  // namespace threewe::record
