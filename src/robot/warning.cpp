#include "threewe/robot/warning.hpp"

#include <cstdio>
#include <mutex>
#include <utility>

namespace threewe {
namespace {

std::mutex handler_mutex;
WarningHandler handler;

}  // namespace

WarningHandler set_warning_handler(WarningHandler new_handler) {
  const std::scoped_lock lock(handler_mutex);
  return std::exchange(handler, std::move(new_handler));
}

void warn(const std::string& message) {
  WarningHandler current;
  {
    const std::scoped_lock lock(handler_mutex);
    current = handler;
  }
  if (!current) {
    std::fprintf(stderr, "threewe: warning: %s\n", message.c_str());
    return;
  }
  try {
    current(message);
  } catch (...) {  // NOLINT(bugprone-empty-catch): what goes wrong with a log line must not stop a robot's tick
  }
}

}  // namespace threewe
