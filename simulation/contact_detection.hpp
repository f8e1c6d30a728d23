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
#include <volccd/mesh/shells.hpp>
#include <volccd/mesh/topology.hpp>
#include <volccd/narrowphase/inclusion.hpp>
#include <volccd/pipelines/pipeline.hpp>
#include <volccd/query/test_block.hpp>
#include <volccd/simulation/archive.hpp>
#include <volccd/simulation/contact_features.hpp>
#include <volccd/simulation/contact_judge.hpp>
#include <volccd/simulation/found_contact.hpp>

namespace volccd::simulation {

/// The collision mesh is the simulated one, with its shells thickened to prisms. Contacts between features that have a
/// shell's vertex in common (a prism with itself) are never reported: no force on the shell could resist them.
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
  const std::vector<Vec3>& place(std::span<const Vec3> x, Placed& placed, Executor& executor);
  void set_motion(std::span<const Vec3> x0, std::span<const Vec3> x1, Executor& executor);
  double spread() const;
  void find_slots();
  FeaturePair slots(const FoundContact& c) const;
  void test(const std::vector<FeaturePair>& vf, const std::vector<FeaturePair>& ee, double separation,
            Executor& executor, std::vector<FoundContact>& found);
  void filter(const Step& step, TestBlock& block) const;
  Index copies() const { return thickener_ ? 3 : 1; }
  void find_middles();

  const Topology& model_;
  std::vector<double> thickness_;
  std::vector<Vec3> reference_;
  Config config_;
  ObjectFilter filter_;
  std::optional<ShellThickener> thickener_;
  ShellThickener::Scratch scratch_;
  std::unique_ptr<Topology> solid_;  ///< null where there are no shells
  std::optional<ContactSurface> surface_;
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
  std::vector<std::unique_ptr<TestBlock>> blocks_;  ///< a worker
};

}  // namespace volccd::simulation
