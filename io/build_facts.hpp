// Facts about the build: version, commit, compiler options.
#pragma once

namespace volccd {

struct BuildFacts {
  const char* version;
  const char* commit;  ///< with "-dirty" appended if files differed from it; "unknown" outside a checkout
  const char* build_type;
  const char* flags;  ///< compiler flags of the library
};

BuildFacts build_facts();

}  // namespace volccd
