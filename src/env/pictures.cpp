#include "env/pictures.hpp"

#include <algorithm>

#include "sim/step.hpp"

namespace threewe::env {
namespace {

// The newest picture that has arrived; the end of all if none has.
auto newest(std::vector<sim::CapturePose>& shots, const CameraSpec& camera, Time now) {
  const auto later = std::ranges::find_if(shots, [&](const sim::CapturePose& capture) {
    return static_cast<Time::rep>(capture.step) * sim::kStep + sim::varied_latency(camera.latency, capture.variation) >
           now;
  });
  return later == shots.begin() ? shots.end() : later - 1;
}

}  // namespace

void Pictures::note(const sim::Model& model, std::span<const sim::RobotState> robots,
                    std::span<const sim::PersonState> people) {
  if (!sim::picture_ready(model.robots[0], robots[0])) return;
  for (std::size_t i = 0; i < robots.size(); ++i) {
    std::vector<sim::CapturePose>& shots = taken_[i];
    const auto seen = newest(shots, *model.robots[i].profile.camera, robots[i].time());
    if (seen != shots.end()) shots.erase(shots.begin(), seen);
    shots.push_back(sim::capture_pose(robots, people, i));
  }
}

void Pictures::draw(const sim::Model& model, std::size_t robot, const sim::RobotState& state,
                    std::span<std::byte> color, std::span<std::byte> depth, sim::DrawScratch& scratch) {
  const CameraSpec& camera = *model.robots[robot].profile.camera;
  const auto capture = newest(taken_[robot], camera, state.time());
  if (capture == taken_[robot].end()) {
    std::ranges::fill(color, std::byte{});
    std::ranges::fill(depth, std::byte{});
    return;
  }
  const auto as = []<typename T>(std::span<std::byte> bytes, T*) {
    return std::span(reinterpret_cast<T*>(bytes.data()), bytes.size() / sizeof(T));  // NOLINT: it was made as such
  };
  sim::draw(model, *capture, camera.intrinsics(),
            {as(color, static_cast<std::uint8_t*>(nullptr)), as(depth, static_cast<float*>(nullptr))}, scratch);
}

}  // namespace threewe::env
