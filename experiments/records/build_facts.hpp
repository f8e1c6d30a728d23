// What this build was made from.
#pragma once

namespace volccd {

struct BuildFacts {
  const char* version;
  const char* commit;      ///< `git describe` when it was configured, "unknown" outside a checkout
  const char* build_type;
};

BuildFacts build_facts();

}  // namespace volccd
