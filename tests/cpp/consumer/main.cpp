#include <cstdio>
#include <string>

#include "threewe/core/assets.hpp"

/// Succeeds where the assets are those below the folder that is the argument.
int main(int count, char** arguments) {
  const auto scenes = threewe::asset_names("scenes");
  const std::string found = threewe::asset_directories().front().string();
  std::printf("consumer: %zu scenes in %s\n", scenes.size(), found.c_str());
  return count == 2 && found.starts_with(arguments[1]) && !scenes.empty() ? 0 : 1;
}
