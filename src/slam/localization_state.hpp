// Transition function of the localization state machine.
#pragma once

#include <cstdint>

#include "threewe/slam/localizer.hpp"

namespace threewe::slam {

/// What a scan or a search has shown.
enum class LocalizationEvent : std::uint8_t {
  recognised,          ///< a scan fits at the estimated pose, and the search of the whole map found no better one
  misfits,             ///< for some time no scan has fitted at the estimated pose
  prior_contradicts,   ///< for some time scans have fitted the online map and not the prior map
  prior_agrees,        ///< they fit the prior map, too
  candidate_found,     ///< the search of the whole map ended with one pose that fits
  candidate_rejected,  ///< the search goes on: nothing was found, or a later scan does not fit there
  relocalized,         ///< the scans after the search fit at the pose that it found, better than at the estimated one
};

/// The state after an event:
///
///     state       recognised  misfits     prior_      prior_    candidate_  candidate_  relocalized
///                                         contradicts agrees    found       rejected
///     tracking    .           lost        doubting    .         .           .           .
///     doubting    .           lost        .           tracking  .           .           tracking
///     lost        tracking    .           .           .         relocating  .           tracking
///     relocating  tracking    .           .           .         .           lost        tracking
LocalizationState next_state(LocalizationState state, LocalizationEvent event);

}  // namespace threewe::slam
