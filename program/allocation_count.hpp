// Counts what the program allocates with operator new, for `volccd check`.
#pragma once

#include <cstddef>

namespace volccd {

/// Allocations of all threads since the first call, which begins to count. The program has its own operator new for
/// that, as a weak symbol: where another one is linked, nothing is counted.
std::size_t allocation_count();

}  // namespace volccd
