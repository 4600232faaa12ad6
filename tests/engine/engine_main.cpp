// main() of the engine's tests: alone, ranks are threads; under mpirun, they are the processes.
#include <gtest/gtest.h>

#include "tests/support/mpi_world.h"

int main(int argc, char** argv) {
  weft::engine::Transport* world = weft::testing::mpi_world();
  ::testing::InitGoogleTest(&argc, argv);
  // What fails is printed by every rank, what passes by the first.
  if (world != nullptr && world->rank().value > 0) {
    auto& listeners = ::testing::UnitTest::GetInstance()->listeners();
    class FailuresOnly final : public ::testing::EmptyTestEventListener {
      void OnTestPartResult(const ::testing::TestPartResult& result) override {
        if (result.failed()) {
          std::fprintf(stderr, "rank %d: %s:%d: %s\n", rank, result.file_name(), result.line_number(),
                       result.message());
        }
      }

     public:
      explicit FailuresOnly(int r) : rank(r) {}
      int rank;
    };
    delete listeners.Release(listeners.default_result_printer());
    listeners.Append(new FailuresOnly(world->rank().value));
  }
  const int status = RUN_ALL_TESTS();
  weft::testing::close_mpi_world();
  return status;
}
