#include "slam/localization_state.hpp"

namespace threewe::slam {

std::string_view to_string(LocalizationState state) {
  switch (state) {
    case LocalizationState::tracking: return "tracking";
    case LocalizationState::doubting: return "doubting";
    case LocalizationState::lost: return "lost";
    case LocalizationState::relocating: return "relocating";
  }
  return "unknown";
}

LocalizationState next_state(LocalizationState state, LocalizationEvent event) {
  using enum LocalizationState;
  const bool knows = state == tracking || state == doubting;
  switch (event) {
    case LocalizationEvent::recognised: return knows ? state : tracking;
    case LocalizationEvent::misfits: return knows ? lost : state;
    case LocalizationEvent::prior_contradicts: return knows ? doubting : state;
    case LocalizationEvent::prior_agrees: return knows ? tracking : state;
    case LocalizationEvent::candidate_found: return knows ? state : relocating;
    case LocalizationEvent::candidate_rejected: return knows ? state : lost;
    case LocalizationEvent::relocalized: return tracking;
  }
  return state;
}

}  // namespace threewe::slam
