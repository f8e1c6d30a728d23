#include <volccd/experiments/tables/inversion_table.hpp>

#include <algorithm>

#include <fmt/format.h>

#include <volccd/core/error.hpp>
#include <volccd/experiments/harness/corner_volumes.hpp>
#include <volccd/experiments/tables/rows.hpp>
#include <volccd/io/sequence/reader.hpp>
#include <volccd/pipelines/step_runner.hpp>

namespace volccd {

using nlohmann::json;

namespace {

/// Elements at the two features of a contact.
std::array<std::span<const Index>, 2> elements_at(const Contact& contact, const Features& features) {
  const auto& v = contact.vertices;
  if (contact.kind == FeatureKind::vf)
    return {features.vertex_elements(v[0]), features.triangle_elements(features.find_triangle(v[1], v[2], v[3]))};
  return {features.edge_elements(features.find_edge(v[0], v[1])),
          features.edge_elements(features.find_edge(v[2], v[3]))};
}

/// Counts of one step.
class InversionCount {
 public:
  explicit InversionCount(const Step& step) : step_(step), inverts_(step.mesh().element_slots(), 0) {
    const Mesh& mesh = step.mesh();
    touching_ = inverts_;
    for (Index o = 0; o < mesh.element_slots(); ++o) {
      if (!mesh.is_live(o) || corner_tetrahedra(mesh.type(o)).empty()) continue;
      ++examined_;
      const Inversion found = inversion(mesh.type(o), mesh.vertices(o), step.motion);
      at_start_ += found == Inversion::at_start ? 1 : 0;
      during_ += found == Inversion::during ? 1 : 0;
      inverts_[o] = found != Inversion::none ? 1 : 0;
    }
  }

  void add(const Contact& contact) {
    const auto sides = elements_at(contact, step_.features());
    bool one_object = false, inside = false, near = false;
    for (const Index a : sides[0])
      for (const Index b : sides[1]) {
        one_object = one_object || step_.mesh().object(a) == step_.mesh().object(b);
        near = near || inverts_[a] || inverts_[b];
        if (a != b || !inverts_[a]) continue;
        inside = true;
        touching_[a] = 1;
      }
    if (!one_object) return;
    ++intra_;
    if (contact.at_start)
      ++intra_at_start_;
    else
      ++(inside ? inside_ : near ? near_ : missed_);
  }

  json counts() const {
    return {{"examined", examined_},  {"inverted_at_start", at_start_},
            {"inverting", during_},   {"touching_inside", std::count(touching_.begin(), touching_.end(), 1)},
            {"intra", intra_},        {"intra_at_start", intra_at_start_},
            {"in_inverted", inside_}, {"at_inverted", near_},
            {"missed", missed_}};
  }

 private:
  const Step& step_;
  std::vector<char> inverts_, touching_;  ///< by element
  std::uint64_t examined_ = 0, at_start_ = 0, during_ = 0;
  std::uint64_t intra_ = 0, intra_at_start_ = 0, inside_ = 0, near_ = 0, missed_ = 0;
};

void add_rows(const PlanContext& context, const TableScene& scene, MotionModel model, Executor& executor,
              const std::function<void()>& check, std::vector<json>& rows) {
  SequenceReader reader(scene.file);
  const SequenceStepper::Config config = table_config(scene.file, model);
  SequenceStepper stepper(reader, config);
  StepRunner runner(Pipeline(context.registry, context.registry.pipeline("VolCCD+")),
                    {.executor = &executor, .leave_out_shell_neighbours = config.shells == ShellModel::solid});
  for (int k = 0; k < stepper.step_count(); ++k) {
    check();
    stepper.go_to(k, executor);
    const Step step{stepper.topology(), stepper.motion(), runner.filter()};
    const StepResult& result = runner.run(step.topology, step.motion);
    rows.push_back({{"scene", scene.name},
                    {"motion_model", name_of(model)},
                    {"step", k},
                    {"elements", step.mesh().element_count()}});
    rows.back().update(count_inversions(step, result.contacts));
  }
}

std::uint64_t number(const json& row, const char* column) { return row.at(column).get<std::uint64_t>(); }
/// Contacts that begin during the step.
std::uint64_t later(const json& row) { return number(row, "intra") - number(row, "intra_at_start"); }
std::uint64_t inverted(const json& row) { return number(row, "inverted_at_start") + number(row, "inverting"); }

/// Sums of one scene in one motion model.
struct Sums {
  std::uint64_t steps = 0, with_contacts = 0, silent = 0, elements = 0, at_start = 0, inverting = 0,
                touching_inside = 0, intra_at_start = 0, intra = 0, inside = 0, near = 0, missed = 0;

  void add(const json& row) {
    ++steps;
    elements = std::max(elements, number(row, "elements"));
    with_contacts += later(row) > 0 ? 1 : 0;
    silent += later(row) > 0 && inverted(row) == 0 ? 1 : 0;
    at_start += number(row, "inverted_at_start");
    inverting += number(row, "inverting");
    touching_inside += number(row, "touching_inside");
    intra_at_start += number(row, "intra_at_start");
    intra += later(row);
    inside += number(row, "in_inverted");
    near += number(row, "at_inverted");
    missed += number(row, "missed");
  }
};

}  // namespace

json count_inversions(const Step& step, std::span<const Contact> contacts) {
  InversionCount count(step);
  for (const Contact& contact : contacts) count.add(contact);
  return count.counts();
}

ExperimentPlan inversion_plan(const PlanContext& context) {
  ExperimentPlan plan{"inversion", context.full ? "full" : "quick", 1, {}};
  for (const TableScene& scene : table_scenes(context)) plan.runs.push_back({scene.name, scene.file});
  return plan;
}

void inversion_rows(const PlanContext& context, RecordFile& record) {
  SerialExecutor serial;
  Executor& executor = context.executor ? *context.executor : serial;
  const std::vector<TableScene> scenes = table_scenes(context);
  if (scenes.empty()) throw ConfigError("inversion: none of its scenes is available");
  for (std::size_t s = 0; s < scenes.size(); ++s) {
    if (record.has(scenes[s].name)) continue;
    std::vector<json> rows;
    const std::function<void()> check = [&] {
      if (context.progress) context.progress(s, scenes.size());
    };
    add_rows(context, scenes[s], MotionModel::linear, executor, check, rows);
    if (SequenceReader(scenes[s].file).has_velocity())
      add_rows(context, scenes[s], MotionModel::tentative, executor, check, rows);
    record.add(scenes[s].name, rows);
  }
}

std::vector<TitledTable> inversion_tables(const json& record) {
  TextTable table(
      {"scene", "motion model", "elements", "steps", "with contacts", "no inversion", "inverted at start", "inverting",
       "touch inside", "contacts at t = 0", "contacts", "in inverted", "at inverted", "missed", "share"},
      2);
  const Rows rows(record);
  for (const json& model : rows.values("motion_model"))
    for (const json& scene : rows.with("motion_model", model).values("scene")) {
      Sums sums;
      for (const json& row : record.at("rows"))
        if (row.at("scene") == scene && row.at("motion_model") == model) sums.add(row);
      table.add(
          {scene, model, grouped(sums.elements), grouped(sums.steps), grouped(sums.with_contacts), grouped(sums.silent),
           grouped(sums.at_start), grouped(sums.inverting), grouped(sums.touching_inside), grouped(sums.intra_at_start),
           grouped(sums.intra), grouped(sums.inside), grouped(sums.near), grouped(sums.missed),
           sums.intra > 0 ? percent_text(static_cast<double>(sums.missed) / static_cast<double>(sums.intra)) : "-"});
    }
  return {{"Section 7.2: the inversion test as a self-collision check", table,
           "sums over all steps. with contacts: steps in which features of one object come into contact after t = "
           "0; no inversion: of these, steps in which no element is inverted or inverts, so that the test finds "
           "nothing; touch inside: of the elements that are inverted at the start or invert, those with a contact "
           "between their own features; contacts: within one object, after t = 0; in inverted: both features are of "
           "one such element; at inverted: one of the features is; missed: none is\n"}};
}

}  // namespace volccd
