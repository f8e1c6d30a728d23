// Finds the contacts of a step with a pipeline of this library, and describes them in terms of the simulated mesh.
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
#include <volccd/culling/filters/csat_filter.hpp>
#include <volccd/culling/filters/feature_kdop_filter.hpp>
#include <volccd/mesh/shells.hpp>
#include <volccd/mesh/topology.hpp>
#include <volccd/narrowphase/inclusion/inclusion.hpp>
#include <volccd/pipelines/step_runner.hpp>
#include <volccd/query/test_block.hpp>
#include <volccd/simulation/archive.hpp>
#include <volccd/simulation/contact/contact_features.hpp>
#include <volccd/simulation/contact/contact_judge.hpp>
#include <volccd/simulation/contact/found_contact.hpp>

namespace volccd::simulation {

/// The collision mesh is the simulated mesh with its shells thickened to prisms. Contacts between features that have
/// copies of the same shell vertex are never reported, because no force on the shell could resist them.
///
/// query() runs the pipeline, without its narrow phase, to find all pairs that come within the separation plus a
/// margin; contacts() tests these pairs with the narrow phase alone, for motions near the one that was queried.
/// Deterministic for any number of workers.
class ContactDetection {
 public:
  struct Config {
    std::string pipeline;
    ContactFeatures features = ContactFeatures::all;
    bool adjacent = true;
    std::vector<std::pair<std::int32_t, std::int32_t>> excluded;
    double separation = 0;
    /// Bounds of the margin: a query finds pairs that come within the separation plus the margin.
    double min_margin = 0, max_margin = 0;
  };

  /// `model` must outlive this object, and follow() must be called after each change of it. `thickness`: by element
  /// slot. `reference`: positions at rest, by vertex. The executor builds the topology of thickened shells and runs
  /// query(); it must outlive this object. Throws ConfigError for an invalid configuration.
  ContactDetection(const Topology& model, std::span<const double> thickness, std::span<const Vec3> reference,
                   Config config, Executor& executor);
  ~ContactDetection();

  /// To be called after the edit has been applied to the model's topology. Removes the pairs of the last query.
  /// `origins`, by vertex: the vertex of the initial mesh of which it is a copy, or itself.
  void follow(const TopologyEdit& edit, std::span<const double> thickness, std::span<const Vec3> reference,
              std::span<const Index> origins);

  /// Finds the pairs for the motion from x0 to x1. `ahead`: estimated positions after another step of the same length,
  /// so that pairs are also found for the motion up to there; or empty.
  void query(std::span<const Vec3> x0, std::span<const Vec3> x1, std::span<const Vec3> ahead);
  /// Whether each vertex is, at both ends, within half the margin of its position in the last query. If so, contacts()
  /// misses no pair.
  bool covers(std::span<const Vec3> x0, std::span<const Vec3> x1, Executor& executor);
  /// Replaces `found` by the contacts, in canonical order, of the pairs of the last query that come within
  /// `separation`.
  void contacts(std::span<const Vec3> x0, std::span<const Vec3> x1, double separation, Executor& executor,
                std::vector<FoundContact>& found);

  /// Keeps those of the contacts just found by contacts() whose features touch (distance zero) in the same motion and
  /// were apart at its start.
  void keep_touching(Executor& executor, std::vector<FoundContact>& found);

  std::size_t candidates() const { return vf_.size() + ee_.size(); }
  const Topology& collision_topology() const { return solid_ ? *solid_ : model_; }
  double separation() const { return config_.separation; }
  /// Separation plus margin of the last query.
  double queried_separation() const { return config_.separation + reach_; }
  /// Writes or reads the pairs of the last query.
  void archive(Archive& archive);

 private:
  struct Candidate {
    FeatureKind kind;
    std::array<Index, 4> vertices;
  };
  /// Positions of the simulated mesh, and the positions of the collision mesh that follow from them.
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
  std::optional<ShellThickener> thickener_;
  ShellThickener::Scratch scratch_;
  std::unique_ptr<Topology> solid_;  ///< null where there are no shells
  std::optional<ContactSurface> surface_;
  StepRunner runner_;
  FeatureKdopFilter kdop_filter_{FeatureKdopFilter::Config{}};
  CsatFilter csat_filter_{CsatFilter::Config{}};
  Inclusion narrow_;

  Motion motion_, queried_;
  double reach_ = 0;        ///< margin of the last query
  double queried_end_ = 1;  ///< end of the step, as a time of the motion queried
  Placed placed0_, placed1_;
  std::vector<Candidate> candidates_;
  std::vector<FeaturePair> vf_, ee_;
  std::vector<Vec3> middles_;  ///< centroids of objects, at the start of the last query
  std::vector<std::vector<FoundContact>> chunks_;
  std::vector<std::unique_ptr<TestBlock>> blocks_;  ///< by worker
};

}  // namespace volccd::simulation
