#include "record/file_system.hpp"

#include <cstdio>

#include <fcntl.h>
#include <unistd.h>

namespace threewe::record {

int FileSystem::open(const char* path, int flags, unsigned mode) { return ::open(path, flags, mode); }
ssize_t FileSystem::write(int file, const void* data, std::size_t size) { return ::write(file, data, size); }
int FileSystem::truncate(int file, std::uint64_t size) { return ::ftruncate(file, static_cast<off_t>(size)); }
int FileSystem::sync(int file) { return ::fsync(file); }
int FileSystem::close(int file) { return ::close(file); }
int FileSystem::rename(const char* from, const char* to) { return ::rename(from, to); }
int FileSystem::unlink(const char* path) { return ::unlink(path); }

}  // namespace threewe::record
