// Counts what the whole test program allocates with operator new.
#pragma once

#include <cstddef>

namespace volccd::test {

std::size_t allocation_count();

}  // namespace volccd::test
