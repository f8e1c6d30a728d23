// Scenes and the registry for the tests of pipelines.
#pragma once

#include <volccd/oracle/cases/colliding_scenes.hpp>
#include <volccd/pipelines/registry.hpp>

#include "support/all_stages.hpp"

namespace volccd::test {

using namespace cases;

inline const Registry& registry() {
  static const Registry standard = test::all_stages();
  return standard;
}

}  // namespace volccd::test
