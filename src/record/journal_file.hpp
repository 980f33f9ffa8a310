// Append-only journal file: written under a name of its own, and renamed when it is complete and on the disk.
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "record/block.hpp"
#include "record/file_system.hpp"

namespace threewe::record {

/// The ending of a journal that is being recorded, or was when its process died.
inline constexpr const char* kUnfinished = ".part";
/// The ending of a finished one.
inline constexpr const char* kFinished = ".journal";

/// One journal on its way to the disk. Whatever fails throws RecordingError, and does so again ever after: behind a
/// block that may be torn no other is written.
class JournalFile {
 public:
  /// Makes `stem`.part. Throws where there is one.
  JournalFile(FileSystem& files, const std::filesystem::path& stem);
  /// Takes up one that a crash has cut off, whose first `size` bytes are sound.
  JournalFile(FileSystem& files, const std::filesystem::path& stem, std::uint64_t size);
  /// Leaves what was written as it is.
  ~JournalFile();
  JournalFile(const JournalFile&) = delete;
  JournalFile& operator=(const JournalFile&) = delete;

  /// Appends a block. It outlives the process from here on.
  void append(std::span<const std::byte> content);
  /// What was appended outlives a power cut from here on.
  void sync();
  /// Syncs and gives it its name; so does the folder.
  void finish();
  /// Removes it.
  void discard();

 private:
  JournalFile(FileSystem& files, const std::filesystem::path& stem, int flags, const char* verb);
  void require(bool ok, const char* what);

  FileSystem& files_;
  std::filesystem::path part_, finished_;
  BlockCompressor compressor_;
  std::string failure_;
  int file_ = -1;
};

/// Syncs a folder, so that names in it outlive a power cut. Throws RecordingError.
void sync_folder(FileSystem& files, const std::filesystem::path& folder);

}  // namespace threewe::record
