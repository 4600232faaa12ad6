// The operators that a program with FailingNew has.
#include "tests/support/failing_new.h"

#include <cstdlib>
#include <new>

thread_local int weft::testing::FailingNew::left_ = -1;

#if !defined(__SANITIZE_ADDRESS__)
void* operator new(std::size_t size) {
  if (weft::testing::FailingNew::fails()) throw std::bad_alloc();
  if (void* block = std::malloc(size ? size : 1)) return block;
  throw std::bad_alloc();
}
void operator delete(void* block) noexcept { std::free(block); }
void operator delete(void* block, std::size_t) noexcept { std::free(block); }
#endif
