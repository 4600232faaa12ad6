// By the C library, where it offers that.
#include "meshing/base/freed_memory.h"

#include <cstdlib>

// With a sanitizer's allocator the C library's has nothing, and trimming it ends in an assertion.
#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define WEFT_CAN_TRIM
#include <malloc.h>
#endif

namespace weft::meshing {

void give_back_freed_memory() {
#ifdef WEFT_CAN_TRIM
  malloc_trim(0);
#endif
}

}  // namespace weft::meshing
