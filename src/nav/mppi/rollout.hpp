// The inner part of model predictive path integral control: many samples of a plan are rolled out and priced. Plain
// arrays of float; positions in a window whose origin is the middle of the obstacle field and whose axes are those of
// `odom`.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace threewe::nav::mppi {

inline constexpr std::size_t kSteps = 56;        // of a plan
inline constexpr std::size_t kBlock = 16;        // samples that are rolled out together, on every machine
inline constexpr std::size_t kNoiseRows = 2048;  // of the pool that noise is taken from
inline constexpr std::size_t kPathPoints = 64;
inline constexpr std::size_t kPeople = 8;   // the nearest; the others are far
inline constexpr std::size_t kMeans = 4;    // plans that samples may vary
inline constexpr std::size_t kLook = 2;     // critics of places look at every second step ...
inline constexpr std::size_t kLookFar = 4;  // ... those of the path at every fourth
inline constexpr int kSide = 128;           // [cells] of the obstacle field
inline constexpr int kBins = 8;             // of headings, over half a turn: outlines are boxes

/// Body velocities at the ends of the steps.
struct Plan {
  std::array<float, kSteps> vx{};     ///< [m/s]
  std::array<float, kSteps> vy{};     ///< [m/s]
  std::array<float, kSteps> omega{};  ///< [rad/s]
  friend bool operator==(const Plan&, const Plan&) = default;
};

/// Sixteen samples: a mean plan plus the scaled noise of consecutive rows of the pool.
struct Block {
  std::uint32_t mean = 0;
  std::array<std::uint32_t, 3> row{};  ///< where the noise of vx, vy and omega begins, below kNoiseRows
  std::array<float, 3> scale{};        ///< [m/s], [m/s], [rad/s]
};

/// What the robot can do within a step.
struct Reach {
  float dt = 0.05F;                   ///< [s]
  float linear = 0.0F;                ///< [m/s]
  float backward = 0.0F;              ///< [m/s] of a differential base
  float acceleration = 0.0F;          ///< [m/s] in a step, speeding up
  float braking = 0.0F;               ///< [m/s] in a step, slowing down
  float angular = 0.0F;               ///< [rad/s]
  float angular_acceleration = 0.0F;  ///< [rad/s] in a step
  bool holonomic = false;
};

/// Where and how fast the robot is as the plan begins.
struct Start {
  float x = 0.0F, y = 0.0F;      ///< [m] in the window
  float cos = 1.0F, sin = 0.0F;  ///< of its heading
  float theta = 0.0F;            ///< [rad]
  float vx = 0.0F, vy = 0.0F, omega = 0.0F;
  float progress = 0.0F;  ///< [m] along the path
};

/// For each cell and heading the obstacle that is nearest to the outline, packed.
struct FieldView {
  const std::int32_t* cells = nullptr;  ///< (kBins, kSide, kSide)
  float cells_per_metre = 0.0F;
  float unit = 0.0F;                            ///< [m] of packed coordinates
  float half_length = 0.0F, half_width = 0.0F;  ///< [m] of the outline, a box ...
  float middle_x = 0.0F, middle_y = 0.0F;       ///< [m] ... whose middle lies here in the base frame
  float first_column = 0.0F, last_column = kSide - 1, first_row = 0.0F, last_row = kSide - 1;  ///< that are filled
};
struct ObstacleCritic {
  FieldView field;
  float margin = 0.0F;     ///< [m] nearer than this counts as contact
  float per_reach = 0.0F;  ///< [1/m] one over the distance beyond the margin that is still close
  float contact = 0.0F;    ///< of each look
  float depth = 0.0F;      ///< [1/m] of each look, more where the outline is deeper within the margin
  float close = 0.0F;
  float close_speed = 0.0F;  ///< [s^2/m^2] closeness counts with the square of the speed, of the body ...
  float close_turn = 0.0F;   ///< [s^2/rad^2] ... and of its corners as it turns
};

/// The path ahead, at even spacing, with its direction.
struct PathView {
  const std::int32_t* points = nullptr;      ///< (kPathPoints,), packed
  const std::int32_t* directions = nullptr;  ///< (kPathPoints,), packed, in 1 / 32000
  float unit = 0.0F;                         ///< [m] of packed coordinates
  float per_spacing = 0.0F;                  ///< [1/m]
  float spacing = 0.0F;                      ///< [m]
  float last = 0.0F;                         ///< index of the last point
};
struct PathCritic {
  PathView path;
  float left = 0.0F;    ///< [1/m] of the way that is left
  float beside = 0.0F;  ///< [1/m^2]
};
struct HeadingCritic {
  float along = 0.0F;                        ///< of facing another way than the path
  float aside_cos = 1.0F, aside_sin = 0.0F;  ///< of the angle to face to the left of the path; a half turn backwards
  float sideways = 0.0F;                     ///< [s^2/m^2] of driving sideways ...
  float sideways_free = 0.0F;                ///< [m/s] ... faster than this
  float backward = 0.0F;                     ///< [s^2/m^2] of driving against the way it is to go
  float sign = 1.0F;                         ///< -1 where it is to go backwards
  float turn = 0.0F;                         ///< [1/rad] of what is left of a turn on the spot
  float turn_to = 0.0F;                      ///< [rad], counted from `Start::theta` on, not wrapped
};
struct GoalCritic {
  float x = 0.0F, y = 0.0F;  ///< [m] in the window
  float distance = 0.0F;     ///< [1/m]
  float speed = 0.0F;        ///< [s^2/m^2] at the end of the plan
};
struct SmoothnessCritic {
  float linear = 0.0F;   ///< [s^2/m^2] of each change
  float angular = 0.0F;  ///< [s^2/rad^2]
};
struct PeopleCritic {
  std::array<float, kPeople> x{}, y{}, vx{}, vy{};  ///< [m], [m/s] in the window, as the plan begins
  std::array<float, kPeople> apart{};               ///< [m] from person to base in contact
  std::size_t count = 0;
  float per_reach = 0.0F;  ///< [1/m]
  float contact = 0.0F;
  float close = 0.0F;
};

/// Which ways samples may take.
struct Motion {
  Reach reach;
  Start start;
  std::array<Plan, kMeans> means;
  const float* noise = nullptr;  ///< (kNoiseRows + kSteps, kBlock), standard deviation 1
};

/// One tick's problem.
struct Problem : Motion {
  ObstacleCritic obstacle;
  PathCritic path;
  HeadingCritic heading;
  GoalCritic goal;
  SmoothnessCritic smoothness;
  PeopleCritic people;
  /// The control cost of the information-theoretic update, one over the variance of the noise.
  std::array<float, 3> per_variance{};
};

/// Costs of `blocks.size() * kBlock` samples.
void roll_out(const Problem& problem, std::span<const Block> blocks, std::span<float> costs);

/// Turns costs into weights, exp(-(cost - least) / temperature), and averages the samples' plans by them: the update
/// of Williams et al. 2018 ("Information-Theoretic Model Predictive Control: Theory and Applications to Autonomous
/// Driving", IEEE T-RO 34(6), algorithm 1), with several means as in Trevisan and Alonso-Mora 2024 ("Biased-MPPI").
Plan average(const Problem& problem, std::span<const Block> blocks, std::span<float> costs, float temperature);

/// A block's samples, step by step: what each asks for, and where that leads.
struct Traces {
  using Values = std::array<float, kSteps * kBlock>;  ///< (kSteps, kBlock)
  Values vx{}, vy{}, omega{};                         ///< [m/s], [m/s], [rad/s]
  Values x{}, y{}, theta{};                           ///< [m] in the window, [rad] counted from `Start::theta` on
};

/// The ways that `roll_out` prices.
void trace(const Motion& motion, const Block& block, Traces& traces);

/// Samples whose cost exceeds the least by so many temperatures count for nothing.
inline constexpr float kNegligible = 16.0F;
/// (3, kSteps, kBlock): what the noise of vx, vy and omega adds to each step.
using NoiseSums = std::array<std::array<float, kSteps * kBlock>, 3>;

/// Two numbers in one, for a single look-up.
inline std::int32_t pack(int a, int b) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(b) << 16 | (static_cast<std::uint32_t>(a) & 0xFFFFU));
}

}  // namespace threewe::nav::mppi
