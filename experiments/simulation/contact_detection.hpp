// Contacts of a step by a pipeline of this library, in terms of the simulated mesh.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <volccd/core/executor.hpp>
#include <volccd/culling/csat_filter.hpp>
#include <volccd/culling/feature_kdop_filter.hpp>
#include <volccd/experiments/simulation/archive.hpp>
#include <volccd/experiments/simulation/contact_features.hpp>
#include <volccd/mesh/feature_block.hpp>
#include <volccd/mesh/shells.hpp>
#include <volccd/mesh/topology.hpp>
#include <volccd/narrowphase/inclusion.hpp>
#include <volccd/pipelines/pipeline.hpp>

namespace volccd::simulation {

enum class ContactClass : std::uint8_t {
  inter,    ///< of different objects
  intra,    ///< of one object, no two elements at them adjacent but some that are not
  adjacent  ///< all elements at the one are adjacent to all at the other: in the O-Set of Section 5.1
};

enum class ContactVerdict : std::uint8_t {
  resist,
  leaving,  ///< one comes out of the inside of the other, or an inverted element turns back
  ignore    ///< no direction, or not asked for
};

/// A contact between features. Their relative displacement along the normal is normal . sum(weights[i] * displacement
/// of vertices[i]), positive where they part.
struct FoundContact {
  FeatureKind kind;
  std::array<Index, 4> features;  ///< Contact::vertices: of the collision mesh, which name the pair
  std::array<Index, 4> vertices;  ///< of the simulated mesh: for a shell's prism, the vertices of the shell
  std::array<double, 4> weights;  ///< those of the first feature, less those of the second
  Vec3 normal;                    ///< from the second feature to the first as they should lie
  double toi;
  double gap0, gap1;  ///< along the normal between the points of contact, at the step's start and end
  bool at_start;
  bool solid;  ///< no shell has part in it
  ContactClass contact_class;
  ContactVerdict verdict;
  std::int32_t object_a, object_b;
};

/// Same order as canonical_less.
inline bool same_features(const FoundContact& x, const FoundContact& y) {
  return x.kind == y.kind && x.features == y.features;
}
inline bool features_less(const FoundContact& x, const FoundContact& y) {
  return x.kind != y.kind ? x.kind < y.kind : x.features < y.features;
}

/// The collision mesh is the simulated one, with its shells thickened to prisms. Contacts between features that have a
/// shell's vertex in common (a prism with itself) are never reported: no force on the shell could resist them.
///
/// Next to vertices that were one before they split, contacts are ignored until these have come apart.
///
/// query() runs the pipeline, without its narrow phase, for all pairs that come within separation and margin;
/// contacts() tests those pairs again, by the narrow phase alone, for motions near the one that was queried.
/// Deterministic for any number of workers.
class ContactDetection {
 public:
  struct Config {
    std::string pipeline;
    ContactFeatures features = ContactFeatures::all;
    bool adjacent = true;
    std::vector<std::pair<std::int32_t, std::int32_t>> excluded;
    double separation = 0;
    /// Between these: by how much pairs may be further apart than the separation to be kept in view by a query.
    double least_margin = 0, most_margin = 0;
  };

  /// `model` outlives this and changes only with follow(). `thickness`: an element slot. Throws ConfigError.
  ContactDetection(const Topology& model, std::span<const double> thickness, std::span<const Vec3> reference,
                   Config config);
  ~ContactDetection();

  /// After the edit has been applied to the model's topology. Pairs of the last query are forgotten. `origins`, by
  /// vertex: the one of the mesh at first of which it is a copy, or itself.
  void follow(const TopologyEdit& edit, std::span<const double> thickness, std::span<const Vec3> reference,
              std::span<const Index> origins);

  /// `ahead`: where the vertices are thought to be after another step of the same length, so that contacts on the way
  /// there are in view too; or nothing.
  void query(std::span<const Vec3> x0, std::span<const Vec3> x1, std::span<const Vec3> ahead, Executor& executor);
  /// Whether no vertex is, at either end, further than half the margin from where it was in the last query: then no
  /// pair is missing in contacts().
  bool covers(std::span<const Vec3> x0, std::span<const Vec3> x1, Executor& executor);
  /// Replaces `found` by the contacts, in canonical order, of the pairs of the last query that come within
  /// `separation`.
  void contacts(std::span<const Vec3> x0, std::span<const Vec3> x1, double separation, Executor& executor,
                std::vector<FoundContact>& found);

  /// Of what contacts() has just found, keeps what touches in the same motion and was apart at its start.
  void keep_touching(Executor& executor, std::vector<FoundContact>& found);

  std::size_t candidates() const { return vf_.size() + ee_.size(); }
  const Topology& collision_topology() const { return solid_ ? *solid_ : model_; }
  double separation() const { return config_.separation; }
  /// The pairs of the last query.
  void archive(Archive& archive);

 private:
  struct Candidate {
    FeatureKind kind;
    std::array<Index, 4> vertices;
  };
  /// Vertices of the simulated mesh, and those of the collision mesh there.
  struct Placed {
    std::vector<Vec3> from, to;
  };
  const std::vector<Vec3>& place(std::span<const Vec3> x, Placed& placed, Executor& executor) const;
  void set_motion(std::span<const Vec3> x0, std::span<const Vec3> x1, Executor& executor);
  double spread() const;
  void find_slots();
  FeaturePair slots(const FoundContact& c) const;
  void test(const std::vector<FeaturePair>& vf, const std::vector<FeaturePair>& ee, double separation,
            Executor& executor, std::vector<FoundContact>& found);
  void filter(const Step& step, FeatureKind kind, std::span<const FeaturePair> pairs, FeatureBlock& block,
              std::vector<FeaturePair>& close) const;
  bool boundary_only() const { return config_.features != ContactFeatures::all; }
  Index origin(Index vertex) const;
  std::array<Index, 3> origin_of_triangle(Index f) const;
  void mark_boundary();
  void note_first_surface();
  bool share_shell(const std::array<Index, 4>& vertices, FeatureKind kind) const;
  FoundContact describe(const Contact& contact) const;
  void judge(const Contact& contact, FoundContact& found) const;
  Vec3 outward(std::span<const Index> elements, const Vec3& point) const;
  Vec3 made_up_normal(const Contact& contact) const;
  int side_in_reference(const FoundContact& found) const;
  bool faces(Index v0, Index v1, const Vec3& normal, double toi, bool boundary_only) const;
  bool faces(Index vertex, const Vec3& normal, double toi) const;
  bool rim_faces(const Contact& contact) const;
  bool at_twins(const Contact& contact) const;
  void judge_triangle(const Contact& contact, FoundContact& found, std::span<const Index> elements) const;
  void judge_edges(const Contact& contact, FoundContact& found, std::span<const Index> a,
                   std::span<const Index> b) const;
  bool comes_out(const FoundContact& found, std::span<const Index> a, std::span<const Index> b) const;
  void find_middles();

  const Topology& model_;
  std::vector<double> thickness_;
  std::vector<Vec3> reference_;
  Config config_;
  ObjectFilter filter_;
  std::optional<ShellThickener> thickener_;
  std::unique_ptr<Topology> solid_;  ///< null where there are no shells
  Pipeline pipeline_;
  Workspace workspace_;
  FeatureKdopFilter kdop_filter_{FeatureKdopFilter::Config{}};
  CsatFilter csat_filter_{CsatFilter::Config{}};
  Inclusion narrow_;
  StepResult result_;

  Motion motion_, queried_;
  double reach_ = 0;        ///< margin of the last query
  double queried_end_ = 1;  ///< of the motion queried: where the step ends
  Placed placed0_, placed1_;
  std::vector<Candidate> candidates_;
  std::vector<FeaturePair> vf_, ee_;
  std::vector<Vec3> middles_;  ///< of objects, at the start of the last query
  std::vector<std::vector<FoundContact>> chunks_;
  std::vector<std::unique_ptr<FeatureBlock>> blocks_;  ///< a worker
  std::vector<Index> origins_;                         ///< a vertex of the model; those not in it are their own
  std::vector<std::array<Index, 3>> first_surface_;    ///< ContactFeatures::surface: triangles, ascending
  std::vector<char> boundary_vertex_, boundary_edge_, boundary_triangle_;  ///< as ContactFeatures has it
};

}  // namespace volccd::simulation
