// Fails when -ffp-contract=off is missing: a compiler that may fuse then rounds once instead of twice.
#include <doctest/doctest.h>

double multiply_add_plain(double a, double b, double c);
double multiply_add_fusable(double a, double b, double c);

namespace {

// (1 + e)(1 - e) = 1 - e^2 rounds to 1 when the product is rounded by itself, so that only a fused sum keeps -e^2
constexpr double kEpsilon = 0x1p-30;

}  // namespace

TEST_CASE("a product and a sum are rounded each by itself") {
  CHECK(multiply_add_plain(1.0 + kEpsilon, 1.0 - kEpsilon, -1.0) == 0.0);
#if defined(__x86_64__)
  if (!__builtin_cpu_supports("fma")) {
    MESSAGE("not shown: this CPU cannot fuse");
    return;
  }
#endif
  CHECK(multiply_add_fusable(1.0 + kEpsilon, 1.0 - kEpsilon, -1.0) == 0.0);
}
