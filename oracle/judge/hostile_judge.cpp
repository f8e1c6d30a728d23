#include <volccd/oracle/judge/hostile_judge.hpp>

#include <algorithm>
#include <exception>
#include <iterator>

#include <fmt/format.h>

#include <volccd/pipelines/compare.hpp>

namespace volccd {

using cases::HostileCase;
using cases::HostileStep;

namespace {

/// Up to this number of elements, every pair of elements is compared; above, the truth is that of `VolCCD`, which knows
/// neither stars nor floods, and takes a tenth of the time.
constexpr Index kBruteForceLimit = 60;

PipelineSpec plus(const Registry& registry, const char* name) {
  PipelineSpec spec = registry.pipeline("VolCCD+");
  spec.name = name;
  return spec;
}

/// Feature filters, which are proven and tested on their own, make the truth several times faster.
PipelineSpec truth(const Registry& registry, const char* preset) {
  PipelineSpec spec = registry.pipeline(preset);
  spec.feature_filters = registry.pipeline("VolCCD+").feature_filters;
  return spec;
}

void apply(const HostileStep& step, Topology& topology) {
  TopologyEdit edit;
  for (const std::int64_t id : step.removed) edit.removed.push_back(topology.mesh().find_element(id));
  const Index first = topology.mesh().vertex_count();
  for (Index i = 0; i < step.new_vertices; ++i) edit.new_vertex_ids.push_back(first + i);
  edit.added = step.added;
  if (!edit.empty()) topology.apply(edit);
}

Request request_of(const HostileStep& step) {
  return {.query = step.first_only ? Query::first : Query::all, .initial_overlaps = step.initial_overlaps};
}

std::string text_of(const Contact& c) {
  return fmt::format("{} {} {} {} {} at t = {:g}", c.kind == FeatureKind::vf ? "VF" : "EE", c.vertices[0],
                     c.vertices[1], c.vertices[2], c.vertices[3], c.toi);
}

std::string text_of(const ContactDifference& d, std::size_t expected) {
  std::string text = fmt::format("{} missing, {} extra, {} changed of {} contacts", d.missing.size(), d.extra.size(),
                                 d.changed.size(), expected);
  if (!d.missing.empty()) text += ", missing " + text_of(d.missing[0]);
  if (!d.extra.empty()) text += ", extra " + text_of(d.extra[0]);
  if (!d.changed.empty()) text += ", changed " + text_of(d.changed[0].first);
  return text;
}

}  // namespace

PipelineSpec forced_flood(const Registry& registry) {
  PipelineSpec spec = plus(registry, "flood forced");
  spec.flood->options = {{"max_boundary_fraction", "1"},
                         {"max_divided_fraction", "1"},
                         {"max_suspect_fraction", "1"},
                         {"max_pairs", "1e9"}};
  return spec;
}

PipelineSpec default_flood(const Registry& registry) { return plus(registry, "default options"); }

PipelineSpec forced_star_orphans(const Registry& registry) {
  PipelineSpec spec = plus(registry, "star-orphans forced");
  spec.flood.reset();
  spec.orphans = {"star-orphans", {{"max_suspect_fraction", "1"}}};
  return spec;
}

struct HostileJudge::Contestant {
  Pipeline pipeline;
  Workspace kept;
};

/// The steps of one case.
class HostileJudge::Trial {
 public:
  Trial(HostileJudge& judge, const HostileCase& c) : judge_(judge), case_(c) {
    for (const Mesh& mesh : c.meshes) topologies_.emplace_back(mesh);
    for (const auto& one : judge.contestants_) one->kept = one->pipeline.make_workspace();
  }

  std::string run() {
    for (std::size_t k = 0; k < case_.steps.size(); ++k) {
      const std::string problem = run_step(case_.steps[k], k);
      if (!problem.empty())
        return fmt::format("step {} (mesh {}; {}), {}", k, case_.steps[k].mesh, case_.steps[k].what, problem);
    }
    return {};
  }

 private:
  std::string run_step(const HostileStep& described, std::size_t k) {
    Topology& topology = topologies_[described.mesh];
    apply(described, topology);
    const Step step{topology, described.motion, described.filter, described.separation, described.t_max};
    const Request request = request_of(described);
    run_truth(step, request, expected_);
    ++judge_.counters_.steps;
    judge_.counters_.contacts += expected_.contacts.size();
    judge_.counters_.initial_overlaps += expected_.initial_overlaps.size();
    for (const auto& one : judge_.contestants_) {
      const bool threaded = k % 4 == 3;
      std::string problem = compare(*one, one->kept, step, request, threaded);
      if (!problem.empty()) return one->pipeline.spec().name + ", kept workspace" + problem;
      if (k % 3 != 1) continue;  // on step 0, the kept workspace is a new one
      Workspace fresh = one->pipeline.make_workspace();
      problem = compare(*one, fresh, step, request, false);
      if (!problem.empty()) return one->pipeline.spec().name + ", new workspace" + problem;
    }
    return {};
  }

  void run_truth(const Step& step, const Request& request, StepResult& result) {
    const bool small = step.mesh().element_count() <= kBruteForceLimit;
    judge_.memory_->clear();
    Contestant& truth = small ? *judge_.small_truth_ : *judge_.large_truth_;
    truth.pipeline.run(step, truth.kept, serial_executor(), result, request);
  }

  std::string compare(const Contestant& one, Workspace& workspace, const Step& step, const Request& request,
                      bool threaded) {
    Executor& executor = threaded ? *judge_.threads_ : serial_executor();
    const char* workers = threaded ? ", 3 workers: " : ": ";
    try {
      one.pipeline.run(step, workspace, executor, found_, request);
    } catch (const std::exception& error) {
      return workers + std::string(error.what());
    }
    const ContactDifference difference = compare_contacts(expected_.contacts, found_.contacts);
    if (!difference.empty()) return workers + text_of(difference, expected_.contacts.size());
    if (expected_.initial_overlaps != found_.initial_overlaps)
      return fmt::format("{}{} initial overlaps instead of {}", workers, found_.initial_overlaps.size(),
                         expected_.initial_overlaps.size());
    return {};
  }

  HostileJudge& judge_;
  const HostileCase& case_;
  std::vector<Topology> topologies_;
  StepResult expected_, found_;
};

HostileJudge::HostileJudge(const Registry& registry, const std::vector<PipelineSpec>& specs)
    : memory_(make_contact_memory(registry)), threads_(make_thread_executor(3)) {
  Registry extended = registry;
  extended.add(describe_remembered(memory_));
  const auto make = [&](PipelineSpec spec) {
    spec.narrow_phase = {"remembered", {}};
    Pipeline pipeline(extended, spec);
    Workspace workspace = pipeline.make_workspace();
    return std::make_unique<Contestant>(Contestant{std::move(pipeline), std::move(workspace)});
  };
  small_truth_ = make(truth(registry, "BruteForce"));
  large_truth_ = make(truth(registry, "VolCCD"));
  for (const PipelineSpec& spec : specs) contestants_.push_back(make(spec));
}

HostileJudge::~HostileJudge() = default;

std::string HostileJudge::judge(const HostileCase& c) {
  ++counters_.cases;
  const std::string problem = Trial(*this, c).run();
  return problem.empty() ? problem : c.name + ", " + problem;
}

std::string HostileJudge::judge_seed(std::uint64_t seed) {
  cases::Choices choices(seed);
  const std::string problem = judge(cases::make_hostile(choices));
  return problem.empty() ? problem : fmt::format("seed {}: {}", seed, problem);
}

std::string HostileJudge::reduced_text(const HostileCase& c) {
  const auto fails = [this](const HostileCase& less) { return !judge(less).empty(); };
  const HostileCase small = cases::reduced(c, fails);
  return judge(small) + "\n" + cases::to_text(small);
}

}  // namespace volccd
