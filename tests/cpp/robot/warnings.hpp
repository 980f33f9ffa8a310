// Collects warnings while it lives.
#pragma once

#include <string>
#include <vector>

#include "threewe/robot/warning.hpp"

namespace threewe::test {

class Warnings {
 public:
  Warnings() : before_(set_warning_handler([this](std::string_view message) { messages.emplace_back(message); })) {}
  ~Warnings() { set_warning_handler(before_); }
  Warnings(const Warnings&) = delete;
  Warnings& operator=(const Warnings&) = delete;

  int mentioning(std::string_view text) const {
    int count = 0;
    for (const std::string& message : messages) count += message.find(text) != std::string::npos ? 1 : 0;
    return count;
  }
  std::vector<std::string> messages;

 private:
  WarningHandler before_;
};

}  // namespace threewe::test
