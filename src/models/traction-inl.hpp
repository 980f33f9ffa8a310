// One step of the traction model, written once for a number and for a vector of them. What it means stands in
// traction.hpp.
#if defined(THREEWE_MODELS_TRACTION_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef THREEWE_MODELS_TRACTION_INL
#undef THREEWE_MODELS_TRACTION_INL
#else
#define THREEWE_MODELS_TRACTION_INL
#endif

#include "models/drive-inl.hpp"
#include "models/traction.hpp"

HWY_BEFORE_NAMESPACE();
namespace threewe::models::HWY_NAMESPACE {

/// What motors and floor give in one step.
template <class V>
struct GivenOf {
  V response;
  V turn_response;
  V stall_change;
  V friction_change;  ///< the floor's share in it
  V supply;
  WheelsOf<V> shares;
};

template <class V>
struct TractionStepOf {
  VelocityOf<V> body;
  WheelsOf<V> wheels;
};

/// A motion as each wheel rolls for it [m/s]; its turning part as the wheels go round the base [m/s].
template <class V>
HWY_INLINE WheelsOf<V> at_wheels(const DriveOf<V>& drive, V ahead, V left, V around) {
  const V side = drive.sideways * left;
  return {{ahead - side - around, ahead + side + around, drive.sideways * (ahead + side - around),
           drive.sideways * (ahead - side + around)}};
}

/// What pushes of the wheels amount to: the way back.
template <class V>
HWY_INLINE VelocityOf<V> together(const TractionModelOf<V>& traction_model, const WheelsOf<V>& pushes) {
  const auto& [a, b, c, d] = pushes.at;
  return {traction_model.wheel_share * ((a + c) + (b + d)), traction_model.wheel_share * ((b + c) - (a + d)),
          traction_model.wheel_share * ((b + d) - (a + c))};
}

/// As much as each motor gives: the line from stall to no-load speed, of the speed at the step's end.
template <class V>
HWY_INLINE WheelsOf<V> within_motors(const DriveOf<V>& drive, const GivenOf<V>& given, const WheelsOf<V>& rolling,
                                     const WheelsOf<V>& wanted) {
  const V one = lanes::number<V>(1.0);
  const V minus_one = lanes::number<V>(-1.0);
  const V stall = given.stall_change / drive.turns_per_metre;
  const V slope = one / (one + given.stall_change * drive.per_no_load_speed);
  WheelsOf<V> pushes;
  for (int i = 0; i < 4; ++i) {
    const V ratio = rolling.at[i] * drive.turns_per_metre * drive.per_no_load_speed;
    const V forwards = stall * lanes::clamp(slope * (given.supply - ratio), minus_one, one);
    const V backwards = stall * lanes::clamp(slope * (given.supply + ratio), minus_one, one);
    pushes.at[i] = given.shares.at[i] * lanes::clamp(wanted.at[i], minus_one * backwards, forwards);
  }
  return pushes;
}

/// As much as the floor holds of each, when the body gains `ahead` and `left` [m/s] in this step.
template <class V>
HWY_INLINE WheelsOf<V> within_friction(const TractionModelOf<V>& traction_model, V given, V shifted, V ahead, V left,
                                       const WheelsOf<V>& wanted) {
  const V zero = lanes::number<V>(0.0);
  const V one = lanes::number<V>(1.0);
  const V front = traction_model.load - traction_model.pitch * ahead;
  const V rear = traction_model.load - traction_model.rear_pitch * ahead;
  const V side = traction_model.roll * left;
  const V most = one + one;
  const WheelsOf<V> loads{
      {front - side + shifted, front + side - shifted, rear - side - shifted, rear + side + shifted}};
  WheelsOf<V> pushes;
  for (int i = 0; i < 4; ++i) {
    const V limit = given * traction_model.hold * lanes::clamp(loads.at[i], zero, most);
    pushes.at[i] = lanes::clamp(wanted.at[i], zero - limit, limit);
  }
  return pushes;
}

/// The load that moves to wheels 0 and 3 from 1 and 2, where they slip faster: a share of the mean one.
template <class V>
HWY_INLINE V shifted_load(const TractionModelOf<V>& traction_model, const WheelsOf<V>& slips) {
  const V one = lanes::number<V>(1.0);
  const auto fast = [&](V slip) {
    return lanes::smaller(lanes::magnitude(slip) * traction_model.per_shift_speed, one);
  };
  const auto& [a, b, c, d] = slips.at;
  return lanes::number<V>(0.5) * traction_model.shift * ((fast(a) + fast(d)) - (fast(b) + fast(c)));
}

template <class V>
HWY_INLINE TractionStepOf<V> push_body(const DriveOf<V>& drive, const TractionModelOf<V>& traction_model,
                                       const GivenOf<V>& given, V lateral, const VelocityOf<V>& command,
                                       const VelocityOf<V>& body) {
  const V zero = lanes::number<V>(0.0);

  // what the speed loops want of each wheel, and what motors and floor give of it
  const V sideways = traction_model.sideways * lateral;
  const V ahead = traction_model.ahead * command.vx - body.vx;
  const V left = sideways * command.vy - body.vy;
  const V around = drive.turn_arm * (traction_model.turning * command.omega - body.omega);
  const WheelsOf<V> rolling = at_wheels(drive, body.vx, body.vy, drive.turn_arm * body.omega);
  const WheelsOf<V> wanted = within_motors(drive, given, rolling,
                                           at_wheels(drive, given.response * ahead, given.response * left,
                                                     given.turn_response * traction_model.turn_inertia * around));
  const V shifted = shifted_load(traction_model, at_wheels(drive, ahead, left, around));
  const VelocityOf<V> first =
      together(traction_model, within_friction(traction_model, given.friction_change, shifted, zero, zero, wanted));
  const WheelsOf<V> pushes =
      within_friction(traction_model, given.friction_change, shifted, first.vx, first.vy, wanted);

  // the body follows; wheels that do not roll sideways hold it there
  const VelocityOf<V> gained = together(traction_model, pushes);
  const auto rolls_sideways = drive.sideways != zero;
  const V held = given.friction_change * traction_model.load;
  const V braked = lanes::clamp(zero - body.vy, zero - held, held);
  const VelocityOf<V> after{body.vx + gained.vx, body.vy + lanes::where(rolls_sideways, gained.vy, braked),
                            body.omega + gained.omega / (traction_model.turn_inertia * drive.turn_arm)};

  // a wheel that slips is as fast as leaves its motor what the floor takes
  const WheelsOf<V> setpoints = roll_at(drive, command);
  const WheelsOf<V> holding =
      roll_at(drive, {after.vx / traction_model.ahead, after.vy / sideways, after.omega / traction_model.turning});
  const V per_push = drive.turns_per_metre / given.response;
  TractionStepOf<V> pulled{after, {}};
  for (int i = 0; i < 4; ++i) {
    const auto holds = pushes.at[i] == wanted.at[i];
    pulled.wheels.at[i] = lanes::where(holds, holding.at[i], setpoints.at[i] - per_push * pushes.at[i]);
  }
  return pulled;
}

}  // namespace threewe::models::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
