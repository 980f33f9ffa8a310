// How much an arithmetic-only loop gains from threads, which env_bench.py holds its own gain against.
//
//   spin THREADS SECONDS    loops a second, of all threads together
#include <atomic>
#include <chrono>
#include <cstdio>
#include <string>
#include <thread>
#include <vector>

namespace {

// Multiplications and additions in registers: nothing but the two hardware threads can slow it.
void spin(int threads, double seconds) {
  std::atomic<bool> over = false;
  std::atomic<long> loops = 0;
  std::vector<std::thread> running;
  for (int i = 0; i < threads; ++i) {
    running.emplace_back([&] {
      double values[8] = {1, 2, 3, 4, 5, 6, 7, 8};
      long done = 0;
      for (; !over; ++done) {
        for (int turn = 0; turn < 1000; ++turn) {
          for (double& value : values) value = 0.999 * value + 0.001;
        }
        asm volatile("" ::"r"(values) : "memory");  // or the compiler leaves all of it out
      }
      loops += done;
    });
  }
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
  over = true;
  for (std::thread& thread : running) thread.join();
  std::printf("%.6g\n", static_cast<double>(loops) / seconds);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fputs("usage: spin THREADS SECONDS\n", stderr);
    return 2;
  }
  spin(std::stoi(argv[1]), std::stod(argv[2]));
  return 0;
}
