#include "record/journal_file.hpp"

#include <cerrno>
#include <cstring>
#include <utility>

#include <fcntl.h>

#include "threewe/core/errors.hpp"

namespace threewe::record {
namespace {

std::filesystem::path with_ending(std::filesystem::path stem, const char* ending) { return stem += ending; }

}  // namespace

JournalFile::JournalFile(FileSystem& files, const std::filesystem::path& stem, int flags, const char* verb)
    : files_(files), part_(with_ending(stem, kUnfinished)), finished_(with_ending(stem, kFinished)) {
  constexpr unsigned kMode = 0666;
  file_ = files_.open(part_.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC | flags, kMode);
  require(file_ >= 0, verb);
}

JournalFile::JournalFile(FileSystem& files, const std::filesystem::path& stem)
    : JournalFile(files, stem, O_CREAT | O_EXCL, "make") {}

JournalFile::JournalFile(FileSystem& files, const std::filesystem::path& stem, std::uint64_t size)
    : JournalFile(files, stem, 0, "open") {
  require(files_.truncate(file_, size) == 0, "truncate");
}

JournalFile::~JournalFile() {
  if (file_ >= 0) files_.close(file_);
}

void JournalFile::append(std::span<const std::byte> content) {
  if (!failure_.empty()) throw RecordingError(failure_);
  std::span<const std::byte> left = compressor_.compress(content);
  while (!left.empty()) {
    const ssize_t written = files_.write(file_, left.data(), left.size());
    if (written < 0 && errno == EINTR) continue;
    if (written == 0) errno = ENOSPC;
    require(written > 0, "write");
    left = left.subspan(static_cast<std::size_t>(written));
  }
}

void JournalFile::sync() {
  if (!failure_.empty()) throw RecordingError(failure_);
  require(files_.sync(file_) == 0, "sync");
}

void JournalFile::finish() {
  sync();
  const int file = std::exchange(file_, -1);
  require(files_.close(file) == 0, "close");
  require(files_.rename(part_.c_str(), finished_.c_str()) == 0, "rename");
  sync_folder(files_, finished_.parent_path());
}

void JournalFile::discard() {
  if (file_ >= 0) files_.close(std::exchange(file_, -1));
  require(files_.unlink(part_.c_str()) == 0, "remove");
}

void JournalFile::require(bool ok, const char* what) {
  if (ok) return;
  failure_ = std::string("cannot ") + what + " " + part_.string() + ": " + std::strerror(errno) +
             "; finished episodes are safe, and `threewe data recover` finishes what there is of this one";
  throw RecordingError(failure_);
}

void sync_folder(FileSystem& files, const std::filesystem::path& folder) {
  const int file = files.open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC, 0);
  const bool synced = file >= 0 && files.sync(file) == 0;
  const int error = errno;
  if (file >= 0) files.close(file);
  if (!synced) throw RecordingError("cannot sync " + folder.string() + ": " + std::strerror(error));
}

}  // namespace threewe::record
