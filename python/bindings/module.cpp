// threewe._core: the C++ library as Python sees it.
#include "bindings.hpp"

NB_MODULE(_core, m) {
  m.doc() = "The C++ core of 3we. Use it through `threewe`, which adds what Python can do better.";
  init_errors(m);
  init_core(m);
  init_language(m);
  init_hardware(m);
  init_map(m);
  init_slam(m);
  init_scene(m);
  init_sim(m);
  init_backend(m);
  init_plugin(m);
  init_nav(m);
  init_robot(m);
  init_record(m);
  init_vision(m);
  init_policy(m);
  init_agent(m);
  init_env(m);
  init_benchmark(m);
  init_export(m);
  init_calibration(m);
  init_ros2(m);
}
