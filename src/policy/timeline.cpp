#include "policy/timeline.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/bounds.hpp"
#include "core/exact.hpp"
#include "hardware/limits.hpp"
#include "threewe/core/errors.hpp"

namespace threewe::policy {
namespace {

constexpr double kEnsembleDecay = 0.01;  // weight exp(-decay * i) of the i-th oldest chunk, as in ACT's code

Velocity mixed(const Velocity& a, const Velocity& b, double share_of_b) {
  const auto mix = [share_of_b](double x, double y) { return (1.0 - share_of_b) * x + share_of_b * y; };
  return {mix(a.vx, b.vx), mix(a.vy, b.vy), mix(a.omega, b.omega)};
}

double share(Duration of, Duration whole) {
  return static_cast<double>(of.count()) / static_cast<double>(whole.count());
}

}  // namespace

TimelineModel make_timeline_model(const Limits& limits, double rate, std::size_t chunk, Merge merge) {
  if (!is_within(rate, 0.5, 50.0)) throw ContractError(fmt::format("rate must lie in [0.5, 50] Hz, got {}", rate));
  if (chunk < 2 || chunk > 1000) throw ContractError(fmt::format("chunk must lie in [2, 1000] actions, got {}", chunk));
  return {limits, from_seconds(1.0 / rate), chunk, merge};
}

Timeline::Timeline(const TimelineModel& model) : model_(model) {}

void Timeline::add(Time measured, std::span<const Velocity> actions, Time now) {
  if (actions.size() != model_.chunk) {
    throw ContractError(fmt::format("a chunk must have {} actions, got {}", model_.chunk, actions.size()));
  }
  for (std::size_t k = 0; k < actions.size(); ++k) {
    if (!is_finite(actions[k])) throw ContractError(fmt::format("action {} of a chunk is not finite", k));
  }
  if (measured > now) {
    throw ContractError(fmt::format("a chunk was measured at {:.9g} s, which is after now, {:.9g} s",
                                    to_seconds(measured), to_seconds(now)));
  }
  if (!chunks_.empty() && measured <= chunks_.back().measured) {
    throw ContractError(fmt::format("a chunk was measured at {:.9g} s, no later than the one before it, {:.9g} s",
                                    to_seconds(measured), to_seconds(chunks_.back().measured)));
  }
  Chunk chunk{measured, now, {actions.begin(), actions.end()}};
  if (end(chunk) <= now) {
    ++counts_.late;
    return;
  }

  const Velocity before = peek(now);
  if (model_.merge == Merge::replace) chunks_.clear();
  chunks_.push_back(std::move(chunk));
  const Velocity after = peek(now);
  ++counts_.applied;
  if (within_acceleration(model_.limits, before, after) != after) ++counts_.jumps;
}

Velocity Timeline::next(Time now) {
  // the newest chunk stays: what comes after it must be newer
  while (chunks_.size() > 1 && end(chunks_.front()) < now) chunks_.erase(chunks_.begin());
  last_ = peek(now);
  return last_;
}

std::optional<Velocity> Timeline::planned(Time t) const {
  if (chunks_.empty() || end(chunks_.back()) < t) return {};
  return model_.merge == Merge::ensemble ? averaged(t) : blended(t);
}

std::optional<Time> Timeline::end() const {
  if (chunks_.empty()) return {};
  return end(chunks_.back());
}

Time Timeline::end(const Chunk& chunk) const {
  return chunk.measured + static_cast<Duration::rep>(model_.chunk - 1) * model_.period;
}

// The action of time `t`, which the chunk covers.
Velocity Timeline::read(const Chunk& chunk, Time t) const {
  const Duration since = t - chunk.measured;
  const auto k = static_cast<std::size_t>(since / model_.period);
  if (k + 1 >= chunk.actions.size()) return chunk.actions.back();
  return mixed(chunk.actions[k], chunk.actions[k + 1], share(since % model_.period, model_.period));
}

// Each chunk over all before it: once those have ended it alone counts.
Velocity Timeline::blended(Time t) const {
  Velocity v = read(chunks_.front(), std::min(t, end(chunks_.front())));
  for (std::size_t i = 1; i < chunks_.size(); ++i) {
    const Time applied = chunks_[i].applied;
    const Time until = end(chunks_[i - 1]);
    const double weight = t >= until ? 1.0 : share(t - applied, until - applied);
    v = mixed(v, read(chunks_[i], std::min(t, end(chunks_[i]))), weight);
  }
  return v;
}

Velocity Timeline::averaged(Time t) const {
  Velocity sum;
  double weights = 0.0;
  double age = 0.0;
  for (const Chunk& chunk : chunks_) {
    if (end(chunk) < t) continue;
    const double weight = exact::exp(-kEnsembleDecay * age++);
    const Velocity v = read(chunk, t);
    sum = {sum.vx + weight * v.vx, sum.vy + weight * v.vy, sum.omega + weight * v.omega};
    weights += weight;
  }
  return {sum.vx / weights, sum.vy / weights, sum.omega / weights};
}

Velocity Timeline::peek(Time now) const { return planned(now).value_or(within_acceleration(model_.limits, last_, {})); }

}  // namespace threewe::policy
