// Scenes and the registry, as the tests of pipelines share them.
#pragma once

#include <volccd/oracle/cases/colliding_scenes.hpp>
#include <volccd/pipelines/registry.hpp>

namespace volccd::test {

using namespace cases;

inline const Registry& registry() {
  static const Registry standard = Registry::standard();
  return standard;
}

}  // namespace volccd::test
