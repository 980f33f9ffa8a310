// A library that says that it is another version of MuJoCo.
extern "C" int mj_version();
extern "C" int mj_version() { return 3003000; }
