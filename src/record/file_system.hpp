// Calls of the operating system that recordings are written with, so that tests can let each of them fail.
#pragma once

#include <cstddef>
#include <cstdint>

#include <sys/types.h>

namespace threewe::record {

/// As POSIX has them: -1 with errno set where they fail. The base class calls the operating system.
class FileSystem {
 public:
  virtual ~FileSystem() = default;
  virtual int open(const char* path, int flags, unsigned mode);
  virtual ssize_t write(int file, const void* data, std::size_t size);
  virtual int truncate(int file, std::uint64_t size);
  virtual int sync(int file);  ///< fsync
  virtual int close(int file);
  virtual int rename(const char* from, const char* to);
  virtual int unlink(const char* path);
};

}  // namespace threewe::record
