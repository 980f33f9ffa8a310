// Doing the same again: seeds, reset, save and restore.
#include <cmath>

#include "backend/conformance_bench.hpp"

namespace threewe::backend::conformance {

namespace {

bool same_data(const LaserScan& a, const LaserScan& b) {
  return a.angle_min == b.angle_min && a.angle_increment == b.angle_increment && a.time_increment == b.time_increment &&
         a.range_min == b.range_min && a.range_max == b.range_max && a.ranges == b.ranges;
}
bool same_data(const IMUData& a, const IMUData& b) {
  return a.angular_velocity == b.angular_velocity && a.linear_acceleration == b.linear_acceleration;
}
bool same_data(const Odometry& a, const Odometry& b) { return a.pose == b.pose && a.velocity == b.velocity; }
bool same_data(const BatteryState& a, const BatteryState& b) {
  return a.voltage == b.voltage && a.current == b.current && a.charge == b.charge;
}
bool same_data(const RangeData& a, const RangeData& b) {
  return a.field_of_view == b.field_of_view && a.range_min == b.range_min && a.range_max == b.range_max &&
         a.range == b.range;
}
bool same_data(const Picture& a, const Picture& b) { return a.image() == b.image(); }

/// Drawing takes a simulator long: one picture in ten is looked at.
bool is_looked_at(const Sample& sample) {
  return !std::holds_alternative<Picture>(sample.data) || sample.sequence % 10 == 0;
}

bool same(const Sample& a, const Sample& b) {
  if (a.sensor != b.sensor || a.sequence != b.sequence || a.measured != b.measured || a.received != b.received ||
      a.data.index() != b.data.index()) {
    return false;
  }
  if (!is_looked_at(a)) return true;
  return std::visit([&b](const auto& data) { return same_data(data, std::get<std::decay_t<decltype(data)>>(b.data)); },
                    a.data);
}

/// The index of the first difference; the longer one's first extra sample where one merely ends before the other.
std::size_t first_difference(const std::vector<Sample>& a, const std::vector<Sample>& b) {
  std::size_t i = 0;
  while (i < std::min(a.size(), b.size()) && same(a[i], b[i])) ++i;
  return i;
}

void expect_same(Bench& bench, const std::vector<Sample>& a, const std::vector<Sample>& b, const char* runs) {
  const std::size_t i = first_difference(a, b);
  if (i == a.size() && i == b.size()) return;
  const bool both = i < a.size() && i < b.size();
  throw Failure(both ? fmt::format("{} differ first at {} s, in a sample of '{}'", runs, to_seconds(a[i].received),
                                   bench.features().sensors.at(a[i].sensor).name)
                     : fmt::format("{} delivered {} and {} samples", runs, a.size(), b.size()));
}

/// A drive of 3 s that uses every sensor.
std::vector<Sample> drive_around(Bench& bench) {
  bench.forget();
  bench.drive({bench.cruise(), 0.0, 0.0}, 1s);
  bench.drive({0.5 * bench.cruise(), 0.0, bench.turning()}, 1s);
  bench.drive({}, 1s);
  return bench.samples();
}

void the_same_seed_repeats(const Context& context) {
  Bench first = context.connected(7);
  applies_if(first.features().deterministic, "the backend does not claim to be deterministic");
  Bench second = context.connected(7);
  expect_same(first, drive_around(first), drive_around(second), "two worlds with seed 7");
}

void another_seed_differs(const Context& context) {
  Bench first = context.connected(7);
  applies_if(first.features().deterministic, "the backend does not claim to be deterministic");
  applies_if(context.options.noise != NoiseLevel::ideal, "nothing is random without noise");
  Bench second = context.connected(8);
  const std::vector<Sample> a = drive_around(first);
  const std::vector<Sample> b = drive_around(second);
  expect(first_difference(a, b) < std::min(a.size(), b.size()), "worlds with seeds 7 and 8 delivered the same samples");
}

Bench with_reset(const Context& context) {
  Bench bench = context.connected();
  applies_if(bench.features().can_reset, "the backend does not claim that it can be reset");
  return bench;
}

void reset_without_the_claim_is_refused(const Context& context) {
  Bench bench = context.connected();
  applies_if(!bench.features().can_reset, "the backend can be reset");
  expect_throws<ContractError>([&] { bench.world().reset({}); }, "reset() where can_reset is false", "ContractError");
}

void reset_begins_anew(const Context& context) {
  Bench bench = with_reset(context);
  drive_around(bench);
  bench.world().reset({});
  const Duration slack = bench.features().lockstep ? 0s : 1s;
  expect(bench.now() >= 0s && bench.now() <= slack, "after reset() the clock stands at {} s", to_seconds(bench.now()));
  bench.forget();
  bench.drive({}, 500ms);
  const std::vector<Sample> odometry = bench.of(SensorType::odometry);
  expect(!odometry.empty(), "no odometry arrived after reset()");
  expect(odometry.front().sequence == 0, "after reset() odometry begins with sequence number {}",
         odometry.front().sequence);
  const Pose2D pose = bench.odometry().pose;
  expect(norm(pose.position()) < 0.02 && std::abs(pose.theta) < 0.02,
         "after reset() odometry begins at ({:.3f}, {:.3f}, {:.3f})", pose.x, pose.y, pose.theta);
}

void reset_forgets_the_command(const Context& context) {
  Bench bench = with_reset(context);
  bench.drive({bench.cruise(), 0.0, 0.0}, 500ms);
  bench.port().command({bench.cruise(), 0.0, 0.0}, bench.now() + 10s);
  bench.world().reset({});
  bench.forget();
  bench.wait(1s);
  const double moved = norm(bench.odometry().pose.position());
  expect(moved < 0.02, "the command given before reset() moved the robot by {:.3f} m after it", moved);
}

void reset_with_the_same_seed_repeats(const Context& context) {
  Bench bench = with_reset(context);
  applies_if(bench.features().deterministic, "the backend does not claim to be deterministic");
  bench.world().reset({.seed = 7, .poses = {}});
  const std::vector<Sample> first = drive_around(bench);
  bench.world().reset({.seed = 8, .poses = {}});
  drive_around(bench);
  bench.world().reset({.seed = 7, .poses = {}});
  expect_same(bench, first, drive_around(bench), "two episodes with seed 7");
}

void saving_without_the_claim_is_refused(const Context& context) {
  Bench bench = context.connected();
  applies_if(!bench.features().can_save, "the backend can be saved");
  expect_throws<ContractError>([&] { (void)bench.world().save(); }, "save() where can_save is false", "ContractError");
}

Bench with_save(const Context& context) {
  Bench bench = context.connected();
  applies_if(bench.features().can_save, "the backend does not claim that it can be saved");
  return bench;
}

void a_restored_world_has_the_same_future(const Context& context) {
  Bench bench = with_save(context);
  bench.drive({bench.cruise(), 0.0, 0.3 * bench.turning()}, 730ms);  // amid a scan, at speed
  const std::vector<std::byte> state = bench.world().save();
  const Time saved_at = bench.now();
  const std::vector<Sample> future = drive_around(bench);
  bench.world().restore(state);
  expect(bench.now() == saved_at, "restore() set the clock to {} s; it was saved at {} s", to_seconds(bench.now()),
         to_seconds(saved_at));
  expect_same(bench, future, drive_around(bench), "the futures before and after restore()");
}

void saving_changes_nothing(const Context& context) {
  Bench saved = with_save(context);
  applies_if(saved.features().deterministic, "the backend does not claim to be deterministic");
  Bench other = context.connected();
  saved.drive({saved.cruise(), 0.0, 0.0}, 510ms);
  (void)saved.world().save();
  other.drive({other.cruise(), 0.0, 0.0}, 510ms);
  expect_same(saved, drive_around(saved), drive_around(other), "a world that was saved and one that was not");
}

constexpr Check kRepeatChecks[] = {
    {"the_same_seed_repeats", the_same_seed_repeats},
    {"another_seed_differs", another_seed_differs},
    {"reset_without_the_claim_is_refused", reset_without_the_claim_is_refused},
    {"reset_begins_anew", reset_begins_anew},
    {"reset_forgets_the_command", reset_forgets_the_command},
    {"reset_with_the_same_seed_repeats", reset_with_the_same_seed_repeats},
    {"saving_without_the_claim_is_refused", saving_without_the_claim_is_refused},
    {"a_restored_world_has_the_same_future", a_restored_world_has_the_same_future},
    {"saving_changes_nothing", saving_changes_nothing},
};

}  // namespace

std::span<const Check> repeat_checks() { return kRepeatChecks; }

}  // namespace threewe::backend::conformance
