#include <cstdio>

#include "threewe/core/assets.hpp"

int main() {
  const auto scenes = threewe::asset_names("scenes");
  std::printf("consumer: %zu scenes\n", scenes.size());
  return scenes.empty() ? 1 : 0;
}
