#include <volccd/experiments/verify/verify.hpp>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <set>

namespace volccd {

namespace {

/// The pairs of `these` that are not in `those`; both are ascending.
std::vector<ElementPair> only_in(const std::vector<ElementPair>& these, const std::vector<ElementPair>& those) {
  std::vector<ElementPair> result;
  std::set_difference(these.begin(), these.end(), those.begin(), those.end(), std::back_inserter(result));
  return result;
}

bool same_stage(const StageChoice& a, const StageChoice& b) { return a.name == b.name && a.options == b.options; }

/// Removes contacts of both whose times differ by at most the tolerance.
ContactDifference within_tolerance(ContactDifference difference, double tolerance) {
  std::erase_if(difference.changed, [tolerance](const std::pair<Contact, Contact>& both) {
    return std::abs(both.first.toi - both.second.toi) <= tolerance;
  });
  return difference;
}

}  // namespace

bool StepVerdict::clean() const {
  const bool same =
      std::all_of(pipelines.begin(), pipelines.end(), [](const PipelineVerdict& verdict) { return verdict.agrees(); });
  return same && fcl.clean() && initial.clean();
}

Verifier::Verifier(const Registry& registry, VerifyConfig config)
    : config_(std::move(config)),
      brute_(make_entry(registry, "BruteForce")),
      unculled_(make_entry(registry, "NavCCD")) {
  for (const PipelineSpec& spec : registry.pipelines()) {
    if (spec.name == "BruteForce") continue;
    std::unique_ptr<Entry> entry = make_entry(registry, spec.name);
    entry->held = same_stage(spec.narrow_phase, brute_->pipeline.spec().narrow_phase) ||
                  registry.stage<NarrowPhase>(spec.narrow_phase.name).guarantee != Guarantee::approximate;
    if (entry->held || config_.approximate)
      entries_.push_back(std::move(entry));
    else
      skipped_pipelines_.push_back(spec.name);
  }
}

std::unique_ptr<Verifier::Entry> Verifier::make_entry(const Registry& registry, const std::string& name) {
  Pipeline pipeline(registry, registry.pipeline(name));
  Workspace workspace = pipeline.make_workspace();
  return std::make_unique<Entry>(std::move(pipeline), std::move(workspace));
}

StepVerdict Verifier::check(const Step& step, Executor& executor, std::vector<Contact>* expected) {
  StepVerdict verdict;
  Entry& reference = step.mesh().element_count() <= config_.brute_force_limit ? *brute_ : *unculled_;
  verdict.reference = reference.pipeline.spec().name;
  StepResult truth;
  const Request request{.initial_overlaps = true};
  reference.pipeline.run(step, reference.workspace, executor, truth, request);
  verdict.contacts = truth.contacts.size();
  verdict.initial_overlaps = truth.initial_overlaps.size();
  verdict.earliest_toi = truth.statistics.earliest_toi;
  for (const auto& entry : entries_) {
    PipelineVerdict& one = verdict.pipelines.emplace_back();
    one.pipeline = entry->pipeline.spec().name;
    one.held = entry->held;
    StepResult found;
    try {
      entry->pipeline.run(step, entry->workspace, executor, found, request);
    } catch (const ConfigError& error) {
      one.refused = error.what();
      continue;
    }
    one.difference = compare_contacts(truth.contacts, found.contacts);
    if (!one.held) one.difference = within_tolerance(std::move(one.difference), config_.truth_time_tolerance);
    one.missing_overlaps = only_in(truth.initial_overlaps, found.initial_overlaps);
    one.extra_overlaps = only_in(found.initial_overlaps, truth.initial_overlaps);
    one.statistics = found.statistics;
  }
  const bool complete_edges = step.features().edge_set() == EdgeSet::triangulated;
  if (!config_.fcl_times.empty() && complete_edges)
    verdict.fcl = check_against_fcl(step, truth.contacts, config_.fcl_times, executor);
  if (!config_.fcl_times.empty()) verdict.initial = check_initial_overlaps(step, truth.initial_overlaps, executor);
  if (expected) *expected = std::move(truth.contacts);
  return verdict;
}

TruthVerdict check_against_truth(const Mesh& mesh, std::span<const Contact> contacts,
                                 std::span<const KnownAnswer> truth, double time_tolerance) {
  using Key = std::pair<FeatureKind, std::array<std::int64_t, 4>>;
  TruthVerdict verdict;
  std::map<Key, double> touching;
  for (const KnownAnswer& answer : truth)
    if (answer.collides) touching.emplace(Key{answer.kind, answer.ids}, answer.toi);
  verdict.colliding = touching.size();
  std::set<Key> found;
  for (const Contact& contact : contacts) {
    const ContactRow row = contact_row(0, contact, mesh);
    const auto match = touching.find({row.kind, row.ids});
    if (match == touching.end()) {
      verdict.extra.push_back(row);
      continue;
    }
    found.insert(match->first);
    if (std::isnan(match->second)) continue;
    const double error = std::abs(row.toi - match->second);
    verdict.largest_time_error = std::max(verdict.largest_time_error, error);
    if (error > time_tolerance) verdict.wrong_time.push_back(row);
  }
  for (const auto& [key, toi] : touching)
    if (!found.contains(key)) {
      ContactRow row;
      row.kind = key.first;
      row.ids = key.second;
      row.toi = toi;
      verdict.missing.push_back(row);
    }
  return verdict;
}

}  // namespace volccd
