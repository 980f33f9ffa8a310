// Vector instruction targets of the kernels. Results do not depend on them; tests prove that by forcing each in turn.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace threewe {

/// The targets that were compiled into the library, fastest first: "AVX3" (AVX-512), "AVX2", "SSE4", "SSSE3", "NEON",
/// "SCALAR".
std::vector<std::string> compiled_targets();
/// Those of them that this machine can run.
std::vector<std::string> available_targets();
/// The one in use.
std::string active_target();

/// Makes all kernels use one available target, or the fastest again when `name` is empty; not while any of them runs.
/// Throws ConfigError naming the nearest right one.
void force_target(std::string_view name);

}  // namespace threewe
