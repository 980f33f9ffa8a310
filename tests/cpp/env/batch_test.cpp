// Batched environments: the same bits wherever a world stands in a batch, on any number of threads.
#include "threewe/env/batch.hpp"

#include <doctest/doctest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "draw.hpp"
#include "threewe/core/errors.hpp"
#include "threewe/scene/generator.hpp"
#include "threewe/task/tasks.hpp"

namespace threewe::env {
namespace {

using Scenes = std::vector<std::shared_ptr<const scene::Scene>>;

const Scenes& rooms() {
  static const Scenes scenes{std::make_shared<const scene::Scene>(scene::generate(1, {.size = {8.0, 6.0}})),
                             std::make_shared<const scene::Scene>(scene::generate(2, {.size = {8.0, 6.0}}))};
  return scenes;
}

Options navigation(std::size_t worlds, std::size_t robots = 1) {
  Options options;
  options.scenes = rooms();
  options.task = [](const task::TaskContext& context) { return task::make_navigation(context, {.goals = 8}); };
  options.hardware = load_profile("3we_standard_v2");
  options.worlds = worlds;
  options.robots = robots;
  options.max_steps = 25;
  return options;
}

Options exploration(std::size_t worlds, std::size_t robots) {
  Options options = navigation(worlds, robots);
  options.task = [](const task::TaskContext& context) { return task::make_exploration(context); };
  return options;
}

std::vector<Reset> seeded(std::size_t worlds, std::uint64_t first) {
  std::vector<Reset> resets(worlds);
  for (std::size_t i = 0; i < worlds; ++i) resets[i].seed = first + i;
  return resets;
}

// The actions of a seed, whatever batch it is in.
std::vector<float> actions_of(std::uint64_t seed, int step, std::size_t robots) {
  Draw draw(seed * 1000 + static_cast<std::uint64_t>(step / 5));
  std::vector<float> actions;
  for (std::size_t i = 0; i < 3 * robots; ++i) actions.push_back(static_cast<float>(draw(-1.3, 1.3)));
  return actions;
}

// All that can be seen of one world.
std::vector<std::byte> seen_of(const Batch& batch, std::size_t world) {
  std::vector<std::byte> bytes;
  const auto add = [&](const auto& values, std::size_t per_world) {
    const auto part = std::as_bytes(values.subspan(world * per_world, per_world));
    bytes.insert(bytes.end(), part.begin(), part.end());
  };
  const std::size_t robots = batch.options().robots;
  for (const Array& array : batch.observations()) add(std::span<const std::byte>(array.data), robots * array.row_bytes);
  add(batch.rewards(), robots);
  add(batch.terminated(), robots);
  add(batch.truncated(), robots);
  add(batch.metrics(), robots * batch.metric_names().size());
  add(batch.true_poses(), 3 * robots);
  return bytes;
}

using History = std::vector<std::vector<std::byte>>;  // of each step

// What worlds see, by seed, over some steps.
std::vector<History> play(Options options, std::uint64_t first_seed, int steps) {
  const std::size_t worlds = options.worlds;
  Batch batch(std::move(options));
  const std::size_t robots = batch.options().robots;
  batch.reset(seeded(worlds, first_seed));
  std::vector<History> histories(worlds);
  for (int step = 0; step <= steps; ++step) {
    for (std::size_t world = 0; world < worlds; ++world) histories[world].push_back(seen_of(batch, world));
    std::vector<float> actions;
    for (std::size_t world = 0; world < worlds; ++world) {
      const auto mine = actions_of(first_seed + world, step, robots);
      actions.insert(actions.end(), mine.begin(), mine.end());
    }
    batch.step(actions);
  }
  return histories;
}

TEST_CASE("a world is the same alone, anywhere in a batch, on 1, 2 and 4 threads") {
  constexpr int kSteps = 60;
  for (const bool explore : {false, true}) {
    for (const std::size_t robots : {std::size_t{1}, std::size_t{2}}) {
      CAPTURE(explore);
      CAPTURE(robots);
      const auto options = [&](std::size_t worlds, std::size_t threads) {
        Options made = explore ? exploration(worlds, robots) : navigation(worlds, robots);
        made.threads = threads;
        return made;
      };
      constexpr std::size_t kWorlds = 70;
      const auto all = play(options(kWorlds, 1), 100, kSteps);
      CHECK(play(options(kWorlds, 2), 100, kSteps) == all);
      CHECK(play(options(kWorlds, 4), 100, kSteps) == all);
      for (const std::size_t world : {0U, 31U, 32U, 69U}) {
        CAPTURE(world);
        CHECK(play(options(1, 1), 100 + world, kSteps)[0] == all[world]);
      }
      const auto tail = play(options(7, 1), 150, kSteps);
      for (std::size_t i = 0; i < 7; ++i) CHECK(tail[i] == all[50 + i]);
    }
  }
}

TEST_CASE("episodes follow one another, are truncated, and can be had again") {
  Batch batch(navigation(1));
  batch.reset(seeded(1, 3));
  std::vector<std::vector<std::byte>> begins{seen_of(batch, 0)};
  const std::vector<float> still(3);
  for (int episode = 0; episode < 3; ++episode) {
    for (int i = 1; i <= 25; ++i) {
      CHECK(batch.truncated()[0] == 0);
      batch.step(still);
      CHECK(batch.truncated()[0] == (i == 25 ? 1 : 0));
    }
    CHECK(batch.ended()[0] == 1);
    batch.step(still);  // begins the next one
    CHECK(batch.ended()[0] == 0);
    CHECK(batch.rewards()[0] == 0.0);
    CHECK(batch.episode(0).episode == static_cast<std::uint32_t>(episode + 1));
    CHECK(batch.episode(0).steps == 0);
    begins.push_back(seen_of(batch, 0));
  }
  for (std::uint32_t episode = 0; episode < 4; ++episode) {
    CAPTURE(episode);
    Reset again{.seed = 3, .episode = episode};
    batch.reset({&again, 1});
    CHECK(seen_of(batch, 0) == begins[episode]);
  }
}

TEST_CASE("scenes are drawn by the seed, or chosen") {
  Batch batch(navigation(40));
  batch.reset(seeded(40, 0));
  int second = 0;
  for (std::size_t i = 0; i < 40; ++i) second += batch.episode(i).scene == 1 ? 1 : 0;
  CHECK(second > 8);
  CHECK(second < 32);
  std::vector<Reset> resets = seeded(40, 0);
  for (Reset& reset : resets) reset.scene = 1;
  batch.reset(resets);
  for (std::size_t i = 0; i < 40; ++i) CHECK(batch.episode(i).scene == 1);
}

TEST_CASE("an action that is none changes nothing") {
  Batch batch(navigation(2));
  CHECK_THROWS_AS(batch.step(std::vector<float>(6)), ContractError);
  CHECK_THROWS_WITH_AS(batch.reset({}), "reset: environment 0 needs a seed for its first episode", ContractError);
  batch.reset(seeded(2, 0));
  const auto before = seen_of(batch, 1);
  std::vector<float> actions(6, 0.5F);
  actions[4] = std::numeric_limits<float>::quiet_NaN();
  CHECK_THROWS_WITH_AS(batch.step(actions), "actions must be finite, but actions[1, 1] is nan", ContractError);
  CHECK_THROWS_AS(batch.step(std::vector<float>(5)), ContractError);
  CHECK(seen_of(batch, 1) == before);
  CHECK(batch.episode(0).steps == 0);
}

TEST_CASE("a world or a robot that is not there is refused by name") {
  Batch batch(navigation(2, 2));
  CHECK_THROWS_WITH_AS(batch.instruction(0), "instruction() before the first reset()", ContractError);
  batch.reset(seeded(2, 0));
  const char* const no_world = "env: there is no environment 2, only 2";
  CHECK_THROWS_WITH_AS(batch.episode(2), no_world, ContractError);
  CHECK_THROWS_WITH_AS(batch.instruction(2), no_world, ContractError);
  CHECK_THROWS_WITH_AS(batch.top_view(2), no_world, ContractError);
  CHECK_THROWS_WITH_AS(batch.variation(2), no_world, ContractError);
  CHECK_THROWS_WITH_AS(batch.variation(1, 2), "robot: there is no robot 2, only 2", ContractError);
  CHECK_THROWS_AS(batch.episode(std::numeric_limits<std::size_t>::max()), ContractError);
  CHECK_THROWS_AS(batch.reset(seeded(3, 0)), ContractError);
  const bool mask[] = {true};
  CHECK_THROWS_AS(batch.reset({}, mask), ContractError);
  CHECK(batch.variation(1, 1).mass == 1.0);
}

TEST_CASE("a second thread is refused while the first is at work, and spoils nothing") {
  constexpr std::size_t kWorlds = 32;
  Batch batch(navigation(kWorlds));
  Batch alone(navigation(kWorlds));
  batch.reset(seeded(kWorlds, 0));
  alone.reset(seeded(kWorlds, 0));
  const std::vector<float> ahead(3 * kWorlds, 0.5F);
  std::atomic<int> steps = 0;
  std::atomic<int> refused = 0;
  const auto drive = [&] {
    while (refused < 20 || steps < 5) {
      try {
        batch.step(ahead);
        ++steps;
      } catch (const ContractError& error) {
        CHECK(std::string(error.what()).starts_with("step() while another thread"));
        ++refused;
      }
    }
  };
  {
    const std::jthread one(drive);
    const std::jthread other(drive);
  }
  for (int step = 0; step < steps; ++step) alone.step(ahead);
  for (std::size_t world = 0; world < kWorlds; ++world) CHECK(seen_of(batch, world) == seen_of(alone, world));
}

TEST_CASE("a batch with threads is refused in a process forked since, and ends there") {
  Options options = navigation(4);
  options.threads = 2;
  auto batch = std::make_unique<Batch>(options);
  batch->reset(seeded(4, 0));
  const pid_t child = fork();
  if (child == 0) {
    alarm(20);  // what would hang is killed
    bool refused = false;
    try {
      batch->step(std::vector<float>(12));
    } catch (const ContractError& error) {
      refused = std::string(error.what()).find("forked") != std::string::npos;
    }
    batch.reset();
    _exit(refused ? 0 : 1);
  }
  int status = -1;
  REQUIRE(waitpid(child, &status, 0) == child);
  CHECK(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == 0);
  batch->step(std::vector<float>(12));  // here all is as it was
}

TEST_CASE("without autoreset a step after the end is refused, and a mask chooses who begins") {
  Options options = navigation(3);
  options.autoreset = Autoreset::disabled;
  options.max_steps = 2;
  Batch batch(options);
  batch.reset(seeded(3, 0));
  const std::vector<float> still(9);
  batch.step(still);
  batch.step(still);
  CHECK_THROWS_AS(batch.step(still), ContractError);
  const auto before = seen_of(batch, 1);
  const bool mask[] = {true, false, true};
  batch.reset({}, mask);
  CHECK(batch.episode(0).episode == 1);
  CHECK(batch.episode(1).episode == 0);
  CHECK(seen_of(batch, 1) == before);
}

TEST_CASE("the full gate keeps robots off walls that the limits alone let them touch") {
  constexpr std::size_t kRobots = 64;
  const auto robots_that_touch = [](Gate gate) {
    Options options = navigation(kRobots);
    options.gate = gate;
    options.max_steps = 200;
    Batch batch(options);
    batch.reset(seeded(kRobots, 0));
    std::vector<bool> touched(kRobots);
    for (int step = 0; step < 120; ++step) {
      std::vector<float> ahead;
      for (std::size_t i = 0; i < kRobots; ++i) ahead.insert(ahead.end(), {1.0F, 0.0F, 0.1F});
      batch.step(ahead);
      const std::size_t contact = 5;
      for (std::size_t i = 0; i < kRobots; ++i) touched[i] = touched[i] || batch.metrics()[i * 6 + contact] > 0.05;
    }
    return std::ranges::count(touched, true);
  };
  CHECK(robots_that_touch(Gate::full) <= 1);  // two of a thousand that push on and on do, where a scan has holes
  CHECK(robots_that_touch(Gate::limits) > 32);
}

TEST_CASE("seen from above, hits lie where something stands") {
  Options options = navigation(1);
  options.hardware = with_noise(options.hardware, NoiseLevel::ideal);
  options.max_steps = 1000;
  Batch batch(options);
  CHECK_THROWS_AS(batch.top_view(0), ContractError);
  batch.reset(seeded(1, 4));
  const scene::Scene& scene = *options.scenes[batch.episode(0).scene];
  const scene::Slice slice = scene.at_height(options.hardware.lidar->height);
  for (int step = 0; step < 40; ++step) {
    batch.step(std::vector<float>{0.8F, 0.2F, 1.0F});  // a scan is old when it arrives, and turned by 10 degrees since
    const TopView view = batch.top_view(0);
    REQUIRE(view.robots.size() == 1);
    REQUIRE(view.hits[0].size() > 300);
    const Vec2 lidar = (view.robots[0] * options.hardware.lidar->base_from_lidar).position();
    int off = 0;
    for (const Vec2 hit : view.hits[0]) {
      const Vec2 way = hit - lidar;
      if (std::abs(scene::cast_ray(slice, lidar, std::atan2(way.y, way.x), 12.0) - norm(way)) > 0.05) ++off;
    }
    CHECK(off < static_cast<int>(view.hits[0].size()) / 5);  // at edges a hair decides which surface is met
  }
}

TEST_CASE("a scan that nothing reads is not made, and nothing else changes") {
  const auto played = [](bool lidar) {
    Options options = navigation(6);
    options.gate = Gate::limits;
    options.observed = {.lidar = lidar, .pose = false, .velocity = false, .task_fields = {}};
    Batch batch(options);
    batch.reset(seeded(6, 3));
    std::vector<double> seen;
    for (int step = 0; step < 30; ++step) {
      std::vector<float> actions;
      for (std::uint64_t world = 0; world < 6; ++world) {
        const auto mine = actions_of(world, step, 1);
        actions.insert(actions.end(), mine.begin(), mine.end());
      }
      batch.step(actions);
      for (const auto& values : {batch.rewards(), batch.metrics(), batch.true_poses(), batch.scan_ages()})
        seen.insert(seen.end(), values.begin(), values.end());
      std::array<float, 2> goal{};
      for (std::size_t i = 0; i < 6; ++i) {
        Array array = batch.observations().back();
        std::memcpy(goal.data(), array.row(i).data(), sizeof(goal));
        seen.insert(seen.end(), goal.begin(), goal.end());
      }
    }
    CHECK(batch.scan_ages()[0] > 0.0);
    CHECK(batch.top_view(0).hits[0].size() > 100);  // looked for then
    return seen;
  };
  CHECK(played(false) == played(true));
}

TEST_CASE("scans that the gate takes when it needs them change nothing") {
  const auto played = [](std::uint64_t seed, bool at_once) {
    Options options = navigation(12);
    options.gate = Gate::full;
    options.max_steps = 40;
    LidarSpec& lidar = *options.hardware.lidar;
    if (seed % 2 == 0) lidar.turn = 20ms, lidar.points_per_turn = lidar.beams = 64;
    if (seed % 3 == 0) options.hardware = with_noise(options.hardware, NoiseLevel::ideal);
    if (seed % 3 == 1) lidar.dropout = 0.15;  // so that beams side by side are lost
    if (seed % 4 == 0) lidar.rolling = false;
    if (seed % 5 == 0) options.localization = Localization::truth;
    if (at_once) {  // what is drawn again and again must be in force as a scan is taken: here, always the same
      const auto& names = models::knob_names();
      const auto noise = static_cast<std::size_t>(std::ranges::find(names, "lidar_noise") - names.begin());
      options.randomization.interval = {{noise, {.a = 1.0}}};
      options.randomization.shortest_interval = options.randomization.longest_interval = 1s;
    }
    return play(options, seed, 60);
  };
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    CAPTURE(seed);
    CHECK(played(seed, false) == played(seed, true));
  }
}

TEST_CASE("options that don't fit are refused by name") {
  const auto refused = [](auto change) {
    Options options = navigation(1);
    change(options);
    try {
      const Batch batch(options);
    } catch (const ConfigError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  CHECK(refused([](Options& o) { o.lidar_beams = 100; }).find("360, 180, 120, 90, 72, 60") != std::string::npos);
  CHECK(refused([](Options& o) { o.control_period = 30ms; }).find("control_rate") == 0);
  CHECK(refused([](Options& o) { o.max_steps = 0; }).find("max_steps") == 0);
  CHECK(refused([](Options& o) { o.observed.depth = true; }).find("observations") == 0);
  CHECK(refused([](Options& o) { o.hardware = load_profile("3we_base_v2"); }).find("no lidar") != std::string::npos);
  // its gate would wait for scans for ever
  CHECK(refused([](Options& o) {
          o.hardware = load_profile("3we_base_v2");
          o.observed.lidar = false;
          o.gate = Gate::full;
        }).find("gate: '3we_base_v2' detects obstacles by sonar") != std::string::npos);
  CHECK(refused([](Options& o) {
          o = exploration(1, 1);
          o.hardware = load_profile("3we_base_v2");
          o.observed.lidar = false;
          o.gate = Gate::limits;
        }) == "hardware: this task counts what a lidar could see, and '3we_base_v2' has none");
  CHECK(refused([](Options& o) { o.scenes.clear(); }).find("scene") == 0);
  CHECK(refused([](Options& o) { o.worlds = 0; }).find("num_envs") == 0);
  CHECK(refused([](Options& o) { o.worlds = 1'000'000'000'000; }) == "num_envs: 1 to 1000000, got 1000000000000");
  CHECK(refused([](Options& o) {
          o.observed.image = true;
          o.image_height = 8192;
        }) == "image_size: 1 to 2048 pixels each way, got (8192, 64)");
  CHECK(refused([](Options& o) {  // with its gate left out it goes by the limits
          o.hardware = load_profile("3we_base_v2");
          o.observed.lidar = false;
        }) == "accepted");
}

}  // namespace
}  // namespace threewe::env
