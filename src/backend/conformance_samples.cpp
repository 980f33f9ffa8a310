// What every sample owes, whatever its sensor: order, stamps, sequence, rate.
#include <cmath>

#include "backend/conformance_bench.hpp"

namespace threewe::backend::conformance {

namespace {

const std::string& name_of(Bench& bench, const Sample& sample) {
  expect(sample.sensor < bench.features().sensors.size(), "a sample of sensor {}, but features() lists {}",
         sample.sensor, bench.features().sensors.size());
  return bench.features().sensors[sample.sensor].name;
}

void every_sensor_delivers(const Context& context) {
  Bench bench = context.connected();
  bench.drive({}, 3s);
  const auto& sensors = bench.features().sensors;
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    if (sensors[i].rate < 0.5) continue;  // slower than this check is long
    expect(!bench.of_sensor(i).empty(), "sensor '{}' delivered nothing within 3 s", sensors[i].name);
  }
}

void samples_hold_their_sensors_data(const Context& context) {
  Bench bench = context.connected();
  bench.drive({}, 1s);
  for (const Sample& sample : bench.samples()) {
    const std::string& name = name_of(bench, sample);
    const SensorType type = bench.features().sensors[sample.sensor].type;
    expect(sample.data.index() == static_cast<std::size_t>(type), "sensor '{}' delivered another kind of data", name);
  }
}

void second_poll_is_empty(const Context& context) {
  Bench bench = context.connected();
  applies_if(bench.features().lockstep, "more may arrive between two polls: the backend is not lockstep");
  bench.drive({}, 200ms);
  for (int i = 0; i < 10; ++i) {
    bench.world().advance_to(bench.now() + kControlPeriod);
    bench.port().poll();
    const std::size_t again = bench.port().poll().size();
    expect(again == 0, "a second poll at the same time delivered {} samples", again);
  }
}

void samples_arrive_in_order(const Context& context) {
  Bench bench = context.connected();
  for (int i = 0; i < 5; ++i) {  // long gaps, so that one poll hands over several samples of each sensor
    bench.world().advance_to(bench.now() + 500ms);
    bench.poll();
  }
  for (std::size_t sensor = 0; sensor < bench.features().sensors.size(); ++sensor) {
    const std::vector<Sample> samples = bench.of_sensor(sensor);
    for (std::size_t i = 1; i < samples.size(); ++i) {
      expect(samples[i].measured > samples[i - 1].measured, "sensor '{}': measured at {} s after {} s",
             bench.features().sensors[sensor].name, to_seconds(samples[i].measured),
             to_seconds(samples[i - 1].measured));
    }
  }
}

void received_is_the_time_of_the_poll(const Context& context) {
  Bench bench = context.connected();
  for (int i = 0; i < 50; ++i) {
    bench.world().advance_to(bench.now() + kControlPeriod);
    bench.forget();
    const Time before = bench.now();
    bench.poll();
    const Time after = bench.now();
    for (const Sample& sample : bench.samples()) {
      expect(sample.received >= before && sample.received <= after, "sensor '{}': received at {} s, polled at {} s",
             name_of(bench, sample), to_seconds(sample.received), to_seconds(after));
    }
  }
}

void measured_before_received(const Context& context) {
  Bench bench = context.connected();
  bench.drive({}, 2s);
  for (const Sample& sample : bench.samples()) {
    expect(sample.measured <= sample.received, "sensor '{}': measured at {} s, received at {} s",
           name_of(bench, sample), to_seconds(sample.measured), to_seconds(sample.received));
  }
}

void samples_are_recent(const Context& context) {
  Bench bench = context.connected();
  bench.drive({}, 2s);
  for (const Sample& sample : bench.samples()) {
    expect(sample.received - sample.measured <= 500ms, "sensor '{}': measured at {} s, received as late as {} s",
           name_of(bench, sample), to_seconds(sample.measured), to_seconds(sample.received));
  }
}

void sequence_counts_from_zero(const Context& context) {
  Bench bench = context.connected();
  bench.drive({}, 2s);
  for (std::size_t sensor = 0; sensor < bench.features().sensors.size(); ++sensor) {
    std::uint64_t next = 0;
    for (const Sample& sample : bench.of_sensor(sensor)) {
      expect(sample.sequence == next, "sensor '{}': sequence number {} where {} was due",
             bench.features().sensors[sensor].name, sample.sequence, next);
      ++next;
    }
  }
}

void rates_are_as_listed(const Context& context) {
  Bench bench = context.connected();
  bench.drive({}, 1s);
  bench.forget();
  bench.drive({}, 4s);
  const auto& sensors = bench.features().sensors;
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    const std::vector<Sample> samples = bench.of_sensor(i);
    if (sensors[i].rate < 1.0) continue;  // too few to tell
    expect(samples.size() >= 2, "sensor '{}' delivered {} samples in 4 s", sensors[i].name, samples.size());
    const double span = to_seconds(samples.back().measured - samples.front().measured);
    const double rate = static_cast<double>(samples.size() - 1) / span;
    expect(std::abs(rate / sensors[i].rate - 1.0) <= 0.1, "sensor '{}' is listed at {} Hz, but delivered at {:.2f} Hz",
           sensors[i].name, sensors[i].rate, rate);
    expect(std::abs(span - 4.0) <= 0.4 + 2.0 / sensors[i].rate, "sensor '{}': the stamps of 4 s span {:.2f} s",
           sensors[i].name, span);
  }
}

constexpr Check kSamplesChecks[] = {
    {"every_sensor_delivers", every_sensor_delivers},
    {"samples_hold_their_sensors_data", samples_hold_their_sensors_data},
    {"second_poll_is_empty", second_poll_is_empty},
    {"samples_arrive_in_order", samples_arrive_in_order},
    {"received_is_the_time_of_the_poll", received_is_the_time_of_the_poll},
    {"measured_before_received", measured_before_received},
    {"samples_are_recent", samples_are_recent},
    {"sequence_counts_from_zero", sequence_counts_from_zero},
    {"rates_are_as_listed", rates_are_as_listed},
};

}  // namespace

std::span<const Check> sample_checks() { return kSamplesChecks; }

}  // namespace threewe::backend::conformance
