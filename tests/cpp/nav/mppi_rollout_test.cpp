// The vectorised rollouts beside their plain twin, which rolls out one sample at a time: the same bits on every target.
#include "nav/mppi/rollout.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <vector>

#include "core/exact.hpp"
#include "core/rng.hpp"
#include "core/targets.hpp"
#include "draw.hpp"
#include "nav/mppi/noise.hpp"

namespace threewe::nav::mppi {
namespace {

// What the critics say, as one would write it for one robot.
namespace plain {

struct Robot {
  float x, y, cos, sin, theta, vx, vy, omega, speed;
};

float squared(float x) { return x * x; }
float length(float x, float y) { return std::sqrt(x * x + y * y); }
float bounded(float x, float low, float high) { return std::max(low, std::min(x, high)); }
float above_zero(float x) { return std::max(x, 0.0F); }
float first_of(std::int32_t packed, float unit) {
  return static_cast<float>(static_cast<std::int16_t>(packed & 0xFFFF)) * unit;
}
float second_of(std::int32_t packed, float unit) { return static_cast<float>(packed >> 16) * unit; }

float clearance(const FieldView& f, const Robot& r) {
  const float x = r.x + (r.cos * f.middle_x - r.sin * f.middle_y);
  const float y = r.y + (r.sin * f.middle_x + r.cos * f.middle_y);
  const int column =
      static_cast<int>(bounded(std::floor(x * f.cells_per_metre + 64.0F), f.first_column, f.last_column));
  const int row = static_cast<int>(bounded(std::floor(y * f.cells_per_metre + 64.0F), f.first_row, f.last_row));
  const int bin = static_cast<int>(std::floor(r.theta * (kBins / std::numbers::pi_v<float>))) & (kBins - 1);
  const std::int32_t packed = f.cells[(bin * kSide + row) * kSide + column];
  const float dx = first_of(packed, f.unit) - x;
  const float dy = second_of(packed, f.unit) - y;
  const float beyond_x = std::fabs(r.cos * dx + r.sin * dy) - f.half_length;
  const float beyond_y = std::fabs(r.cos * dy - r.sin * dx) - f.half_width;
  return length(above_zero(beyond_x), above_zero(beyond_y)) + std::min(std::max(beyond_x, beyond_y), 0.0F);
}

float obstacle(const ObstacleCritic& c, const Robot& r) {
  const float beyond = clearance(c.field, r) - c.margin;
  const float near = above_zero(1.0F - above_zero(beyond) * c.per_reach);
  const float closeness =
      squared(near) * (c.close + (c.close_speed * squared(r.speed) + c.close_turn * squared(r.omega)));
  return closeness + (beyond < 0.0F ? c.contact + c.depth * -beyond : 0.0F);
}

float direction(const HeadingCritic& c, const Robot& r) {
  return c.sideways * squared(above_zero(std::fabs(r.vy) - c.sideways_free)) +
         c.backward * squared(above_zero(r.vx * -c.sign));
}

float people(const PeopleCritic& c, const Robot& r, float seconds) {
  float cost = 0.0F;
  for (std::size_t i = 0; i < c.count; ++i) {
    const float away = length(r.x - (c.x[i] + seconds * c.vx[i]), r.y - (c.y[i] + seconds * c.vy[i]));
    const float beyond = away - c.apart[i];
    cost = cost + c.close * squared(above_zero(1.0F - above_zero(beyond) * c.per_reach));
    cost = cost + (beyond < 0.0F ? c.contact : 0.0F);
  }
  return cost * r.speed;
}

struct OnPath {
  float x, y, tx, ty, along, beside;
};

OnPath on_path(const PathView& p, float x, float y, float guess) {
  const float index = bounded(std::floor(guess * p.per_spacing + 0.5F), 0.0F, p.last);
  const auto i = static_cast<std::size_t>(index);
  const float tx = first_of(p.directions[i], 1.0F / 32000.0F);
  const float ty = second_of(p.directions[i], 1.0F / 32000.0F);
  const float dx = x - first_of(p.points[i], p.unit);
  const float dy = y - second_of(p.points[i], p.unit);
  return {x, y, tx, ty, index * p.spacing + (dx * tx + dy * ty), dy * tx - dx * ty};
}

void accelerate(const Reach& reach, float vx, float vy, float omega, Robot& r) {
  omega = bounded(omega, -reach.angular, reach.angular);
  r.omega = bounded(omega, r.omega - reach.angular_acceleration, r.omega + reach.angular_acceleration);
  if (reach.holonomic) {
    const float asked = length(vx, vy);
    r.speed = std::min({asked, reach.linear, r.speed + reach.acceleration});
    const float share = r.speed / std::max(asked, 1e-6F);
    r.vx = bounded(share * vx, r.vx - reach.braking, r.vx + reach.braking);
    r.vy = bounded(share * vy, r.vy - reach.braking, r.vy + reach.braking);
    return;
  }
  const float most = std::max(r.vx + reach.acceleration, std::min(r.vx + reach.braking, 0.0F));
  const float least = std::min(r.vx - reach.acceleration, std::max(r.vx - reach.braking, 0.0F));
  r.vx = bounded(bounded(vx, -reach.backward, reach.linear), least, most);
  r.speed = std::fabs(r.vx);
}

void move(float dt, Robot& r) {
  const float turn = r.omega * dt;
  const float c = 1.0F - turn * turn * (0.5F - turn * turn * (1.0F / 24.0F));
  const float s = turn * (1.0F - turn * turn * (1.0F / 6.0F));
  const float cos = r.cos * c - r.sin * s;
  const float sin = r.sin * c + r.cos * s;
  const float mean_cos = 0.5F * dt * (r.cos + cos);
  const float mean_sin = 0.5F * dt * (r.sin + sin);
  r.x = r.x + (mean_cos * r.vx - mean_sin * r.vy);
  r.y = r.y + (mean_sin * r.vx + mean_cos * r.vy);
  r.theta = r.theta + turn;
  r.cos = cos;
  r.sin = sin;
}

float cost_of(const Problem& p, const Block& block, std::size_t lane) {
  const Plan& mean = p.means[block.mean];
  const Start& s = p.start;
  Robot r{s.x, s.y, s.cos, s.sin, s.theta, s.vx, s.vy, s.omega, length(s.vx, s.vy)};
  OnPath at = on_path(p.path.path, r.x, r.y, s.progress);
  float cost = 0.0F;
  for (std::size_t i = 0; i < kSteps; ++i) {
    const auto noise = [&](std::size_t c) { return p.noise[(block.row[c] + i) * kBlock + lane] * block.scale[c]; };
    const float nx = noise(0);
    const float ny = p.reach.holonomic ? noise(1) : 0.0F;
    const float nw = noise(2);
    cost = cost + ((nx * (mean.vx[i] * p.per_variance[0]) + nw * (mean.omega[i] * p.per_variance[2])) +
                   ny * (mean.vy[i] * p.per_variance[1]));
    const Robot before = r;
    accelerate(p.reach, nx + mean.vx[i], ny + mean.vy[i], nw + mean.omega[i], r);
    move(p.reach.dt, r);
    const float change = squared(r.vx - before.vx) + squared(r.vy - before.vy);
    cost = cost + (p.smoothness.linear * change + p.smoothness.angular * squared(r.omega - before.omega));
    if (i % kLook == kLook - 1) {
      cost = cost + obstacle(p.obstacle, r);
      cost = cost + direction(p.heading, r);
      if (p.people.count > 0) cost = cost + people(p.people, r, static_cast<float>(i + 1) * p.reach.dt);
    }
    if (i % kLookFar == kLookFar - 1) {
      const float moved = (r.x - at.x) * at.tx + (r.y - at.y) * at.ty;
      at = on_path(p.path.path, r.x, r.y, at.along + moved);
      const float left = std::fabs(p.path.path.last * p.path.path.spacing - at.along);
      cost = cost + (left * p.path.left + squared(at.beside) * p.path.beside);
      const float ahead = r.cos * at.tx + r.sin * at.ty;
      const float aside = r.sin * at.tx - r.cos * at.ty;
      const float agrees = ahead * p.heading.aside_cos + aside * p.heading.aside_sin;
      cost = cost + (p.heading.along * (1.0F - agrees) + p.heading.turn * std::fabs(p.heading.turn_to - r.theta));
      cost = cost + p.goal.distance * length(r.x - p.goal.x, r.y - p.goal.y);
    }
  }
  return cost + p.goal.speed * squared(r.speed);
}

// What a sample asks for at each step, and where it is after it.
std::array<std::array<float, 6>, kSteps> way_of(const Motion& m, const Block& block, std::size_t lane) {
  const Plan& mean = m.means[block.mean];
  const Start& s = m.start;
  Robot r{s.x, s.y, s.cos, s.sin, s.theta, s.vx, s.vy, s.omega, length(s.vx, s.vy)};
  std::array<std::array<float, 6>, kSteps> way{};
  for (std::size_t i = 0; i < kSteps; ++i) {
    const auto noise = [&](std::size_t c) { return m.noise[(block.row[c] + i) * kBlock + lane] * block.scale[c]; };
    const float vx = noise(0) + mean.vx[i];
    const float vy = m.reach.holonomic ? noise(1) + mean.vy[i] : 0.0F;
    const float omega = noise(2) + mean.omega[i];
    accelerate(m.reach, vx, vy, omega, r);
    move(m.reach.dt, r);
    way[i] = {vx, vy, omega, r.x, r.y, r.theta};
  }
  return way;
}

// The exponential of Cephes, expf.c.
float exponential(float x) {
  const float whole = std::floor(x * std::numbers::log2e_v<float> + 0.5F);
  const float r = x - whole * 0.693359375F - whole * -2.12194440e-4F;  // NOLINT: ln(2) in two parts
  float p = 1.9875691500e-4F;
  for (const float c : {1.3981999507e-3F, 8.3334519073e-3F, 4.1665795894e-2F, 1.6666665459e-1F, 5.0000001201e-1F}) {
    p = p * r + c;
  }
  return (p * (r * r) + r + 1.0F) * std::ldexp(1.0F, static_cast<int>(whole));
}

float sum_of_16(std::array<float, kBlock> v) {
  for (std::size_t half = 8; half > 0; half /= 2) {
    for (std::size_t i = 0; i < half; ++i) v[i] = v[i] + v[i + half];
  }
  return v[0];
}

Plan average(const Problem& p, const std::vector<Block>& blocks, const std::vector<float>& costs, float temperature) {
  const float least = *std::min_element(costs.begin(), costs.end());
  std::vector<std::array<float, kBlock>> weights(blocks.size());
  std::array<float, kMeans> shares{};
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    for (std::size_t lane = 0; lane < kBlock; ++lane) {
      const float excess = (costs[b * kBlock + lane] - least) * (1.0F / temperature);
      weights[b][lane] = excess < kNegligible ? exponential(-excess) : 0.0F;
    }
    shares[blocks[b].mean] = shares[blocks[b].mean] + sum_of_16(weights[b]);
  }
  float total = 0.0F;
  for (const float share : shares) total = total + share;
  const auto component = [&](std::size_t c, auto member, Plan& plan) {
    for (std::size_t i = 0; i < kSteps; ++i) {
      std::array<float, kBlock> sums{};
      for (std::size_t b = 0; b < blocks.size(); ++b) {
        for (std::size_t lane = 0; lane < kBlock; ++lane) {
          const float noise = p.noise[(blocks[b].row[c] + i) * kBlock + lane];
          sums[lane] = sums[lane] + weights[b][lane] * blocks[b].scale[c] * noise;
        }
      }
      float sum = sum_of_16(sums);
      for (std::size_t m = 0; m < kMeans; ++m) sum = sum + shares[m] * (p.means[m].*member)[i];
      (plan.*member)[i] = sum / total;
    }
  };
  Plan plan;
  component(0, &Plan::vx, plan);
  component(1, &Plan::vy, plan);
  component(2, &Plan::omega, plan);
  return plan;
}

}  // namespace plain

class Draw {
 public:
  explicit Draw(std::uint64_t seed) : key_{.seed = seed, .stream = Stream::sampler} {}
  float between(double low, double high) { return static_cast<float>(uniform(key_, count_++, 0, low, high)); }
  int whole(int low, int high) { return static_cast<int>(std::floor(between(low, high + 0.999))); }
  bool chance(double share) { return between(0.0, 1.0) < static_cast<float>(share); }

 private:
  RngKey key_;
  std::uint64_t count_ = 0;
};

// What a problem points to.
struct Tables {
  std::vector<std::int32_t> cells;
  std::array<std::int32_t, kPathPoints> points{};
  std::array<std::int32_t, kPathPoints> directions{};
};

void draw_tables(Draw& draw, Tables& tables) {
  tables.cells.resize(std::size_t{kBins} * kSide * kSide);
  for (auto& cell : tables.cells) cell = pack(draw.whole(-16000, 16000), draw.whole(-16000, 16000));
  float angle = draw.between(-3.0, 3.0);
  double x = draw.between(-3000, 3000);
  double y = draw.between(-3000, 3000);
  for (std::size_t i = 0; i < kPathPoints; ++i) {
    const auto [s, c] = exact::sincos(static_cast<double>(angle));
    tables.points[i] = pack(static_cast<int>(x), static_cast<int>(y));
    tables.directions[i] = pack(static_cast<int>(32000.0 * c), static_cast<int>(32000.0 * s));
    x = std::clamp(x + 250.0 * c, -32000.0, 32000.0);
    y = std::clamp(y + 250.0 * s, -32000.0, 32000.0);
    angle += draw.between(-0.4, 0.4);
  }
}

Plan draw_plan(Draw& draw) {
  Plan plan;
  for (std::size_t i = 0; i < kSteps; ++i) {
    plan.vx[i] = draw.between(-0.6, 0.6);
    plan.vy[i] = draw.between(-0.6, 0.6);
    plan.omega[i] = draw.between(-1.2, 1.2);
  }
  return plan;
}

Problem draw_problem(Draw& draw, const Tables& tables) {
  Problem p;
  const bool holonomic = draw.chance(0.5);
  p.reach = {draw.between(0.02, 0.1), draw.between(0.2, 1.2), draw.between(0.0, 0.5), draw.between(0.01, 0.2),
             draw.between(0.05, 0.5), draw.between(0.5, 3.0), draw.between(0.1, 0.5), holonomic};
  const double heading = draw.between(-3.14, 3.14);
  const auto [s, c] = exact::sincos(heading);
  p.start = {draw.between(-1.0, 1.0),
             draw.between(-1.0, 1.0),
             static_cast<float>(c),
             static_cast<float>(s),
             static_cast<float>(heading),
             draw.between(-0.5, 0.5),
             holonomic ? draw.between(-0.5, 0.5) : 0.0F,
             draw.between(-1.0, 1.0),
             draw.between(0.0, 0.5)};
  for (Plan& mean : p.means) mean = draw_plan(draw);
  p.noise = noise_pool().data();
  const FieldView field{tables.cells.data(),
                        draw.between(20.0, 50.0),
                        1e-4F,
                        draw.between(0.05, 0.2),
                        draw.between(0.05, 0.2),
                        draw.between(-0.05, 0.05),
                        draw.between(-0.05, 0.05),
                        16.0F * static_cast<float>(draw.whole(0, 3)),
                        127.0F,
                        static_cast<float>(draw.whole(0, 30)),
                        static_cast<float>(draw.whole(80, 127))};
  p.obstacle = {field,
                draw.between(0.0, 0.1),
                draw.between(4.0, 10.0),
                draw.between(0.0, 50.0),
                draw.between(0.0, 500.0),
                draw.between(0.0, 1.0),
                draw.between(0.0, 8.0),
                draw.between(0.0, 1.0)};
  const PathView path{tables.points.data(),
                      tables.directions.data(),
                      1e-4F,
                      40.0F,
                      0.025F,
                      static_cast<float>(draw.whole(1, kPathPoints - 1))};
  p.path = {path, draw.between(0.0, 4.0), draw.between(0.0, 4.0)};
  const auto [as, ac] = exact::sincos(static_cast<double>(draw.between(-1.0, 1.0)));
  p.heading = {draw.between(0.0, 1.0),          static_cast<float>(ac), static_cast<float>(as),
               draw.between(0.0, 1.0),          draw.between(0.0, 0.2), draw.between(0.0, 2.0),
               draw.chance(0.5) ? 1.0F : -1.0F, draw.between(0.0, 3.0), draw.between(-7.0, 7.0)};
  p.goal = {draw.between(-1.0, 1.0), draw.between(-1.0, 1.0), draw.between(0.0, 3.0), draw.between(0.0, 3.0)};
  p.smoothness = {draw.between(0.0, 2.0), draw.between(0.0, 1.0)};
  p.people.count = static_cast<std::size_t>(draw.whole(0, kPeople));
  for (std::size_t i = 0; i < p.people.count; ++i) {
    p.people.x[i] = draw.between(-2.0, 2.0), p.people.y[i] = draw.between(-2.0, 2.0);
    p.people.vx[i] = draw.between(-1.0, 1.0), p.people.vy[i] = draw.between(-1.0, 1.0);
    p.people.apart[i] = draw.between(0.2, 0.8);
  }
  p.people.per_reach = draw.between(1.0, 4.0);
  p.people.contact = draw.between(0.0, 30.0);
  p.people.close = draw.between(0.0, 4.0);
  p.per_variance = {draw.between(0.0, 1.0), draw.between(0.0, 1.0), draw.between(0.0, 1.0)};
  return p;
}

TEST_CASE("rollouts and their average are those of the plain twin, to the bit, with any vectors") {
  Tables tables;
  for (std::uint64_t seed = 0; seed < cases(400); ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    if (seed % 100 == 0) draw_tables(draw, tables);
    const Problem problem = draw_problem(draw, tables);
    const std::vector<Block> blocks = draw_blocks(160, 3, {0.2F, 0.2F, 0.6F}, seed, seed);
    std::vector<float> expected;
    for (const Block& block : blocks) {
      for (std::size_t lane = 0; lane < kBlock; ++lane) expected.push_back(plain::cost_of(problem, block, lane));
    }
    const float temperature = draw.between(0.1, 30.0);
    const Plan plan = plain::average(problem, blocks, expected, temperature);
    for (const std::string& target : available_targets()) {
      CAPTURE(target);
      force_target(target);
      std::vector<float> costs(expected.size());
      roll_out(problem, blocks, costs);
      for (std::size_t i = 0; i < costs.size(); ++i) {
        CAPTURE(i);
        REQUIRE(std::bit_cast<std::uint32_t>(costs[i]) == std::bit_cast<std::uint32_t>(expected[i]));
      }
      REQUIRE(average(problem, blocks, costs, temperature) == plan);
    }
    force_target("");
  }
}

TEST_CASE("traces are those of the plain twin, to the bit, with any vectors") {
  Tables tables;
  Draw table_draw(1);
  draw_tables(table_draw, tables);
  for (std::uint64_t seed = 0; seed < cases(400); ++seed) {
    CAPTURE(seed);
    Draw draw(seed);
    const Problem problem = draw_problem(draw, tables);
    const std::vector<Block> blocks = draw_blocks(160, 3, {0.2F, 0.2F, 0.6F}, seed, seed);
    const Block& block = blocks[seed % blocks.size()];
    for (const std::string& target : available_targets()) {
      CAPTURE(target);
      force_target(target);
      Traces traces;
      trace(problem, block, traces);
      for (std::size_t lane = 0; lane < kBlock; ++lane) {
        const auto way = plain::way_of(problem, block, lane);
        for (std::size_t step = 0; step < kSteps; ++step) {
          const std::size_t i = step * kBlock + lane;
          const std::array<float, 6> found = {traces.vx[i], traces.vy[i], traces.omega[i],
                                              traces.x[i],  traces.y[i],  traces.theta[i]};
          REQUIRE(found == way[step]);
        }
      }
    }
    force_target("");
  }
}

TEST_CASE("the noise of a tick has the deviation asked for, and neighbours in time are alike") {
  const std::vector<float>& pool = noise_pool();
  double sum = 0.0;
  double squares = 0.0;
  double products = 0.0;
  const std::size_t count = pool.size() - kBlock;
  for (std::size_t i = 0; i < count; ++i) {
    sum += static_cast<double>(pool[i]);
    squares += static_cast<double>(pool[i]) * static_cast<double>(pool[i]);
    products += static_cast<double>(pool[i]) * static_cast<double>(pool[i + kBlock]);
  }
  const auto n = static_cast<double>(count);
  CHECK(std::fabs(sum / n) < 0.1);
  CHECK(squares / n == doctest::Approx(1.0).epsilon(0.1));
  CHECK(products / squares == doctest::Approx(0.9).epsilon(0.02));

  const auto blocks = draw_blocks(2000, 2, {0.2F, 0.2F, 0.6F}, 1, 7);
  CHECK(blocks.size() * kBlock == 2000);
  CHECK(std::count_if(blocks.begin(), blocks.end(), [](const Block& b) { return b.mean == 0; }) == 110);
  CHECK(draw_blocks(2000, 2, {0.2F, 0.2F, 0.6F}, 1, 8)[3].row != blocks[3].row);
}

}  // namespace
}  // namespace threewe::nav::mppi
