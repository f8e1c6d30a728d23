// What this build was made from.
#pragma once

namespace volccd {

struct BuildFacts {
  const char* version;
  const char* commit;      ///< what was built, "-dirty" behind it where files differed; "unknown" outside a checkout
  const char* build_type;
  const char* flags;       ///< of the compiler, for all of the library
};

BuildFacts build_facts();

}  // namespace volccd
