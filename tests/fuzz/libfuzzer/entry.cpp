// libFuzzer's entry point for one target, VOLCCD_FUZZ_TARGET.
#include "fuzz/targets.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  volccd::fuzz::VOLCCD_FUZZ_TARGET({data, size});
  return 0;
}

// Damaged files make HDF5 request very large amounts of memory, which malloc refuses. HDF5 handles that, but then leaks
// blocks of its own.
extern "C" {
const char* __asan_default_options();
const char* __lsan_default_suppressions();
const char* __asan_default_options() { return "allocator_may_return_null=1"; }
const char* __lsan_default_suppressions() { return "leak:libhdf5"; }
}
