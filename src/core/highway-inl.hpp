// Google Highway, set up alike for every kernel. To be included by a kernel's source file after it has defined
// HWY_TARGET_INCLUDE as its own name; included once per target, hence without a guard.
//
// Besides the fast targets of an architecture the plain scalar one is always compiled, so that one process can run
// each in turn and compare bits. The scalable vectors of Arm are left out: no robot computer has them yet.
#define HWY_COMPILE_ALL_ATTAINABLE
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128)

#include <hwy/foreach_target.h>
#include <hwy/highway.h>
