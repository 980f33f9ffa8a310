#include "backend/mock/mock_world.hpp"

#include <utility>

#include "sim/step.hpp"

namespace threewe::backend::mock {
namespace {

/// All that the embedded simulator knows of a world is in the states.
class EmbeddedEngine : public simulated::Engine {
 public:
  explicit EmbeddedEngine(std::shared_ptr<const sim::Model> model) : model_(std::move(model)) {}

  void place(std::span<const sim::RobotState>, std::span<const sim::PersonState>) override {}
  void teleport(std::size_t, const sim::RobotState&) override {}
  void vary(std::size_t, const sim::RobotState&) override {}
  void step(std::span<sim::RobotState> robots, std::span<const Velocity> commands,
            std::span<sim::PersonState> people) override {
    sim::step(*model_, robots, commands, people);
  }

  std::vector<double> state() const override { return {}; }
  void restore(std::span<const double>, std::span<const sim::RobotState>) override {}

  Picture picture(simulated::WorldCapture capture) const override {
    return Picture([model = model_, state = std::move(capture.state)] { return sim::draw_picture(*model, state); });
  }
  SemanticImage look(const simulated::WorldCapture& capture, const CameraIntrinsics& camera,
                     const sim::CameraPose& view, bool with_itself) const override {
    return sim::draw_truth(*model_, capture.state, camera, view, with_itself);
  }

 private:
  std::shared_ptr<const sim::Model> model_;
};

}  // namespace

MockWorld::MockWorld(const WorldOptions& options)
    : SimulatedWorld(options, "3wemock4", [](std::shared_ptr<const sim::Model> model) {
        return std::make_unique<EmbeddedEngine>(std::move(model));
      }) {}

}  // namespace threewe::backend::mock
