// a * b + c, compiled with the library's flags: once as it is, once for a machine that could fuse it.
double CONTRACT_FLAG_KERNEL(double a, double b, double c) { return a * b + c; }
