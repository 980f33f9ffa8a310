// Minds that do one thing, so that a test can tell what the runtime does.
#pragma once

#include <functional>
#include <memory>
#include <utility>

#include "threewe/robot/world.hpp"

namespace threewe::test {

/// A navigator that does what a function says at every step.
class ScriptedNavigator final : public nav::Navigator {
 public:
  using Script = std::function<nav::Decision(const nav::Observation&)>;
  explicit ScriptedNavigator(Script script) : script_(std::move(script)) {}
  void start(const nav::Goal&, const nav::Observation&) override {}
  nav::Decision step(const nav::Observation& observation) override { return script_(observation); }
  nav::Progress progress() const override { return {}; }
  void set_zones(const std::vector<map::Zone>&) override {}
  std::span<const Vec2> path() const override { return {}; }
  std::unique_ptr<nav::Navigator> clone() const override { return std::make_unique<ScriptedNavigator>(script_); }

 private:
  Script script_;
};

inline Autonomy scripted(ScriptedNavigator::Script script) {
  Autonomy autonomy;
  autonomy.navigator = [script = std::move(script)](const RobotProfile&) {
    return std::make_unique<ScriptedNavigator>(script);
  };
  return autonomy;
}

/// Drives ahead for ever.
inline Autonomy restless() {
  return scripted([](const nav::Observation&) { return nav::Decision{{0.3, 0.0, 0.0}, nav::Reason::running, ""}; });
}

}  // namespace threewe::test
