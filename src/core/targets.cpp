#include "core/targets.hpp"

#include <algorithm>
#include <cstdint>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/targets.cpp"
#include "core/highway-inl.hpp"
#include "core/names.hpp"
#include "threewe/core/errors.hpp"

#if HWY_ONCE
namespace threewe {
namespace {

// A lower bit is a faster target.
std::vector<std::string> names_of(std::int64_t targets) {
  std::vector<std::string> names;
  for (; targets != 0; targets &= targets - 1) names.emplace_back(hwy::TargetName(targets & -targets));
  return names;
}

// What the machine can run: `force_target` asks before it forces anything for the first time.
std::int64_t available() {
  static const std::int64_t targets = hwy::SupportedTargets() & HWY_TARGETS;
  return targets;
}

}  // namespace

std::vector<std::string> compiled_targets() { return names_of(HWY_TARGETS); }
std::vector<std::string> available_targets() { return names_of(available()); }
std::string active_target() { return names_of(hwy::SupportedTargets() & HWY_TARGETS).front(); }

void force_target(std::string_view name) {
  std::int64_t forced = 0;
  for (std::int64_t targets = available(); targets != 0; targets &= targets - 1) {
    if (hwy::TargetName(targets & -targets) == name) forced = targets & -targets;
  }
  if (forced == 0 && !name.empty()) throw ConfigError(unknown_name("target", name, available_targets()));
  hwy::SetSupportedTargetsForTest(forced);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

}  // namespace threewe
#endif
