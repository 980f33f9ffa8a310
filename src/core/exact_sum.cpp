#include "core/exact.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/exact_sum.cpp"
#include "core/highway-inl.hpp"
//
#include "core/exact-inl.hpp"

#if HWY_ONCE
namespace threewe::exact {

HWY_EXPORT(sum);

float sum(std::span<const float> values) { return HWY_DYNAMIC_DISPATCH(sum)(values.data(), values.size()); }

}  // namespace threewe::exact
#endif
