// Another process of this program.
#pragma once

#include <string>
#include <vector>

namespace volccd {

/// Runs this program with the arguments, which do not contain its name, and waits until it ends. Under an
/// InterruptGuard, an interruption is passed on to it. Returns its exit code; 128 and the signal if one ended it. Throws
/// Error if it cannot be started.
int run_own_process(const std::vector<std::string>& arguments);

}  // namespace volccd
