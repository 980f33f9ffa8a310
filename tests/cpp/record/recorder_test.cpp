#include "threewe/record/recorder.hpp"

#include <cmath>
#include <cstring>
#include <fstream>
#include <sstream>

#include <doctest/doctest.h>
#include <fmt/format.h>

#include "record/block.hpp"
#include "record/crash_trials.hpp"
#include "threewe/core/errors.hpp"
#include "threewe/hardware/profile.hpp"
#include "threewe/robot/robot.hpp"

using namespace threewe;
using namespace threewe::record;
using trials::ScratchFolder;

namespace {

// What a test keeps of a tick itself.
struct Seen {
  Time now{};
  Pose2D pose;
  Velocity executed;
  std::vector<Sample> samples;
};

template <typename T>
bool same_bytes(const T& a, const T& b) {
  return std::memcmp(&a, &b, sizeof(T)) == 0;  // NOLINT(bugprone-suspicious-memory-comparison): bit by bit, as asked
}

}  // namespace

TEST_CASE("a journal holds every tick and sample, as an observer sees them") {
  const ScratchFolder folder;
  World::Options options;
  options.robots = {"3we_depth_v2"};
  options.image_size = ImageSize{64, 48};
  World world(options);
  Robot robot(world);
  robot.connect();
  std::vector<Seen> seen;
  (void)robot.runtime().observe([&](const TickView& tick) {
    seen.push_back(
        {tick.now, tick.pose.map_from_base(), tick.commanded.command, {tick.samples.begin(), tick.samples.end()}});
  });
  Recorder recorder(world, folder.path());
  CHECK_THROWS_AS(recorder.end_episode(true), ContractError);
  CHECK(recorder.start_episode("go there", {{"floor", std::int64_t{2}}, {"who", std::string("me")}}) == 0);
  CHECK_THROWS_AS(recorder.start_episode("again"), ContractError);
  seen.clear();
  recorder.record_step(0, std::array{0.5, -1.0});
  (void)robot.wait(robot.move_to(1.0, 0.5));
  recorder.set_instruction(0, "and back");
  recorder.set_takeover(0, true);
  robot.sleep(0.5);
  recorder.end_episode(true, {{"rating", 0.5}});
  const std::size_t ticks = seen.size();
  robot.sleep(0.5);  // which is in no episode
  CHECK(recorder.start_episode("no") == 1);
  robot.sleep(1.0);
  recorder.discard_episode();
  CHECK(recorder.start_episode("more") == 1);
  recorder.end_episode();
  recorder.close();

  const auto files = journals(folder.path());
  REQUIRE(files.size() == 2);
  const Journal journal = Journal::open(files[0]);
  CHECK(journal.task() == "go there");
  CHECK(journal.success() == true);
  CHECK_FALSE(journal.recovered());
  CHECK(std::get<std::int64_t>(journal.metadata().at("floor")) == 2);
  CHECK(std::get<double>(journal.metadata().at("rating")) == 0.5);
  REQUIRE(journal.robots().size() == 1);
  const RecordedRobot& one = journal.robots()[0];
  CHECK(one.profile == "3we_depth_v2");
  REQUIRE(one.ticks.size() == ticks);
  std::size_t sample = 0;
  std::size_t frame = 0;
  for (std::size_t t = 0; t < ticks; ++t) {
    CHECK(one.ticks[t].now == seen[t].now);
    CHECK(same_bytes(one.ticks[t].map_from_base, seen[t].pose));
    CHECK(same_bytes(one.ticks[t].executed, seen[t].executed));
    for (const Sample& it : seen[t].samples) {
      REQUIRE(sample < one.samples.size());
      const Sample& kept = one.samples[sample++];
      CHECK(kept.sensor == it.sensor);
      CHECK(kept.sequence == it.sequence);
      CHECK(kept.measured == it.measured);
      CHECK(kept.received == it.received);
      if (const auto* scan = std::get_if<LaserScan>(&it.data)) {
        CHECK(std::get<LaserScan>(kept.data).ranges == scan->ranges);
      }
      if (const auto* picture = std::get_if<Picture>(&it.data)) {
        REQUIRE(frame < one.frames.size());
        const RecordedFrame& stored = one.frames[frame++];
        const auto color = journal.color(stored);
        REQUIRE(color.size() == picture->image().color.size());
        CHECK(std::memcmp(color.data(), picture->image().color.data(), color.size()) == 0);
        const auto depth = journal.depth(stored);
        REQUIRE(depth.size() == picture->image().depth.size());
        for (std::size_t i = 0; i < depth.size(); ++i) {
          CHECK(std::abs(1e-3 * depth[i] - static_cast<double>(picture->image().depth[i])) <= 0.000501);
        }
      }
    }
  }
  CHECK(sample == one.samples.size());
  CHECK(frame == one.frames.size());
  CHECK(frame > 20);
  REQUIRE(one.steps.size() == 1);
  CHECK(one.steps[0].action == std::vector{0.5, -1.0});
  REQUIRE(one.instructions.size() == 1);
  CHECK(one.instructions[0].text == "and back");
  CHECK_FALSE(one.ticks.front().takeover);
  CHECK(one.ticks.back().takeover);
  CHECK(Journal::open(files[1]).robots()[0].ticks.empty());
}

TEST_CASE("a replay of the journal is the same to the bit, also of an episode in the middle of a drive") {
  const ScratchFolder folder;
  for (const char* backend : {"mock"}) {
    World::Options options;
    options.backend = backend;
    options.scene = "dynamic_v1";
    options.robots = {"3we_standard_v2", "turtlebot_like"};
    options.image_size = ImageSize{32, 24};
    options.seed = 5;
    options.randomization = "mild";
    World world(options);
    for (std::size_t i = 0; i < 2; ++i) world.robot(i).connect();
    world.settle();
    const auto drive = world.robot(0).start(nav::MoveTo{{2.0, 1.0}, {}, 0.25, 0.1});
    const auto other = world.robot(1).start(nav::MoveForward{1.0, 0.05});
    world.wait(world.sleep(1s));
    Recorder recorder(world, folder.path());
    recorder.start_episode("replay");
    world.wait(drive);
    recorder.end_episode();
    const auto files = journals(folder.path());
    const Journal journal = Journal::open(files.back());
    CHECK(journal.robots().size() == 2);
    const ReplayReport report = replay(journal);
    CHECK(report.ticks == journal.robots()[0].ticks.size());
    CHECK(report.ticks > 50);
    CHECK(report.max_deviation == 0.0);
    CHECK_FALSE(report.first_difference.has_value());
  }
}

TEST_CASE("a journal holds the profile and the place of the map, so that a replay needs no file of the robot") {
  const ScratchFolder folder;
  const auto file = folder.path() / "mine.yaml";
  std::string yaml = load_profile("3we_standard_v2").yaml;
  const std::string mount = "base_from_lidar: [";
  yaml.insert(yaml.find(mount) + mount.size(), "0.01, 0.02, 0.3]  # was [");
  std::ofstream(file) << yaml;
  World::Options options;
  options.robots = {file.string(), "turtlebot_like"};
  options.initial_poses = {{1.0, 2.0, 0.5}};
  options.image_size = ImageSize{32, 24};
  World world(options);
  for (std::size_t i = 0; i < 2; ++i) world.robot(i).connect();
  world.settle();
  {
    Recorder recorder(world, folder.path() / "journals");
    recorder.start_episode("turn");
    world.robot(0).set_velocity({0.1, 0.0, 0.5}, 1s);
    for (int i = 0; i < 40; ++i) world.tick();
    recorder.end_episode();
  }
  for (const bool gone : {false, true}) {
    if (gone) std::filesystem::remove(file);
    const auto journal = Journal::open(journals(folder.path() / "journals")[0]);
    const RecordedRobot& robot = journal.robots()[0];
    CHECK(robot.profile == "mine");
    CHECK(robot.hardware == yaml);
    CHECK(parse_profile(robot.hardware, "mine.yaml").lidar->base_from_lidar == Pose2D{0.01, 0.02, 0.3});
    const Pose2D start = world.truth_service()->truth(0).start_pose();
    REQUIRE(robot.scene_from_map);
    CHECK(distance((*robot.scene_from_map * Pose2D{1.0, 2.0, 0.5}).position(), start.position()) < 1e-12);
    CHECK(journal.robots()[1].scene_from_map == world.truth_service()->truth(1).start_pose());
    const ReplayReport report = replay(journal);
    CHECK(report.ticks == 40);
    CHECK_FALSE(report.first_difference.has_value());
    const JournalHeader header = read_header(journals(folder.path() / "journals")[0]);
    CHECK(header.episode == 0);
    CHECK(header.task == "turn");
    CHECK(header.robots == std::vector<std::string>{"mine", "turtlebot_like"});
  }
}

TEST_CASE("a journal of another format is refused with file and format") {
  const ScratchFolder folder;
  const auto file = folder.path() / "episode_000000.journal";
  const auto part = folder.path() / "episode_000001.part";
  {
    std::ofstream(folder.path() / "episode_000001.journal").flush();  // so that the next one is behind
    const auto world = trials::make_world();
    Recorder recorder(*world, folder.path());
    CHECK(recorder.start_episode("cut off") == 2);
    for (int i = 0; i < 20; ++i) world->tick();
  }
  std::filesystem::remove(folder.path() / "episode_000001.journal");
  std::vector<std::byte> content = {std::byte{1}, std::byte{4}, std::byte{0}, std::byte{0},
                                    std::byte{0},                                             // begin, size
                                    std::byte{1}, std::byte{0}, std::byte{0}, std::byte{0}};  // its format
  BlockCompressor compressor;
  const auto block = compressor.compress(content);
  for (const auto& path : {file, part}) {
    std::ofstream(path, std::ios::binary).write(reinterpret_cast<const char*>(block.data()), std::ssize(block));
  }
  const std::string wrong = ": at byte 0: no 3we journal: its format is 1, this version of 3we reads 2";
  CHECK_THROWS_WITH_AS((void)Journal::open(file), (file.string() + wrong).c_str(), ConfigError);
  CHECK_THROWS_WITH_AS((void)read_header(file), (file.string() + wrong).c_str(), ConfigError);
  CHECK_THROWS_WITH_AS((void)recover(folder.path()), (part.string() + wrong).c_str(), ConfigError);
  CHECK(std::filesystem::exists(part));
  CHECK(Journal::open(folder.path() / "episode_000002.journal").task() == "cut off");
}

TEST_CASE("what cannot be recorded is refused, and loses nothing") {
  const ScratchFolder folder;
  const auto world = trials::make_world();
  CHECK_THROWS_AS(Recorder(*world, folder.path(), {.robots = {1}}), ContractError);
  CHECK_THROWS_AS(Recorder(*world, folder.path(), {.sensors = {"nose"}}), ConfigError);
  std::ofstream(folder.path() / "file").flush();
  CHECK_THROWS_AS(Recorder(*world, folder.path() / "file"), RecordingError);
  Recorder recorder(*world, folder.path(), {.sensors = {"imu"}});
  CHECK_THROWS_AS(Recorder(*world, folder.path()), RecordingError);
  CHECK_THROWS_AS((void)recover(folder.path()), RecordingError);
  CHECK_THROWS_AS(recorder.start_episode("t", {{"x", std::nan("")}}), ContractError);
  CHECK_THROWS_AS(recorder.start_episode("\xff"), ContractError);
  CHECK_THROWS_AS(recorder.record_step(0, std::array{1.0}), ContractError);
  recorder.start_episode("t");
  CHECK_THROWS_AS(recorder.record_step(0, std::array{std::nan("")}), ContractError);
  CHECK_THROWS_AS(recorder.record_step(1, std::array{1.0}), ContractError);
  recorder.record_step(0, std::array{1.0});
  CHECK_THROWS_AS(recorder.record_step(0, std::array{1.0, 2.0}), ContractError);
  CHECK_THROWS_AS(recorder.set_instruction(0, "\xff"), ContractError);
  for (int i = 0; i < 20; ++i) world->tick();
  CHECK(recorder.ticks() == 20);
  std::string warning;
  const auto handler = set_warning_handler([&](std::string_view message) { warning = message; });
  world->reset({});
  for (int i = 0; i < 3; ++i) world->tick();
  CHECK(warning.find("the world began anew") != std::string::npos);
  CHECK_THROWS_WITH_AS(recorder.end_episode(), "the world began anew during an episode: end_episode before reset",
                       RecordingError);
  (void)set_warning_handler(handler);
  CHECK_FALSE(recorder.recording());
  recorder.close();
  CHECK_THROWS_AS(recorder.start_episode("t"), ContractError);
  const auto recovered = recover(folder.path());
  REQUIRE(recovered.size() == 1);
  CHECK(Journal::open(recovered[0].file).recovered());
}

TEST_CASE("damaged journals are refused with file and place") {
  const ScratchFolder folder;
  const auto world = trials::make_world();
  {
    Recorder recorder(*world, folder.path());
    recorder.start_episode("t");
    for (int i = 0; i < 60; ++i) world->tick();
    recorder.end_episode();
  }
  const auto file = journals(folder.path())[0];
  std::ostringstream content;
  content << std::ifstream(file, std::ios::binary).rdbuf();
  const std::string good = content.str();
  std::mt19937_64 draw(7);
  const auto write = [&](const std::string& bytes) { std::ofstream(file, std::ios::binary) << bytes; };
  const std::size_t ticks = Journal::open(file).robots()[0].ticks.size();
  int refused = 0;
  for (int i = 0; i < 300; ++i) {
    std::string bad = good;
    const std::size_t at = draw() % bad.size();
    switch (draw() % 4) {
      case 0: bad.resize(at); break;
      case 1: bad[at] = static_cast<char>(bad[at] ^ (1 << draw() % 8)); break;
      case 2: bad.insert(at, 1, 'x'); break;
      default: bad.append("more"); break;
    }
    write(bad);
    try {
      const Journal journal = Journal::open(file);
      CHECK(journal.task() == "t");  // a bit of Zstandard's own headers that means nothing
      CHECK(journal.robots()[0].ticks.size() == ticks);
    } catch (const ConfigError& error) {
      CHECK(std::string(error.what()).find(file.string()) == 0);
      ++refused;
    }
  }
  CHECK(refused >= 297);
}

TEST_CASE("killed processes lose no finished episode, and less than a second of the current") {
  const auto world = trials::make_world();
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const std::string wrong = trials::kill_trial(*world, seed);
    CHECK_MESSAGE(wrong.empty(), wrong);
  }
}

TEST_CASE("each call that fails once is a clear error, and finished episodes stay readable") {
  const auto world = trials::make_world();
  int calls = 0;
  CHECK(trials::fault_trial(*world, -1, EIO, calls).empty());
  REQUIRE(calls > 20);
  for (int call = 0; call < calls; ++call) {
    for (const int error : {ENOSPC, EIO, 0}) {
      int ignored = 0;
      const std::string wrong = trials::fault_trial(*world, call, error, ignored);
      CHECK_MESSAGE(wrong.empty(), "call ", call, ", error ", error, ": ", wrong);
    }
  }
}

TEST_CASE("after a power cut at any call, what was promised is on the disk") {
  const auto world = trials::make_world();
  int disks = 0;
  const std::string wrong = trials::power_cut_trial(*world, 1, 4, disks);
  CHECK_MESSAGE(wrong.empty(), wrong);
  CHECK(disks > 100);
}
