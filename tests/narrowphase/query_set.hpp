// Single elementary tests from bare coordinates: a mesh of triangles that share nothing, one or two a test.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include <volccd/mesh/step.hpp>
#include <volccd/narrowphase/narrow_phase.hpp>

namespace volccd::test {

/// Points 0..3 at t = 0, then at t = 1. VF: vertex, triangle. EE: edge 1, edge 2.
using Query = std::array<Vec3, 8>;

/// Queries of one kind as a step. Vertex slots of query i ascend in the order of its points, so that test_vertices()
/// gives that order.
class QuerySet {
 public:
  QuerySet(FeatureKind kind, const std::vector<Query>& queries) : kind_(kind) {
    const Index stride = kind == FeatureKind::vf ? 4 : 6;
    std::vector<Vec3> x0, x1;
    Mesh mesh;
    mesh.add_vertices(stride * static_cast<Index>(queries.size()));
    for (std::size_t i = 0; i < queries.size(); ++i) {
      const Index v = stride * static_cast<Index>(i);
      for (std::size_t p = 0; p < stride; ++p) {
        const std::size_t q = p < 4 ? p : p == 4 ? 0 : 2;  // EE: a third corner for each edge's triangle, of no account
        x0.push_back(queries[i][q]);
        x1.push_back(queries[i][q + 4]);
      }
      const auto triangle = [&](Index a, Index b, Index c) {
        ElementSpec spec;
        spec.type = ElementType::triangle;
        spec.vertices = {a, b, c};
        spec.id = mesh.element_slots();
        mesh.add_element(spec);
      };
      if (kind == FeatureKind::vf) {
        triangle(v + 1, v + 2, v + 3);
      } else {
        triangle(v, v + 1, v + 4);
        triangle(v + 2, v + 3, v + 5);
      }
    }
    topology_ = std::make_unique<Topology>(std::move(mesh));
    motion_ = Motion::linear(x0, x1);
    const Features& features = topology_->features();
    for (Index v = 0; v < x0.size(); v += stride)
      pairs_.push_back(kind == FeatureKind::vf
                           ? FeaturePair{v, features.find_triangle(v + 1, v + 2, v + 3)}
                           : FeaturePair{features.find_edge(v, v + 1), features.find_edge(v + 2, v + 3)});
  }

  FeatureKind kind() const { return kind_; }
  const std::vector<FeaturePair>& pairs() const { return pairs_; }
  std::size_t size() const { return pairs_.size(); }
  Step step(double t_max = 1) const { return {*topology_, motion_, filter_, 0, t_max}; }
  /// Number of the query that a contact belongs to.
  std::size_t query_of(const Contact& contact) const {
    return contact.vertices[0] / (kind_ == FeatureKind::vf ? 4u : 6u);
  }

  std::vector<Contact> test(const NarrowPhase& narrow, double t_max = 1, NarrowCounters* counters = nullptr) const {
    std::vector<Contact> contacts;
    NarrowCounters own;
    narrow.test(step(t_max), kind_, pairs_, contacts, counters ? *counters : own);
    return contacts;
  }

 private:
  FeatureKind kind_;
  std::unique_ptr<Topology> topology_;
  Motion motion_;
  ObjectFilter filter_;
  std::vector<FeaturePair> pairs_;
};

}  // namespace volccd::test
