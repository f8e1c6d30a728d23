// Compares all registered pipelines with each other and with FCL: `volccd verify`.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include <volccd/io/contacts_csv.hpp>
#include <volccd/io/sequence/ground_truth.hpp>
#include <volccd/oracle/overlap_oracle.hpp>
#include <volccd/pipelines/compare.hpp>
#include <volccd/pipelines/pipeline.hpp>
#include <volccd/query/contact.hpp>

namespace volccd {

struct VerifyConfig {
  /// Up to this number of elements the reference is brute force (every pair of elements is compared); above, it is
  /// `NavCCD`, the k-DOP tree without culling.
  Index brute_force_limit = 100000;
  /// Times at which FCL searches overlaps; empty: FCL is not used.
  std::vector<double> fcl_times = {0.25, 0.5, 0.75, 1.0};
  /// Tolerance for comparing times with a ground truth that has times, and for those of approximate narrow phases.
  double truth_time_tolerance = 1e-6;
  /// Whether to run also the pipelines that need not find the reference's contacts (PipelineVerdict::held is false).
  bool approximate = false;
};

/// Result of one pipeline on one step, compared with the reference.
struct PipelineVerdict {
  std::string pipeline;
  std::string refused;  ///< reason why it cannot run this step (not a difference), or empty
  /// Whether it must find the reference's contacts, bit for bit. False if its narrow phase is approximate and differs
  /// from the reference's. Then `difference` does not contain contacts of both whose times agree within
  /// VerifyConfig::truth_time_tolerance, and the others are shown but do not count as a failure.
  bool held = true;
  ContactDifference difference;
  std::vector<ElementPair> missing_overlaps, extra_overlaps;  ///< of the lists of initial overlaps
  Statistics statistics;

  bool agrees() const { return (!held || difference.empty()) && missing_overlaps.empty() && extra_overlaps.empty(); }
};

/// Result of comparing the reference with the file's ground truth.
struct TruthVerdict {
  std::uint64_t colliding = 0;         ///< pairs that touch according to the truth
  std::vector<ContactRow> missing;     ///< pairs of the truth that are not among the contacts
  std::vector<ContactRow> extra;       ///< contacts that are not in the truth
  double largest_time_error = 0;       ///< over common pairs with a true time
  std::vector<ContactRow> wrong_time;  ///< contacts whose time is off by more than the tolerance

  bool clean() const { return missing.empty() && extra.empty() && wrong_time.empty(); }
};

struct StepVerdict {
  std::string reference;  ///< name of the reference pipeline
  std::uint64_t contacts = 0;
  double earliest_toi = 0;
  std::vector<PipelineVerdict> pipelines;
  OverlapReport fcl;
  std::uint64_t initial_overlaps = 0;  ///< listed by the reference
  InitialOverlapReport initial;        ///< comparison of that list with FCL at t = 0; empty without FCL
  bool clean() const;
};

/// Keeps pipelines and workspaces from step to step, as in normal use, so that their incremental updates are checked,
/// too.
class Verifier {
 public:
  Verifier(const Registry& registry, VerifyConfig config);

  /// Names of the registered pipelines that do not run because VerifyConfig::approximate is false.
  const std::vector<std::string>& skipped_pipelines() const { return skipped_pipelines_; }

  /// Runs the reference and every other registered pipeline except for the skipped ones. `expected`, if given, receives
  /// the reference's contacts. If the step leaves out shell neighbours, the check against FCL does not require their
  /// contacts, because their elements have a common vertex or touch at t = 0.
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

/// Compares the contacts of step 0 with the file's ground truth, which lists all pairs that touch.
TruthVerdict check_against_truth(const Mesh& mesh, std::span<const Contact> contacts,
                                 std::span<const KnownAnswer> truth, double time_tolerance);

}  // namespace volccd
