// The main function that every test program shares. Doctest's declarations are precompiled: this adds their bodies.
#define DOCTEST_CONFIG_IMPLEMENT
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include <doctest/doctest.h>

#include <execinfo.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstring>

namespace {

constexpr unsigned kHangs = 600;  // [s] of a test case that will not end by itself
constexpr int kStatus = 124;      // as timeout(1) has it

const char* running = "";  // the test case

void say(const char* text) { [[maybe_unused]] const auto written = ::write(STDERR_FILENO, text, std::strlen(text)); }

[[noreturn]] void end_what_hangs(int /*signal*/) {
  say("\nhangs: ");
  say(running);
  say("\n");
  std::array<void*, 64> stack{};
  backtrace_symbols_fd(stack.data(), backtrace(stack.data(), stack.size()), STDERR_FILENO);
  ::_exit(kStatus);
}

// Names a test case that hangs, with its stack, and ends the program: ctest goes on with the others.
class Watchdog final : public doctest::IReporter {
 public:
  explicit Watchdog(const doctest::ContextOptions& /*options*/) { std::signal(SIGALRM, end_what_hangs); }

  void test_case_start(const doctest::TestCaseData& test) override {
    running = test.m_name;
    ::alarm(kHangs);
  }
  void test_case_end(const doctest::CurrentTestCaseStats& /*stats*/) override { ::alarm(0); }

  void report_query(const doctest::QueryData& /*data*/) override {}
  void test_run_start() override {}
  void test_run_end(const doctest::TestRunStats& /*stats*/) override {}
  void test_case_reenter(const doctest::TestCaseData& /*test*/) override {}
  void test_case_exception(const doctest::TestCaseException& /*exception*/) override {}
  void subcase_start(const doctest::SubcaseSignature& /*subcase*/) override {}
  void subcase_end() override {}
  void log_assert(const doctest::AssertData& /*data*/) override {}
  void log_message(const doctest::MessageData& /*data*/) override {}
  void test_case_skipped(const doctest::TestCaseData& /*test*/) override {}
};

REGISTER_LISTENER("watchdog", 1, Watchdog);

}  // namespace
