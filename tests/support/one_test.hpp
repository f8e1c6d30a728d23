// A step of a single elementary test.
#pragma once

#include <optional>
#include <span>

#include <volccd/oracle/cases/test_scene.hpp>
#include <volccd/query/test_block.hpp>

namespace volccd::test {

class OneTest {
 public:
  void set(const cases::Case& c, double t_max) {
    kind_ = c.kind;
    scene_.set(0, c);
    step_.emplace(scene_.step(c.control_points, c.separation, t_max));
    pair_ = scene_.pair(kind_, 0);
  }
  const Step& step() const { return *step_; }
  FeatureKind kind() const { return kind_; }
  std::span<const FeaturePair> pairs() const { return {&pair_, 1}; }
  const TestBlock& block() {
    block_.gather(*step_, kind_, pairs());
    return block_;
  }

 private:
  cases::TestScene scene_;
  FeatureKind kind_ = FeatureKind::vf;
  FeaturePair pair_;
  TestBlock block_;
  std::optional<Step> step_;
};

}  // namespace volccd::test
