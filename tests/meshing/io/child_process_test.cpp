// Work in another process that crashes, never ends, or says what is wrong.
#include "meshing/io/files/child_process.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>
#include <stdexcept>

namespace weft::meshing::child_process_test {
namespace {

using Handler = void (*)(int);

/// A signal that this process outlives, as a program may have it that uses the library.
class OutlivedSignal {
 public:
  explicit OutlivedSignal(int number)
      : number_(number),
        former_(std::signal(
            number, +[](int) {})) {}
  ~OutlivedSignal() { std::signal(number_, former_); }
  OutlivedSignal(const OutlivedSignal&) = delete;
  OutlivedSignal& operator=(const OutlivedSignal&) = delete;

 private:
  int number_;
  Handler former_;
};

TEST(ChildProcess, TellsTheErrorOfWhatItDid) {
  EXPECT_EQ(issue_of_child([] { return std::string(); }, 0), "");
  EXPECT_EQ(issue_of_child([] { return std::string("no"); }, 0), "no");
  EXPECT_EQ(issue_of_child([]() -> std::string { throw std::runtime_error("thrown"); }, 0), "thrown");
}

TEST(ChildProcess, ThatDoesNotEndIsEndedThoughThisProcessOutlivesAlarms) {
  const OutlivedSignal alarm(SIGALRM);
  const auto issue = issue_of_child(
      []() -> std::string {
        for (;;) ::pause();
      },
      1);
  EXPECT_FALSE(issue.has_value());
}

TEST(ChildProcess, ThatCrashesSaysNothing) {
  const OutlivedSignal crash(SIGSEGV);
  const auto issue = issue_of_child(
      [] {
        ::raise(SIGSEGV);
        return std::string();
      },
      0);
  EXPECT_FALSE(issue.has_value());
}

TEST(ChildProcess, GoesOnWhenTheParentIsInterrupted) {
  const auto issue = issue_of_child(
      [] {
        ::raise(SIGINT);
        ::raise(SIGTERM);
        return std::string();
      },
      0);
  EXPECT_EQ(issue, "");
}

}  // namespace
}  // namespace weft::meshing::child_process_test
