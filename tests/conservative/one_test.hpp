// A step of a single elementary test.
#pragma once

#include <optional>
#include <span>

#include <volccd/oracle/cases/near_degenerate.hpp>
#include <volccd/query/test_block.hpp>

namespace volccd::test {

using namespace cases;

/// One tetrahedron: room for one test of either kind.
class OneTest {
 public:
  OneTest() : topology_(tetrahedron()), motions_{Motion(4, 2), Motion(4, 3)} {
    const Features& features = topology_.features();
    vf_ = {0, features.find_triangle(1, 2, 3)};
    ee_ = {features.find_edge(0, 1), features.find_edge(2, 3)};
  }

  void set(const Case& c, double t_max) {
    kind_ = c.kind;
    Motion& motion = motions_[static_cast<std::size_t>(c.control_points - 2)];
    for (std::size_t i = 0; i < 4; ++i)
      for (int k = 0; k < c.control_points; ++k) {
        const Curve& p = i < c.own(0) ? c.sets[0][i] : c.sets[1][i - c.own(0)];
        motion.set(static_cast<Index>(i), k, p[static_cast<std::size_t>(k)]);
      }
    step_.emplace(Step{topology_, motion, everything_, c.separation, t_max});
  }
  const Step& step() const { return *step_; }
  FeatureKind kind() const { return kind_; }
  std::span<const FeaturePair> pairs() const { return {kind_ == FeatureKind::vf ? &vf_ : &ee_, 1}; }
  const TestBlock& block() {
    block_.gather(*step_, kind_, pairs());
    return block_;
  }

 private:
  static Mesh tetrahedron() {
    Mesh mesh;
    mesh.add_vertices(4);
    ElementSpec spec;
    spec.type = ElementType::tetrahedron;
    spec.vertices = {0, 1, 2, 3};
    mesh.add_element(spec);
    return mesh;
  }

  Topology topology_;
  Motion motions_[2];
  ObjectFilter everything_;
  FeatureKind kind_ = FeatureKind::vf;
  FeaturePair vf_, ee_;
  TestBlock block_;
  std::optional<Step> step_;
};

}  // namespace volccd::test
