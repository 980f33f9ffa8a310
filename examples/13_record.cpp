// Record: a drive as a crash-safe journal, replayed to the bit.
#include <cstdlib>
#include <filesystem>
#include <iostream>

#include "threewe/record/recorder.hpp"
#include "threewe/threewe.hpp"

int main() {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "threewe_example_record";
  std::filesystem::remove_all(folder);
  {
    threewe::Robot::Options options;
    options.image_size = threewe::ImageSize{160, 120};
    threewe::Robot robot(options);
    threewe::record::Recorder recorder(robot.world(), folder);
    recorder.start_episode("go to 2.0, 1.0");
    const auto result = robot.wait(robot.move_to(2.0, 1.0));
    recorder.end_episode(result.success);
  }
  for (const auto& file : threewe::record::journals(folder)) {
    const auto journal = threewe::record::Journal::open(file);
    const auto& robot = journal.robots().front();
    std::cout << journal.task() << ": " << robot.ticks.size() << " ticks, " << robot.frames.size() << " images\n";
    const auto report = threewe::record::replay(journal);
    std::cout << "  made anew: " << report.max_deviation << " m apart\n";
    if (report.first_difference) return EXIT_FAILURE;
  }
  std::filesystem::remove_all(folder);
  return EXIT_SUCCESS;
}
