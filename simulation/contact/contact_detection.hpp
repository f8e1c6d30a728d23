// Finds the contacts of a step with a pipeline of this library, and describes them in terms of the simulated mesh.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <volccd/core/executor.hpp>
#include <volccd/mesh/shells.hpp>
#include <volccd/mesh/topology.hpp>
#include <volccd/pipelines/step_runner.hpp>
#include <volccd/simulation/contact/contact_features.hpp>
#include <volccd/simulation/contact/contact_judge.hpp>
#include <volccd/simulation/contact/found_contact.hpp>

namespace volccd::simulation {

/// The collision mesh is the simulated mesh with its shells thickened to prisms. Contacts between features that have
/// copies of the same shell vertex are never reported, because no force on the shell could resist them.
///
/// Answers are those of a run of the pipeline with `inclusion`, whose open tests are decided exactly, so that they
/// depend on the motion alone. Motions near earlier ones take candidate lists (docs/candidate_lists.md). Deterministic
/// for any number of workers.
class ContactDetection {
 public:
  struct Config {
    std::string pipeline;
    ContactFeatures features = ContactFeatures::all;
    bool adjacent = true;
    std::vector<std::pair<std::int32_t, std::int32_t>> excluded;
    double separation = 0;
    ListConfig lists = {};
  };

  /// `model` must outlive this object, and follow() must be called after each change of it. `thickness`: by element
  /// slot. `reference`: positions at rest, by vertex. The executor must outlive this object. Throws ConfigError for an
  /// invalid configuration.
  ContactDetection(const Topology& model, std::span<const double> thickness, std::span<const Vec3> reference,
                   Config config, Executor& executor);
  ~ContactDetection();

  /// To be called after the edit has been applied to the model's topology. `origins`, by vertex: the vertex of the
  /// initial mesh of which it is a copy, or itself.
  void follow(const TopologyEdit& edit, std::span<const double> thickness, std::span<const Vec3> reference,
              std::span<const Index> origins);

  /// Replaces `found` by the contacts of the motion on straight lines from x0 to x1, in canonical order.
  void find(std::span<const Vec3> x0, std::span<const Vec3> x1, std::vector<FoundContact>& found);

  /// Keeps those of the contacts just found by find() whose features touch (distance zero) in the same motion and were
  /// apart at its start.
  void keep_touching(std::vector<FoundContact>& found);

  const Topology& collision_topology() const { return solid_ ? *solid_ : model_; }
  double separation() const { return config_.separation; }

 private:
  /// Positions of the simulated mesh, and the positions of the collision mesh that follow from them.
  struct Placed {
    std::vector<Vec3> from, to;
  };
  const std::vector<Vec3>& place(std::span<const Vec3> x, Placed& placed);
  void set_motion(std::span<const Vec3> x0, std::span<const Vec3> x1);
  void run(double separation, Request request, std::vector<FoundContact>& found);
  void find_middles();
  Index copies() const { return thickener_ ? 3 : 1; }

  const Topology& model_;
  std::vector<double> thickness_;
  std::vector<Vec3> reference_;
  Config config_;
  std::optional<ShellThickener> thickener_;
  ShellThickener::Scratch scratch_;
  std::unique_ptr<Topology> solid_;  ///< null where there are no shells
  std::optional<ContactSurface> surface_;
  StepRunner runner_;

  Motion motion_;
  Placed placed0_, placed1_;
  TestBatch near_;             ///< the tests of keep_touching()
  std::vector<Vec3> middles_;  ///< centroids of objects, at the start of the motion
};

}  // namespace volccd::simulation
