// Counts what the program allocates with operator new, for `volccd check`.
#pragma once

#include <cstddef>

namespace volccd {

/// Number of allocations of all threads since the first call, which starts the count. The program defines operator new
/// for this purpose, as a weak symbol; if another definition is linked, nothing is counted.
std::size_t allocation_count();

}  // namespace volccd
