// Elements whose features touch come out of every broad phase, and CSAT neither drops them nor masks those features.
#include <algorithm>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <volccd/pipelines/registry.hpp>

#include "conservative/attack_cases.hpp"
#include "conservative/run_cases.hpp"
#include "conservative/vector_targets.hpp"
#include "support/stages.hpp"

namespace volccd::test {
namespace {

/// Makes features with points around them, `count` in each set.
using ElementGenerator = std::function<Case(Choices&, FeatureKind, int control_points, std::size_t count)>;

ElementGenerator nearly_degenerate(Separation separation) {
  return [separation](Choices& choices, FeatureKind kind, int control_points, std::size_t count) {
    return near_degenerate(choices, kind, control_points, count, count, separation);
  };
}

ElementGenerator attacking(std::span<const Attack> attacks) {
  return [attacks](Choices& choices, FeatureKind kind, int control_points, std::size_t count) {
    return any_attack_elements(choices, attacks, kind, control_points, count);
  };
}

/// Two elements of one type without a common vertex.
class TwoElements {
 public:
  explicit TwoElements(ElementType type)
      : n_(static_cast<Index>(vertex_count(type))),
        topology_(make_mesh(type, n_)),
        motions_{Motion(2 * n_, 2), Motion(2 * n_, 3)} {}

  /// A case around features of the elements that are chosen, too.
  Case choose(Choices& choices, FeatureKind kind, int control_points, const ElementGenerator& generator) {
    const Case c = generator(choices, kind, control_points, n_);
    swapped_ = choices.one_in(2);
    for (std::size_t set = 0; set < 2; ++set) {
      const Index o = element(set);
      choose_feature(choices, c.own(set), o, set);
      std::vector<Index> order = features_[set];
      for (const Index v : topology_.mesh().vertices(o))
        if (std::find(order.begin(), order.end(), v) == order.end()) order.push_back(v);
      for (std::size_t i = 0; i < order.size(); ++i)
        for (int k = 0; k < control_points; ++k)
          motion(control_points).set(order[i], k, c.sets[set][i][static_cast<std::size_t>(k)]);
    }
    return c;
  }

  Step step(const Case& c, double t_max) {
    return {topology_, motion(c.control_points), everything_, c.separation, t_max};
  }
  const Topology& topology() const { return topology_; }

  /// Whether the masks of pair (0, 1) name a feature of the contact.
  bool masked(const Case& c, const FeatureMask& mask) const {
    if (c.kind == FeatureKind::ee) return edge_masked(0, mask) || edge_masked(1, mask);
    const auto vertices = topology_.mesh().vertices(element(0));
    const auto at = std::find(vertices.begin(), vertices.end(), features_[0][0]) - vertices.begin();
    return ((element(0) == 0 ? mask.vertices_a : mask.vertices_b) >> at & 1) != 0;
  }

 private:
  static Mesh make_mesh(ElementType type, Index n) {
    Mesh mesh;
    mesh.add_vertices(2 * n);
    for (Index o = 0; o < 2; ++o) {
      ElementSpec spec;
      spec.type = type;
      spec.id = o;
      for (Index i = 0; i < n; ++i) spec.vertices.push_back(o * n + i);
      mesh.add_element(spec);
    }
    return mesh;
  }

  Motion& motion(int control_points) { return motions_[static_cast<std::size_t>(control_points - 2)]; }
  Index element(std::size_t set) const { return static_cast<Index>(set) ^ (swapped_ ? 1u : 0u); }

  void choose_feature(Choices& choices, std::size_t vertices, Index o, std::size_t set) {
    const Features& f = topology_.features();
    const auto any = [&](std::span<const Index> from) {
      return from[static_cast<std::size_t>(choices.below(static_cast<int>(from.size())))];
    };
    if (vertices == 1) {
      features_[set] = {any(topology_.mesh().vertices(o))};
    } else if (vertices == 2) {
      const auto& edge = f.edge(any(f.element_edges(o)));
      features_[set].assign(edge.begin(), edge.end());
    } else {
      const auto& triangle = f.triangle(any(f.element_triangles(o)));
      features_[set].assign(triangle.begin(), triangle.end());
    }
  }

  bool edge_masked(std::size_t set, const FeatureMask& mask) const {
    const Features& f = topology_.features();
    const auto edges = f.element_edges(element(set));
    const auto at = std::find(edges.begin(), edges.end(), f.find_edge(features_[set][0], features_[set][1]));
    return ((element(set) == 0 ? mask.edges_a : mask.edges_b) >> (at - edges.begin()) & 1) != 0;
  }

  Index n_;
  Topology topology_;
  Motion motions_[2];
  ObjectFilter everything_;
  bool swapped_ = false;
  std::vector<Index> features_[2];
};

struct NamedCulling {
  std::string name;
  bool pair_only;
  std::unique_ptr<ElementCulling> stage;
};

std::vector<NamedCulling> all_cullings() {
  const Registry registry = Registry::standard();
  std::vector<NamedCulling> all;
  for (const char* axis : {"face", "predetermined", "velocity", "centroid", "optimal"})
    for (const std::string mode : {"features", "pair", "both"}) {
      OptionValues options{{"axis", axis}, {"mode", mode}, {"edges_of_b", mode == "both" ? "true" : "false"}};
      all.push_back(
          {std::string(axis) + " " + mode, mode == "pair", registry.stage<ElementCulling>("csat").make(options)});
    }
  return all;
}

struct NamedBroadPhase {
  std::string name;
  std::unique_ptr<BroadPhase> stage;
};

std::vector<NamedBroadPhase> all_broad_phases() {
  const Registry registry = Registry::standard();
  std::vector<NamedBroadPhase> all;
  for (const auto& descriptor : registry.stages<BroadPhase>()) {
    all.push_back({descriptor.name, descriptor.make({})});
    for (const OptionInfo& option : descriptor.options)
      if (option.name == "k")
        for (const char* k : {"6", "14", "16", "18", "24", "26"})
          all.push_back({descriptor.name + " " + k, descriptor.make({{"k", k}})});
  }
  return all;
}

/// What both properties share: a case, and a part of the step.
class ElementProperty {
 public:
  ElementProperty(ElementType type, Separation separation) : ElementProperty(type, nearly_degenerate(separation)) {}
  ElementProperty(ElementType type, ElementGenerator generator) : scene_(type), generator_(std::move(generator)) {}

  std::string operator()(Choices& choices) {
    const double until = choices.below(64) / 64.0;
    const int which = choices.below(4);
    const FeatureKind kind = choices.below(2) ? FeatureKind::ee : FeatureKind::vf;
    const int control_points = 2 + choices.below(2);
    const Case c = scene_.choose(choices, kind, control_points, generator_);
    const double t_max = which == 2 && c.touch >= 0 ? c.touch : which == 3 ? until : 1;
    const std::string lost = loses(c, scene_.step(c, t_max));
    if (lost.empty() || !touches(c, t_max)) return "";
    return lost + "t_max " + std::to_string(t_max) + "\n" + to_text(c);
  }

 protected:
  ~ElementProperty() = default;

  TwoElements scene_;
  VectorTargets targets_;  ///< one a case, each in turn
  std::size_t cases_ = 0;

 private:
  /// Stages that lose the contact of the case.
  virtual std::string loses(const Case& c, const Step& step) = 0;

  ElementGenerator generator_;
};

constexpr ElementPair kPair[] = {{0, 1}};

class CsatProperty final : public ElementProperty {
 public:
  using ElementProperty::ElementProperty;

 private:
  std::string loses(const Case& c, const Step& step) override {
    std::string lost;
    targets_.with(cases_++, [&](const std::string& target) {
      for (const auto& [name, pair_only, stage] : cullings_) {
        PairBatch batch;
        batch.assign(kPair);
        run_stage(*stage, step, batch);
        if (batch.size() == 0) lost += name + " drops on " + target + ", ";
        if (batch.size() == 1 && scene_.masked(c, batch.masks[0])) lost += name + " masks on " + target + ", ";
      }
    });
    return lost;
  }

  std::vector<NamedCulling> cullings_ = all_cullings();
};

class BroadPhaseProperty final : public ElementProperty {
 public:
  using ElementProperty::ElementProperty;

 private:
  std::string loses(const Case&, const Step& step) override {
    std::string lost;
    targets_.with(cases_++, [&](const std::string& target) {
      for (const auto& [name, stage] : stages_) {
        const auto state = prepared(*stage, step);
        std::size_t pairs = 0;
        stage->run(step, *state, PairRange::nonadjacent, executor_,
                   [&](std::span<const ElementPair> batch, unsigned) { pairs += batch.size(); });
        if (pairs != 1) lost += name + " emits " + std::to_string(pairs) + " on " + target + ", ";
      }
    });
    return lost;
  }

  std::vector<NamedBroadPhase> stages_ = all_broad_phases();
  SerialExecutor executor_;
};

TEST(CsatProperty, TouchingTetrahedraAreKept) {
  CsatProperty property(ElementType::tetrahedron, Separation::none);
  run_shrinking(20114, 1500, property);
  run_seeds(1, 15'000, property);
}
TEST(CsatProperty, HexahedraWithinTheSeparationAreKept) {
  CsatProperty property(ElementType::hexahedron, Separation::some);
  run_shrinking(20115, 1000, property);
  run_seeds(1, 5'000, property);
}
TEST(BroadPhaseProperty, TouchingTetrahedraAreEmitted) {
  BroadPhaseProperty property(ElementType::tetrahedron, Separation::none);
  run_shrinking(20116, 1000, property);
  run_seeds(1, 8'000, property);
}
TEST(BroadPhaseProperty, TetrahedraWithinTheSeparationAreEmitted) {
  BroadPhaseProperty property(ElementType::tetrahedron, Separation::some);
  run_shrinking(20117, 1000, property);
  run_seeds(1, 8'000, property);
}
TEST(CsatProperty, IsTheOnlyElementCullingThatLosesNothing) {
  const Registry registry = Registry::standard();
  for (const auto& descriptor : registry.stages<ElementCulling>())
    EXPECT_TRUE(descriptor.name == "csat" || descriptor.guarantee == Guarantee::approximate) << descriptor.name;
}
TEST(CsatProperty, AttackedElementsAreKept) {
  CsatProperty touching(ElementType::tetrahedron, attacking(touching_attacks()));
  run_seeds(1, 3000, touching);
  CsatProperty within(ElementType::hexahedron, attacking(separation_attacks()));
  run_seeds(1, 1500, within);
}
TEST(BroadPhaseProperty, AttackedElementsAreEmitted) {
  BroadPhaseProperty touching(ElementType::tetrahedron, attacking(touching_attacks()));
  run_seeds(1, 3000, touching);
  BroadPhaseProperty within(ElementType::tetrahedron, attacking(separation_attacks()));
  run_seeds(1, 3000, within);
}
TEST(LongCsatProperty, AttackedElementsAreKept) {
  CsatProperty touching(ElementType::tetrahedron, attacking(touching_attacks()));
  run_seeds(30'000'000, 30'000, touching);
  CsatProperty within(ElementType::hexahedron, attacking(separation_attacks()));
  run_seeds(30'000'000, 10'000, within);
}
TEST(LongBroadPhaseProperty, AttackedElementsAreEmitted) {
  BroadPhaseProperty touching(ElementType::tetrahedron, attacking(touching_attacks()));
  run_seeds(30'000'000, 30'000, touching);
  BroadPhaseProperty within(ElementType::tetrahedron, attacking(separation_attacks()));
  run_seeds(30'000'000, 30'000, within);
}
TEST(LongCsatProperty, TouchingTetrahedraAreKept) {
  CsatProperty property(ElementType::tetrahedron, Separation::none);
  run_seeds(30'000'000, 200'000, property);
}
TEST(LongCsatProperty, TouchingHexahedraAreKept) {
  CsatProperty property(ElementType::hexahedron, Separation::none);
  run_seeds(30'000'000, 40'000, property);
}
TEST(LongCsatProperty, TetrahedraWithinTheSeparationAreKept) {
  CsatProperty property(ElementType::tetrahedron, Separation::some);
  run_seeds(30'000'000, 120'000, property);
}
TEST(LongBroadPhaseProperty, TouchingTetrahedraAreEmitted) {
  BroadPhaseProperty property(ElementType::tetrahedron, Separation::none);
  run_seeds(30'000'000, 100'000, property);
}
TEST(LongBroadPhaseProperty, TetrahedraWithinTheSeparationAreEmitted) {
  BroadPhaseProperty property(ElementType::tetrahedron, Separation::some);
  run_seeds(30'000'000, 100'000, property);
}

}  // namespace
}  // namespace volccd::test
