// Journals of recordings. After a first byte 'f' the file as it is; after another one blocks, each its size and its
// content: behind checksums that are right, what a block holds is read, too.
#include <cstring>

#include "fuzz.hpp"
#include "record/block.hpp"
#include "record/file_system.hpp"
#include "threewe/record/recorder.hpp"

namespace {

using namespace threewe;

class UnsyncedFiles : public record::FileSystem {
 public:
  int sync(int /*file*/) override { return 0; }
};

std::string file_of(std::string_view input) {
  if (input.empty() || input[0] == 'f') return std::string(input.substr(input.empty() ? 0 : 1));
  static record::BlockCompressor compressor;
  std::string file;
  for (std::string_view left = input.substr(1); left.size() > sizeof(std::uint32_t);) {
    std::uint32_t size = 0;
    std::memcpy(&size, left.data(), sizeof(size));
    const std::string_view content = left.substr(sizeof(size), size);
    left.remove_prefix(sizeof(size) + content.size());
    const auto block = compressor.compress(std::as_bytes(std::span(content)));
    file.append(reinterpret_cast<const char*>(block.data()), block.size());
  }
  return file;
}

void read_all(const std::filesystem::path& file) {
  const record::Journal journal = record::Journal::open(file);
  if (record::read_header(file).robots.size() != journal.robots().size()) std::abort();
  (void)journal.metadata();
  for (const record::RecordedRobot& robot : journal.robots()) {
    for (const record::RecordedFrame& frame : robot.frames) {
      (void)journal.color(frame);
      if (frame.depth) (void)journal.depth(frame);
    }
  }
}

}  // namespace

THREEWE_FUZZER(journal)(std::string_view input) {
  static const auto files = std::make_shared<UnsyncedFiles>();
  static const auto finished = fuzz::folder() / "episode_000000.journal";
  static const auto unfinished = fuzz::folder() / "journals" / "episode_000001.part";
  const std::string file = file_of(input);
  fuzz::write(finished, file);
  fuzz::read(input, [] { read_all(finished); });

  std::filesystem::remove_all(unfinished.parent_path());
  std::filesystem::create_directory(unfinished.parent_path());
  fuzz::write(unfinished, file);
  fuzz::read(input, [] {
    for (const record::Recovered& it : record::recover(unfinished.parent_path(), files)) {
      if (!it.file.empty()) read_all(it.file);
    }
  });
}
