#include <volccd/io/build_facts.hpp>

#include <volccd/core/version.hpp>

#include "volccd_commit.hpp"

namespace volccd {

BuildFacts build_facts() { return {VOLCCD_VERSION_STRING, VOLCCD_COMMIT, VOLCCD_BUILD_TYPE, VOLCCD_FLAGS}; }

}  // namespace volccd
