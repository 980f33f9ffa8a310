// Warning handler: what deserves a line in the user's log but is no error.
#pragma once

#include <functional>
#include <string>
#include <string_view>

namespace threewe {

/// What is called with each warning, on the thread on which it arises.
using WarningHandler = std::function<void(std::string_view message)>;

/// Replaces where warnings go and returns what was there; an empty handler restores the default, stderr.
WarningHandler set_warning_handler(WarningHandler handler);
/// Hands a message to the handler.
void warn(const std::string& message);

}  // namespace threewe
