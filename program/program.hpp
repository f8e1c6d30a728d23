// The `volccd` program as a function: a program with additional stages has a main() of three lines
// (examples/custom_culling).
#pragma once

#include <volccd/pipelines/registry.hpp>

namespace volccd {

/// Runs the command line on the stages and pipelines of `registry` and on those of 2011 (add_paper2011). Returns the
/// exit code: 0 done, 1 `verify` found a difference, `check` a broken promise or `queries` a missed contact, 2 bad
/// input or configuration (one line on stderr says what), 130 interrupted.
int program(int argc, const char* const* argv, const Registry& registry);

}  // namespace volccd
