// Cross-check of everything that is registered: `volccd verify`.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include <volccd/experiments/records/contacts_csv.hpp>
#include <volccd/mesh/sequence/ground_truth.hpp>
#include <volccd/oracle/overlap_oracle.hpp>
#include <volccd/pipelines/compare.hpp>
#include <volccd/pipelines/pipeline.hpp>
#include <volccd/query/contact.hpp>

namespace volccd {

struct VerifyConfig {
  /// Elements up to which the reference is brute force (every pair of elements compared); beyond, it is the k-DOP BVH
  /// without any culling.
  Index brute_force_limit = 100000;
  /// Times at which FCL looks; none: no oracle.
  std::vector<double> fcl_times = {0.25, 0.5, 0.75, 1.0};
  /// Tolerance on times where the file has ground truth with times, and on those of approximate narrow phases.
  double truth_time_tolerance = 1e-6;
  /// Request::leave_out_shell_neighbours, for all pipelines. What is left out is compared, too. FCL does not miss it:
  /// the elements have a common vertex, or touch at t = 0.
  bool leave_out_shell_neighbours = false;
  /// Whether pipelines run that are not held to the reference's contacts (PipelineVerdict::held), too.
  bool approximate = false;
};

/// How one pipeline did on one step, against the reference.
struct PipelineVerdict {
  std::string pipeline;
  std::string refused;  ///< why it cannot run this step (no difference), or empty
  /// Whether it is held to the reference's contacts, bit for bit. Not if its narrow phase is approximate and another
  /// one than the reference's: then `difference` leaves out contacts of both whose times agree within
  /// VerifyConfig::truth_time_tolerance, and what is left does not count.
  bool held = true;
  ContactDifference difference;
  ContactDifference left_out;  ///< of StepResult::left_out
  std::vector<ElementPair> missing_overlaps, extra_overlaps;  ///< of the lists of initial overlaps
  Statistics statistics;

  bool same() const {
    return (!held || (difference.empty() && left_out.empty())) && missing_overlaps.empty() && extra_overlaps.empty();
  }
};

/// How the reference did against the file's ground truth.
struct TruthVerdict {
  std::uint64_t colliding = 0;     ///< pairs that touch, by the truth
  std::vector<ContactRow> missing; ///< of those, not among the contacts
  std::vector<ContactRow> extra;   ///< contacts that the truth does not have
  double largest_time_error = 0;   ///< over common pairs with a true time
  std::vector<ContactRow> wrong_time;  ///< contacts whose time is off by more than the tolerance

  bool clean() const { return missing.empty() && extra.empty() && wrong_time.empty(); }
};

struct StepVerdict {
  std::string reference;  ///< name of the reference pipeline
  std::uint64_t contacts = 0, left_out = 0;
  double earliest_toi = 0;
  std::vector<PipelineVerdict> pipelines;
  OverlapReport fcl;
  std::uint64_t initial_overlaps = 0;  ///< listed by the reference
  InitialOverlapReport initial;        ///< how that list did against FCL at t = 0; empty without the oracle
  bool clean() const;
};

/// Keeps pipelines and workspaces from step to step, as a user of a sequence does: their incremental updates are
/// checked too.
class Verifier {
 public:
  Verifier(const Registry& registry, VerifyConfig config);

  /// Names of the registered pipelines that do not run, as VerifyConfig::approximate has it.
  const std::vector<std::string>& skipped_pipelines() const { return skipped_pipelines_; }

  /// Runs the reference and every other registered pipeline but those left out. `expected`, if given, receives the
  /// reference's contacts.
  StepVerdict check(const Step& step, Executor& executor, std::vector<Contact>* expected = nullptr);

 private:
  struct Entry {
    Entry(Pipeline p, Workspace w) : pipeline(std::move(p)), workspace(std::move(w)) {}
    Pipeline pipeline;
    Workspace workspace;
    bool held = true;
  };

  VerifyConfig config_;
  static std::unique_ptr<Entry> make_entry(const Registry& registry, const std::string& name);

  std::unique_ptr<Entry> brute_, unculled_;
  std::vector<std::unique_ptr<Entry>> entries_;
  std::vector<std::string> skipped_pipelines_;
};

/// Contacts of motion 0 -> 1 against the file's truth, which lists all pairs that touch.
TruthVerdict check_against_truth(const Mesh& mesh, std::span<const Contact> contacts,
                                 std::span<const KnownAnswer> truth, double time_tolerance);

}  // namespace volccd
