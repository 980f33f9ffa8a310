// Folder of journals: their names, and a lock that keeps two recorders out of one folder.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <vector>

#include "record/file_system.hpp"

namespace threewe::record {

/// Which episode a file of a folder is, by its name; empty where it is none with that ending.
std::optional<std::size_t> episode_of(const std::filesystem::path& file, const char* ending);
/// The files of a folder that are episodes with that ending, by their numbers. Throws RecordingError.
std::vector<std::filesystem::path> episodes_in(const std::filesystem::path& folder, const char* ending);

/// A folder that no other recorder writes into while this lives.
class FolderLock {
 public:
  /// Makes the folder where there is none. Throws RecordingError where that fails, or another holds the lock.
  FolderLock(FileSystem& files, std::filesystem::path folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

  const std::filesystem::path& path() const { return folder_; }
  /// One more than the highest number of any episode, finished or not.
  std::size_t next_episode() const;
  /// The path of an episode's files without its ending.
  std::filesystem::path stem(std::size_t episode) const;

 private:
  FileSystem& files_;
  std::filesystem::path folder_;
  int file_ = -1;
};

}  // namespace threewe::record
