// Trajectory recorder: a crash-safe journal of what robots sense, are asked for and do, one file an episode.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "threewe/core/samples.hpp"
#include "threewe/robot/world.hpp"

namespace threewe::record {

class FileSystem;

/// What a user says of an episode besides its task.
using Metadata = std::map<std::string, std::variant<bool, std::int64_t, double, std::string>>;

/// Which robots and sensors are recorded, and how.
struct RecorderOptions {
  std::vector<std::size_t> robots = {};    ///< indices into the world; all of them where empty
  std::vector<std::string> sensors = {};   ///< names; all of them where empty
  bool encoder = false;                    ///< an encoder thread compresses colour, see `next_frame`
  std::shared_ptr<FileSystem> files = {};  ///< the machine's own where null; tests let it fail
};

/// One camera image on its way into a journal.
struct Frame {
  std::size_t robot = 0;       ///< among those recorded
  std::uint16_t sensor = 0;    ///< index into the robot's `Features::sensors`
  std::uint64_t sequence = 0;  ///< of the sample
  Picture picture;             ///< the image itself
};

/// Records robots of a world at every tick, from `start_episode` to `end_episode`.
///
/// Ticks never wait for the disk: they append to a buffer that a thread compresses and writes every quarter of a second
/// of robot time and syncs at most every 0.4 s. Images are drawn and compressed outside of the tick, too. In lockstep
/// time waits where these fall behind; in real time images are kept raw instead. None is ever dropped.
///
/// A process that is killed loses less than the last second of the current episode and nothing of those before; see
/// `recover`. Where the disk fails, the robots go on, the recorder warns once, and `end_episode` throws.
class Recorder {
 public:
  /// Of a world that outlives it. Makes `folder` where there is none. Throws ContractError for a robot that is not
  /// there, ConfigError for a sensor that no robot has, RecordingError where the folder cannot be written or another
  /// recorder writes into it.
  Recorder(World& world, const std::filesystem::path& folder, const RecorderOptions& options = {});
  /// As `close`.
  ~Recorder();
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  /// Begins an episode with the next tick and returns its number, which no other of the folder has. Throws
  /// ContractError where one has begun already.
  std::size_t start_episode(const std::string& task, const Metadata& metadata = {});
  /// Ends it, with or without a judgement; `more` is added to its metadata. Returns when it is safe on the disk.
  /// Throws ContractError where none has begun, RecordingError where the disk failed.
  void end_episode(std::optional<bool> success = std::nullopt, const Metadata& more = {});
  /// Forgets it.
  void discard_episode();
  /// Lets go of the robots and of the folder. An episode that has not ended is left as a killed process would leave it:
  /// `recover` finds it. No episode begins any more.
  void close();
  /// Whose robots it records.
  World& world() const;
  /// Whether an episode has begun.
  bool recording() const;
  /// Ticks of the current episode.
  std::size_t ticks() const;

  /// An action of the user's own loop, as the user counts it, at the present robot time. Throws ContractError unless it
  /// is finite, and as long as those before.
  void record_step(std::size_t robot, std::span<const double> action);
  /// What the robot is asked to do from now on, where that changes within an episode.
  void set_instruction(std::size_t robot, const std::string& instruction);
  /// Whether a person drives from now on, who corrects a policy.
  void set_takeover(std::size_t robot, bool takeover);

  // For the thread of an encoder: each frame that it takes it has to put.
  /// The oldest image that is not in the journal yet. Waits for it; empty when the recorder is closed or the encoder
  /// was detached.
  std::optional<Frame> next_frame();
  /// Stores its colour as an H.264 access unit, an intra frame with all of its parameter sets; and its depth.
  void put_packet(const Frame& frame, std::span<const std::byte> packet);
  /// Stores its colour raw, and its depth.
  void put_raw(const Frame& frame);
  /// No thread calls `next_frame` any more: it returns empty, and images are kept raw from now on.
  void detach_encoder();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// What one tick of one robot was.
struct RecordedTick {
  Time now{};                     ///< at the end of the tick
  Pose2D map_from_base;           ///< the estimate
  Pose2D odom_from_base;          ///< the same without corrections of drift
  Velocity velocity;              ///< estimated, in the body frame
  Velocity requested;             ///< before the safety gate
  Velocity executed;              ///< after it
  std::uint8_t intervention = 0;  ///< of the gate, a safety::Intervention
  bool lost = false;              ///< it did not know where it was
  bool takeover = false;          ///< a person drove
  bool simulated = false;         ///< there is a truth
  Pose2D true_pose;               ///< in the scene's frame
  Velocity true_velocity;         ///< in the body frame
};

/// An action of a user's own loop.
struct RecordedStep {
  Time now{};                  ///< when it was given
  std::vector<double> action;  ///< as the user counts it
};

/// What a robot was asked to do from a time on.
struct RecordedInstruction {
  Time now{};        ///< since when
  std::string text;  ///< in words
};

/// Where the image of a camera sample is in the journal.
struct RecordedFrame {
  std::uint16_t sensor = 0;               ///< index into the robot's sensors
  std::uint64_t sequence = 0;             ///< of the sample
  Time measured{};                        ///< when it was taken
  Time received{};                        ///< when it was at hand
  int width = 0;                          ///< [px]
  int height = 0;                         ///< [px]
  bool encoded = false;                   ///< as an H.264 access unit; raw otherwise
  std::size_t color = 0;                  ///< number of its record, for `Journal::color`
  std::optional<std::size_t> depth = {};  ///< the same for `Journal::depth`
};

/// One robot of an episode.
struct RecordedRobot {
  std::string profile;                            ///< the name of its hardware profile
  std::string hardware;                           ///< the profile's YAML; empty where that was made in code
  std::optional<Pose2D> scene_from_map = {};      ///< see `World::scene_from_map`
  std::vector<SensorInfo> sensors;                ///< as `Sample::sensor` counts them
  std::vector<CameraIntrinsics> cameras;          ///< by the same number; without pixels where it is no camera
  std::vector<RecordedTick> ticks;                ///< in order
  std::vector<Sample> samples;                    ///< in order of arrival; a camera's hold no image
  std::vector<RecordedFrame> frames;              ///< the images of camera samples, in order of arrival
  std::vector<RecordedStep> steps;                ///< of `Recorder::record_step`
  std::vector<RecordedInstruction> instructions;  ///< of `Recorder::set_instruction`
};

/// One recorded episode, read from its file.
class Journal {
 public:
  /// Throws ConfigError naming file and byte where it is no finished journal.
  static Journal open(const std::filesystem::path& file);
  /// Takes over what another has read.
  Journal(Journal&&) noexcept;
  /// The same.
  Journal& operator=(Journal&&) noexcept;
  ~Journal();

  /// Its number in its folder.
  std::size_t episode() const;
  /// What the robots were to do.
  const std::string& task() const;
  /// Whether that was done; empty where it was not judged.
  std::optional<bool> success() const;
  /// As it began and as it ended.
  Metadata metadata() const;
  /// It was cut off while it was recorded.
  bool recovered() const;
  /// Wall clock [s since 1970] at its start.
  double started() const;
  /// Those that were recorded.
  const std::vector<RecordedRobot>& robots() const;
  /// The world that the robots were in, where it was made by name.
  const std::optional<World::Origin>& origin() const;
  /// Of the backend as the episode began; empty where it cannot save.
  std::span<const std::byte> initial_state() const;
  /// Robot time as it began.
  Time began() const;

  /// The bytes of a frame: an access unit, or (H, W, 3) blue, green, red.
  std::vector<std::byte> color(const RecordedFrame& frame) const;
  /// (H, W) [mm], 0 where invalid. Throws ContractError for a frame without depth.
  std::vector<std::uint16_t> depth(const RecordedFrame& frame) const;

 private:
  Journal();
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// What a journal says at its beginning.
struct JournalHeader {
  std::size_t episode = 0;          ///< its number in its folder
  std::string task;                 ///< what the robots were to do
  std::vector<std::string> robots;  ///< the names of their hardware profiles
};
/// Reads no more of a journal than that, however long it is. Throws as `Journal::open`.
JournalHeader read_header(const std::filesystem::path& journal);

/// What `recover` did with a journal that was cut off.
struct Recovered {
  std::filesystem::path file;  ///< the finished journal; empty where nothing of it could be saved
  std::size_t ticks = 0;       ///< of its first robot
  std::size_t lost_bytes = 0;  ///< torn at its end
};
/// Finishes the journals in a folder that a crash has cut off. Throws RecordingError where the folder cannot be written
/// or a recorder writes into it; ConfigError naming a file that no crash has left like that, once the others are
/// finished.
std::vector<Recovered> recover(const std::filesystem::path& folder, const std::shared_ptr<FileSystem>& files = {});
/// The finished journals of a folder, by their numbers.
std::vector<std::filesystem::path> journals(const std::filesystem::path& folder);

/// How far a replay came from what was recorded.
struct ReplayReport {
  std::size_t ticks = 0;                      ///< that were replayed
  double max_deviation = 0.0;                 ///< [m] between true positions
  std::optional<Time> first_difference = {};  ///< of any bit of a true pose or a sample
};
/// Makes the world of an episode anew, begins in its initial state and sends each robot the commands that were
/// executed. Throws ContractError for an episode of a world that cannot be made or restored.
ReplayReport replay(const Journal& journal);

}  // namespace threewe::record
