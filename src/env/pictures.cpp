#include "env/pictures.hpp"

#include <algorithm>
#include <cstring>

namespace threewe::env {

void Pictures::note(const sim::Model& model, std::span<const sim::RobotState> robots,
                    std::span<const sim::PersonState> people) {
  if (!sim::picture_ready(model.robots[0], robots[0])) return;
  const Time now = robots[0].time();
  // of those that have arrived, only the newest will be looked at
  while (taken_.size() > 1 && taken_[1].arrives <= now) taken_.erase(taken_.begin());
  Taken& taken = taken_.emplace_back();
  taken.arrives = now + model.robots[0].profile.camera->latency;
  for (std::size_t i = 0; i < robots.size(); ++i) taken.shots.push_back(sim::take_shot(robots, people, i));
}

void Pictures::draw(const sim::Model& model, std::size_t robot, const sim::RobotState& state,
                    std::span<std::byte> color, std::span<std::byte> depth, sim::DrawScratch& scratch) {
  const auto later = std::ranges::find_if(taken_, [&](const Taken& taken) { return taken.arrives > state.time(); });
  if (later == taken_.begin()) {
    std::ranges::fill(color, std::byte{});
    std::ranges::fill(depth, std::byte{});
    return;
  }
  const CameraSpec& camera = *model.robots[robot].profile.camera;
  const auto as = []<typename T>(std::span<std::byte> bytes, T*) {
    return std::span(reinterpret_cast<T*>(bytes.data()), bytes.size() / sizeof(T));  // NOLINT: it was made as such
  };
  sim::draw(model, (later - 1)->shots[robot], camera.intrinsics(),
            {as(color, static_cast<std::uint8_t*>(nullptr)), as(depth, static_cast<float*>(nullptr))}, scratch);
}

}  // namespace threewe::env
