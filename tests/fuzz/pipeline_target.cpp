// Runs the steps of a mesh script (mesh_script.hpp) through pipelines, and compares their contacts with the exact
// results of all elementary tests (lattice_tests.hpp).
#include <algorithm>

#include <fmt/format.h>

#include <volccd/pipelines/compare.hpp>
#include <volccd/pipelines/pipeline.hpp>

#include "lattice_tests.hpp"
#include "mesh_script.hpp"

namespace volccd::fuzz {

namespace {

/// Runs the chunks on the calling thread, in an order, of lengths and as workers that depend on a seed.
class ShuffledExecutor final : public Executor {
 public:
  explicit ShuffledExecutor(unsigned seed) : workers_(1 + seed % 3), random_(seed) {}

  unsigned workers() const override { return workers_; }

  void parallel_for(std::size_t n, std::size_t grain, Body body) override {
    // Short chunks only sometimes: a grain is chosen so that a small mesh is a single chunk.
    const std::size_t longest =
        std::clamp<std::size_t>(random_.below(4) == 0 ? 4 : n, 1, std::max<std::size_t>(grain, 1));
    std::vector<std::pair<std::size_t, std::size_t>> chunks;
    for (std::size_t begin = 0; begin < n;) {
      const std::size_t end = std::min(n, begin + 1 + random_.below(longest));
      chunks.emplace_back(begin, end);
      begin = end;
    }
    random_.shuffle(chunks);
    for (const auto& [begin, end] : chunks) body(begin, end, static_cast<unsigned>(random_.below(workers_)));
  }

 private:
  unsigned workers_;
  Random random_;
};

struct Pipelines {
  const Registry registry = Registry::standard();
  /// The flood takes every step; the default options; star orphans take every step.
  const Pipeline flood, standard, star_orphans;

  Pipelines()
      : flood(registry,
              spec("VolCCD+", {"boundary-flood.max_boundary_fraction=1", "boundary-flood.max_divided_fraction=1",
                               "boundary-flood.max_suspect_fraction=1", "boundary-flood.max_pairs=1e9"})),
        standard(registry, spec("VolCCD+", {})),
        star_orphans(registry, spec("VolCCD+", {"flood=none", "star-orphans.max_suspect_fraction=1"})) {}

 private:
  /// Undecided tests are decided exactly, because one pipeline may leave out a test that another one cannot decide.
  PipelineSpec spec(const char* name, const std::vector<std::string>& settings) const {
    PipelineSpec result = registry.pipeline(name);
    for (const std::string& setting : settings) registry.apply_setting(result, setting);
    registry.apply_setting(result, "inclusion.undecided=exact");
    return result;
  }
};

const Pipelines& pipelines() {
  static const Pipelines all;
  return all;
}

/// A pipeline with the workspace that it keeps from step to step.
struct Contestant {
  const char* name;
  const Pipeline& pipeline;
  Workspace workspace;
  StepResult result;

  Contestant(const char* its_name, const Pipeline& its_pipeline)
      : name(its_name), pipeline(its_pipeline), workspace(its_pipeline.make_workspace()) {}
};

/// Contacts without those that are so close to t_max that a stage may leave them out: a narrow phase may report a
/// contact earlier than it is.
std::vector<Contact> settled(std::span<const Contact> contacts, double t_max) {
  std::vector<Contact> result(contacts.begin(), contacts.end());
  if (t_max < 1) std::erase_if(result, [&](const Contact& c) { return c.toi > t_max - 1e-8; });
  return result;
}

std::string name_of(const Contact& c) {
  return fmt::format("{} {} {} {} {} at {:a} = {}", c.kind == FeatureKind::vf ? "VF" : "EE", c.vertices[0],
                     c.vertices[1], c.vertices[2], c.vertices[3], c.toi, c.toi);
}

/// The first difference in text; empty if there is none.
std::string difference(const ContactDifference& d) {
  if (!d.missing.empty()) return "lacks " + name_of(d.missing.front());
  if (!d.extra.empty()) return "also has " + name_of(d.extra.front());
  if (!d.changed.empty()) return "has other values of " + name_of(d.changed.front().first);
  return {};
}

/// All checks of one script.
class Judge {
 public:
  /// Largest number of tests that integer arithmetic leaves open, in a linear motion without a separation.
  static constexpr std::size_t kMaxOpenTests = 100;

  explicit Judge(Bytes bytes) : bytes_(bytes) {}

  /// Returns false, without a check, for a step with so many open tests that it takes too long.
  bool check_step(const MeshScript& script) {
    script_ = &script;
    const StepOptions& options = script.options();
    const Step step{script.topology(), script.motion(), script.filter(), options.separation, options.t_max};
    LatticeTests tests(step);
    const bool costly = step.separation > 0 || options.quadratic;
    if (tests.open_tests() * (costly ? 4 : 1) > kMaxOpenTests) return false;
    std::vector<Contestant*> contestants = {&flood_};
    if (options.second == StepOptions::Second::standard) contestants.push_back(&standard_);
    if (options.second == StepOptions::Second::star_orphans) contestants.push_back(&star_orphans_);
    for (Contestant* contestant : contestants) {
      run(step, *contestant, contestant->result);
      compare_with_all_tests(step, *contestant, tests);
      if (options.overlaps) compare_overlaps(step, *contestant);
    }
    if (contestants.size() > 1) compare_with_flood(step, *contestants.back());
    if (options.fresh) compare_with_new_workspace(step, *contestants.back());
    if (options.first) check_first(step, *contestants.back());
    return true;
  }

 private:
  void run(const Step& step, Contestant& contestant, StepResult& result, Query query = Query::all) {
    const StepOptions& options = script_->options();
    ShuffledExecutor shuffled(options.executor);
    Executor& executor = options.executor == 0 ? serial_executor() : shuffled;
    contestant.pipeline.run(step, contestant.workspace, executor, result,
                            {.query = query, .initial_overlaps = options.overlaps});
  }

  StepResult run_new(const Step& step, const Pipeline& pipeline) const {
    Workspace workspace = pipeline.make_workspace();
    StepResult result;
    pipeline.run(step, workspace, serial_executor(), result, {.initial_overlaps = script_->options().overlaps});
    return result;
  }

  void compare_with_new_workspace(const Step& step, const Contestant& kept) const {
    const StepResult expected = run_new(step, kept.pipeline);
    require(kept, "compared with a new workspace and one worker, it",
            difference(
                compare_contacts(settled(expected.contacts, step.t_max), settled(kept.result.contacts, step.t_max))));
    if (expected.initial_overlaps != kept.result.initial_overlaps)
      fail(kept, "other initial overlaps than a new workspace");
  }

  void compare_with_all_tests(const Step& step, const Contestant& contestant, LatticeTests& tests) const {
    const std::string problem = tests.problem(contestant.result.contacts);
    if (problem.empty()) return;
    const bool fresh = !LatticeTests(step).problem(run_new(step, contestant.pipeline).contacts).empty();
    fail(contestant, problem + (fresh ? ", also in a new workspace" : ", not in a new workspace"));
  }

  void compare_with_flood(const Step& step, const Contestant& other) const {
    const ContactDifference d =
        compare_contacts(settled(flood_.result.contacts, step.t_max), settled(other.result.contacts, step.t_max));
    require(other, "compared with the flood, it", difference(d));
  }

  void compare_overlaps(const Step& step, const Contestant& contestant) const {
    const std::vector<ElementPair> expected = initial_overlaps(step);
    const std::vector<ElementPair>& found = contestant.result.initial_overlaps;
    if (found != expected) fail(contestant, fmt::format("{} initial overlaps, not {}", found.size(), expected.size()));
  }

  void check_first(const Step& step, Contestant& contestant) {
    const std::vector<Contact>& all = contestant.result.contacts;
    const auto earliest = std::ranges::min_element(all, {}, &Contact::toi);
    if (earliest != all.end() && step.t_max < 1 && earliest->toi > step.t_max - 1e-8) return;
    StepResult found;
    run(step, contestant, found, Query::first);
    const std::span<const Contact> expected(all.data() + (earliest - all.begin()), earliest == all.end() ? 0 : 1);
    require(contestant, "Query::first", difference(compare_contacts(expected, found.contacts)));
    if (found.initial_overlaps != contestant.result.initial_overlaps)
      fail(contestant, "other initial overlaps with Query::first");
  }

  void require(const Contestant& contestant, const char* what, const std::string& difference) const {
    if (!difference.empty()) fail(contestant, fmt::format("{} {}", what, difference));
  }

  /// Prints all steps up to this one, because workspaces are kept.
  [[noreturn]] void fail(const Contestant& contestant, const std::string& what) const {
    std::string text;
    MeshScript again(bytes_);
    while (again.next_step()) {
      text += again.text();
      if (again.steps() == script_->steps()) break;
    }
    promise_broken(fmt::format("{}: {}\n{}", contestant.name, what, text));
  }

  Bytes bytes_;
  const MeshScript* script_ = nullptr;
  Contestant flood_{"VolCCD+ with the flood forced", pipelines().flood};
  Contestant standard_{"VolCCD+", pipelines().standard};
  Contestant star_orphans_{"VolCCD+ with star orphans forced", pipelines().star_orphans};
};

}  // namespace

void pipeline(Bytes bytes) {
  MeshScript script(bytes);
  if (!script.next_step()) return;
  Judge judge(bytes);
  while (judge.check_step(script) && script.next_step()) {
  }
}

}  // namespace volccd::fuzz
