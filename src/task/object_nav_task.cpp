// ObjectNav in many worlds.
#include <algorithm>
#include <array>
#include <cstring>

#include "task/object_nav.hpp"
#include "task/stop_metrics.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::task {
namespace {

class ObjectNavTask final : public Task {
 public:
  ObjectNavTask(const TaskContext& context, const ObjectNavOptions& options)
      : options_(options), period_(context.period), searches_(context.worlds) {
    if (context.robots != 1) throw ConfigError("ObjectNav is a task for one robot");
    for (const auto& scene : context.scenes) scenes_.emplace_back(scene, context.robot);
  }

  std::vector<Field> fields() const override {
    return {{"object_goal", Field::Type::float32, {kObjectGoals.size()}, 0.0, 1.0}};
  }
  bool reads_scan() const override { return false; }
  std::vector<std::string> metrics() const override { return stop_metric_names(); }
  std::string instruction_name() const override { return "object_goal"; }
  std::string instruction(std::size_t world) const override {
    return std::string(kObjectGoals[searches_[world].episode.goal]);
  }

  void begin(std::size_t world, const EpisodeKey& key, const EpisodeRequest& request,
             std::span<Pose2D> starts) override {
    if (request.goal) throw ConfigError("ObjectNav takes no goal but an object_goal");
    if (request.start && !request.category) throw ConfigError("ObjectNav takes a start only with an object_goal");
    Search& search = searches_[world];
    search.scene = key.scene;
    const ObjectNav& scene = scenes_[key.scene];
    const std::string category = request.category.value_or("");
    search.episode = options_.in_sight && !request.start ? scene.sample_in_sight(key.seed, key.episode, category)
                                                         : scene.sample(key.seed, key.episode, category);
    if (request.start) {
      search.episode.start = *request.start;
      search.episode.geodesic = scenes_[key.scene].distance(search.episode.goal, request.start->position());
    }
    search.state = scenes_[key.scene].begin(search.episode);
    search.trip = {};
    starts[0] = search.episode.start;
  }

  void step(std::size_t world, std::span<const TaskState> robots, std::span<Outcome> outcomes) override {
    Search& search = searches_[world];
    const TaskState& now = robots[0];
    const StopTaskStep step =
        scenes_[search.scene].step(search.episode, search.state, now.pose, asked(now), period_, *now.look);
    search.trip = {now.distance_driven, now.max_collision_speed, step.terminated, step.success};
    outcomes[0] = {step.reward, step.terminated};
  }

  void observe(std::size_t world, std::size_t /*robot*/, const Belief& /*belief*/,
               std::span<const std::span<std::byte>> fields) override {
    if (fields[0].empty()) return;
    const auto goal = one_hot(searches_[world].episode.goal);
    std::memcpy(fields[0].data(), goal.data(), sizeof(goal));
  }

  void measure(std::size_t world, std::span<double> metrics) const override {
    const Search& search = searches_[world];
    std::ranges::copy(stop_metrics(search.trip, search.episode.geodesic, search.state.distance), metrics.begin());
  }

 private:
  // One world's episode.
  struct Search {
    std::size_t scene = 0;
    ObjectNavEpisode episode;
    StopTaskState state;
    StopTrip trip;
  };

  ObjectNavOptions options_;
  Duration period_;
  std::vector<ObjectNav> scenes_;
  std::vector<Search> searches_;  // by world
};

}  // namespace

std::unique_ptr<Task> make_object_nav(const TaskContext& context, const ObjectNavOptions& options) {
  return std::make_unique<ObjectNavTask>(context, options);
}

}  // namespace threewe::task
