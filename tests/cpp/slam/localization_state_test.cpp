#include "slam/localization_state.hpp"

#include <doctest/doctest.h>

#include <array>

namespace threewe::slam {
namespace {

constexpr std::array kStates = {LocalizationState::tracking, LocalizationState::doubting, LocalizationState::lost,
                                LocalizationState::relocating};

TEST_CASE("each transition of the localization state is that of the table") {
  using enum LocalizationState;
  using Row = std::array<LocalizationState, 4>;  // from tracking, doubting, lost, relocating
  const auto after = [](LocalizationEvent event) {
    Row row{};
    for (std::size_t i = 0; i < kStates.size(); ++i) row[i] = next_state(kStates[i], event);
    return row;
  };
  CHECK(after(LocalizationEvent::recognised) == Row{tracking, doubting, tracking, tracking});
  CHECK(after(LocalizationEvent::misfits) == Row{lost, lost, lost, relocating});
  CHECK(after(LocalizationEvent::prior_contradicts) == Row{doubting, doubting, lost, relocating});
  CHECK(after(LocalizationEvent::prior_agrees) == Row{tracking, tracking, lost, relocating});
  CHECK(after(LocalizationEvent::candidate_found) == Row{tracking, doubting, relocating, relocating});
  CHECK(after(LocalizationEvent::candidate_rejected) == Row{tracking, doubting, lost, lost});
  CHECK(after(LocalizationEvent::relocalized) == Row{tracking, tracking, tracking, tracking});
}

TEST_CASE("a state has a name, and says whether the pose is lost") {
  CHECK(to_string(LocalizationState::relocating) == "relocating");
  for (const LocalizationState state : kStates) {
    PoseEstimate estimate;
    estimate.state = state;
    CHECK(estimate.lost() == (state == LocalizationState::lost || state == LocalizationState::relocating));
  }
}

}  // namespace
}  // namespace threewe::slam
