#include "record/folder.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>
#include <string>
#include <system_error>
#include <utility>

#include <dirent.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>

#include "record/journal_file.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::record {
namespace {

constexpr std::string_view kPrefix = "episode_";
constexpr std::size_t kMostDigits = 9;

}  // namespace

std::optional<std::size_t> episode_of(const std::filesystem::path& file, const char* ending) {
  const std::string stem = file.stem().string();
  if (file.extension() != ending || !stem.starts_with(kPrefix)) return {};
  const std::string digits = stem.substr(kPrefix.size());
  const bool number = !digits.empty() && digits.size() <= kMostDigits &&
                      std::ranges::all_of(digits, [](char c) { return c >= '0' && c <= '9'; });
  return number ? std::optional<std::size_t>(std::stoul(digits)) : std::nullopt;
}

// Not by std::filesystem, whose iterator ends the program where memory is short (libstdc++ 12).
std::vector<std::filesystem::path> episodes_in(const std::filesystem::path& folder, const char* ending) {
  std::vector<std::pair<std::size_t, std::filesystem::path>> found;
  const auto close = [](DIR* open) { ::closedir(open); };
  const std::unique_ptr<DIR, decltype(close)> listed(::opendir(folder.c_str()), close);
  if (!listed) throw RecordingError(folder.string() + ": cannot be listed: " + std::strerror(errno));
  while (const dirent* entry = ::readdir(listed.get())) {
    std::filesystem::path path = folder / entry->d_name;
    if (const auto number = episode_of(path, ending)) found.emplace_back(*number, std::move(path));
  }
  std::ranges::sort(found);
  std::vector<std::filesystem::path> files;
  for (auto& [number, path] : found) files.push_back(std::move(path));
  return files;
}

FolderLock::FolderLock(FileSystem& files, std::filesystem::path folder) : files_(files), folder_(std::move(folder)) {
  constexpr unsigned kMode = 0666;
  std::error_code error;
  std::filesystem::create_directories(folder_, error);
  if (error) throw RecordingError(folder_.string() + ": cannot be made: " + error.message());
  const std::filesystem::path lock = folder_ / ".lock";
  file_ = files_.open(lock.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, kMode);
  if (file_ < 0) throw RecordingError(folder_.string() + ": cannot be written: " + std::strerror(errno));
  if (::flock(file_, LOCK_EX | LOCK_NB) == 0) return;
  files_.close(file_);
  throw RecordingError(folder_.string() + ": another recorder writes into it; choose another folder, or end that one");
}

FolderLock::~FolderLock() { files_.close(file_); }

std::size_t FolderLock::next_episode() const {
  std::size_t next = 0;
  for (const char* ending : {kFinished, kUnfinished}) {
    for (const auto& file : episodes_in(folder_, ending))
      next = std::max(next, episode_of(file, ending).value_or(0) + 1);
  }
  return next;
}

std::filesystem::path FolderLock::stem(std::size_t episode) const {
  return folder_ / fmt::format("{}{:06}", kPrefix, episode);
}

}  // namespace threewe::record
