#include "scene/episodes.hpp"

#include <array>

#include <fmt/format.h>

#include "core/exact.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::scene {
namespace {

constexpr int kStartTries = 64;  // starts tried with, and as many without, the wish for a detour
constexpr int kGoalTries = 128;  // goals tried for each start

// Counts the samples of one episode, so that no draw is used twice.
class Draws {
 public:
  Draws(std::uint64_t seed, std::uint32_t index) : key_{.seed = seed, .episode = index, .stream = Stream::sampler} {}

  std::uint64_t seed() { return std::uint64_t{bits()[0]} << 32 | bits()[1]; }
  double uniform() { return threewe::uniform(key_, sample_++); }
  Pose2D pose(const SceneTables& tables) { return sample_roomy_pose(tables, key_, sample_++); }

 private:
  std::array<std::uint32_t, 4> bits() { return random_bits(key_, sample_++); }
  RngKey key_;
  std::uint64_t sample_ = 0;
};

}  // namespace

Pose2D sample_roomy_pose(const SceneTables& tables, const RngKey& key, std::uint64_t sample) {
  const GridFrame& frame = tables.passable().frame;
  const auto& cells = tables.roomy();
  const auto choice = static_cast<std::size_t>(uniform(key, sample, 0) * static_cast<double>(cells.size()));
  const Vec2 middle = frame.center(frame.cell(cells[choice]));
  return {middle.x, middle.y, wrap_angle(uniform(key, sample, 1, -exact::kPi, exact::kPi))};
}

Episode sample_episode(const SceneTables& tables, std::uint64_t seed, std::uint32_t index) {
  Draws draws(seed, index);
  Episode episode;
  episode.seed = draws.seed();
  const bool detour = draws.uniform() < kDetourShare;

  for (int start_try = 0; start_try < 2 * kStartTries; ++start_try) {
    episode.start = draws.pose(tables);
    const Vec2 start = episode.start.position();
    const GeodesicField lengths = tables.geodesic_field(start, kLongestEpisode);
    for (int goal_try = 0; goal_try < kGoalTries; ++goal_try) {
      episode.goal = draws.pose(tables).position();
      episode.geodesic = lengths.length_from(episode.goal);
      if (episode.geodesic < kShortestEpisode || episode.geodesic > kLongestEpisode) continue;
      const bool is_detour = episode.geodesic > kDetour * distance(start, episode.goal);
      if (is_detour == detour || start_try >= kStartTries) return episode;
    }
  }
  throw ConfigError(fmt::format("scene '{}' has no two places between {} and {} m apart", tables.scene().name,
                                kShortestEpisode, kLongestEpisode));
}

}  // namespace threewe::scene
