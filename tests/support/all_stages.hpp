// The registry of the program, without the broad phases of other libraries.
#pragma once

#include <volccd/paper2011/paper2011.hpp>
#include <volccd/pipelines/registry.hpp>

namespace volccd::test {

inline Registry all_stages() {
  Registry registry = Registry::standard();
  add_paper2011(registry);
  return registry;
}

}  // namespace volccd::test
