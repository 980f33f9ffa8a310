// Episode sequence: which episode comes next.
#pragma once

#include "threewe/env/batch.hpp"

namespace threewe::env {

/// The one after `last` (null before the first), unless something else is asked for; in one of so many scenes, drawn by
/// its seed.
EpisodeInfo next_episode(const EpisodeInfo* last, const Reset& asked, std::size_t scenes);

}  // namespace threewe::env
