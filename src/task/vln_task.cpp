// VLN in many worlds.
#include <algorithm>
#include <array>
#include <cstring>

#include "task/stop_metrics.hpp"
#include "task/vln.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::task {
namespace {

constexpr double kMostWords = 1e6;  // that a vocabulary has

class VlnTask final : public Task {
 public:
  explicit VlnTask(const TaskContext& context) : period_(context.period), walks_(context.worlds) {
    if (context.robots != 1) throw ConfigError("VLN is a task for one robot");
    for (const auto& scene : context.scenes) scenes_.emplace_back(scene);
  }

  std::vector<Field> fields() const override {
    return {{"instruction_tokens", Field::Type::int32, {language::kMostTokens}, 0.0, kMostWords},
            {"instruction_embedding", Field::Type::float32, {language::kEmbeddingSize}, -1.0, 1.0}};
  }
  bool reads_scan() const override { return false; }
  std::vector<std::string> metrics() const override {
    std::vector<std::string> names = stop_metric_names();
    names.emplace_back("ndtw");
    return names;
  }
  std::string instruction_name() const override { return "instruction"; }
  std::string instruction(std::size_t world) const override { return walks_[world].episode.instruction; }

  void begin(std::size_t world, const EpisodeKey& key, const EpisodeRequest& request,
             std::span<Pose2D> starts) override {
    if (request.start || request.goal || request.category) throw ConfigError("VLN takes no start and no goal");
    Walk& walk = walks_[world];
    const Vln& vln = scenes_[key.scene];
    walk.scene = key.scene;
    walk.episode = vln.sample(key.seed, key.episode);
    walk.state = vln.begin(walk.episode);
    walk.tokens = vln.language().tokens(walk.episode.instruction);
    walk.embedding = language::embedding_of(walk.episode.instruction);
    walk.trip = {};
    starts[0] = walk.episode.start;
  }

  void step(std::size_t world, std::span<const TaskState> robots, std::span<Outcome> outcomes) override {
    Walk& walk = walks_[world];
    const TaskState& now = robots[0];
    const StopTaskStep step =
        scenes_[walk.scene].step(walk.episode, walk.state, now.pose.position(), asked(now), period_);
    walk.trip = {now.distance_driven, now.max_collision_speed, step.terminated, step.success};
    outcomes[0] = {step.reward, step.terminated};
  }

  void observe(std::size_t world, std::size_t /*robot*/, const Belief& /*belief*/,
               std::span<const std::span<std::byte>> fields) override {
    const Walk& walk = walks_[world];
    if (!fields[0].empty()) std::memcpy(fields[0].data(), walk.tokens.data(), sizeof(walk.tokens));
    if (!fields[1].empty()) std::memcpy(fields[1].data(), walk.embedding.data(), sizeof(walk.embedding));
  }

  void measure(std::size_t world, std::span<double> metrics) const override {
    const Walk& walk = walks_[world];
    const auto shared = stop_metrics(walk.trip, walk.episode.geodesic, walk.state.stop.distance);
    std::ranges::copy(shared, metrics.begin());
    metrics[shared.size()] = walk.episode.path.empty() ? 0.0 : ndtw(walk.state.score, walk.episode.path);
  }

 private:
  // One world's episode.
  struct Walk {
    std::size_t scene = 0;
    VlnEpisode episode;
    VlnState state;
    std::array<std::int32_t, language::kMostTokens> tokens{};
    std::array<float, language::kEmbeddingSize> embedding{};
    StopTrip trip;
  };

  Duration period_;
  std::vector<Vln> scenes_;
  std::vector<Walk> walks_;  // by world
};

}  // namespace

std::unique_ptr<Task> make_vln(const TaskContext& context) { return std::make_unique<VlnTask>(context); }

}  // namespace threewe::task
