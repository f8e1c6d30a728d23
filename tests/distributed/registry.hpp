// The stages that tests of ranks use.
#pragma once

#include "support/all_stages.hpp"

namespace volccd::distributed {

inline const Registry& registry() {
  static const Registry all = test::all_stages();
  return all;
}

}  // namespace volccd::distributed
