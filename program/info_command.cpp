#include <algorithm>
#include <cstdio>
#include <map>
#include <optional>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <volccd/experiments/tables/text_table.hpp>
#include <volccd/io/sequence/reader.hpp>
#include <volccd/program/commands.hpp>
#include <volccd/program/progress.hpp>
#include <volccd/program/query_options.hpp>
#include <volccd/program/report.hpp>
#include <volccd/program/scene_files.hpp>
#include <volccd/program/step_loop.hpp>

namespace volccd {

namespace {

struct InfoOptions {
  SequenceOptions sequence;
  ReportOptions report;
};

/// Counts of live elements by type and by object.
struct Census {
  std::map<ElementType, std::uint64_t> types;
  std::map<std::int32_t, std::uint64_t> objects;
};

Census census(const Mesh& mesh) {
  Census result;
  for (Index o = 0; o < mesh.element_slots(); ++o)
    if (mesh.is_live(o)) {
      ++result.types[mesh.type(o)];
      ++result.objects[mesh.object(o)];
    }
  return result;
}

double quantile(std::vector<double>& values, double q) {
  if (values.empty()) return 0;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(q * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// Mean length of the live edges at t = 0, and how far the vertices in use move, in that unit.
struct MovementFacts {
  double mean_edge = 0, median = 0, p99 = 0, largest = 0;
};

MovementFacts movement_facts(const Topology& topology, const Motion& motion) {
  MovementFacts facts;
  const Features& features = topology.features();
  double sum = 0;
  for (Index e = 0; e < features.edge_slots(); ++e)
    if (!features.edge_elements(e).empty())
      sum += (motion.point(features.edge(e)[0], 0) - motion.point(features.edge(e)[1], 0)).norm();
  if (features.edge_count() > 0) facts.mean_edge = sum / features.edge_count();
  std::vector<double> moved;
  for (Index v = 0; v < features.vertex_slots(); ++v)
    if (!features.vertex_elements(v).empty())
      moved.push_back((motion.point(v, motion.degree()) - motion.point(v, 0)).norm() /
                      std::max(facts.mean_edge, 1e-300));
  facts.median = quantile(moved, 0.5);
  facts.p99 = quantile(moved, 0.99);
  facts.largest = quantile(moved, 1);
  return facts;
}

void print_header(const Report& report, SequenceReader& reader) {
  const SequenceMetadata& about = reader.metadata();
  report.print("{}\n", reader.file());
  const auto line = [&](const char* name, const std::string& value) {
    if (!value.empty()) report.print("{}\n", wrapped(fmt::format("  {:<10} {}", name, value)));
  };
  line("title", about.title);
  line("source", about.source);
  line("license", about.license);
  line("units", about.units);
  line("time unit", about.time_unit);
  line("INCOMPLETE", about.incomplete);
  line("frames", fmt::format("{}, times {:g} to {:g}", reader.frame_count(), reader.time(0),
                             reader.time(reader.frame_count() - 1)));
  line("points", grouped(reader.point_count()));
  line("arrays", std::string(reader.has_velocity() ? "velocity " : "") + (reader.has_thickness() ? "thickness " : "") +
                     (reader.has_query() ? "query" : ""));
}

nlohmann::json header_json(SequenceReader& reader) {
  const SequenceMetadata& about = reader.metadata();
  return {{"sequence", reader.file()},
          {"title", about.title},
          {"source", about.source},
          {"license", about.license},
          {"units", about.units},
          {"time_unit", about.time_unit},
          {"incomplete", about.incomplete.empty() ? nlohmann::json(nullptr) : nlohmann::json(about.incomplete)},
          {"frames", reader.frame_count()},
          {"begin_time", reader.time(0)},
          {"end_time", reader.time(reader.frame_count() - 1)},
          {"points", reader.point_count()},
          {"has_velocity", reader.has_velocity()},
          {"has_thickness", reader.has_thickness()},
          {"has_query", reader.has_query()},
          {"steps", nlohmann::json::array()}};
}

constexpr std::size_t kObjectsShown = 40;

std::string named_count(ElementType type, std::uint64_t count) {
  std::string name = to_string(type);
  if (count == 1) return name;
  if (name.ends_with("hedron")) return name.substr(0, name.size() - 2) + "a";
  return name + "s";
}

/// "12 hexahedra as wedges, 1 quad as triangle".
std::string collapsed_text(const SequenceReader& reader) {
  std::string text;
  for (const auto& [types, count] : reader.collapsed_cells())
    text += fmt::format("{}{} {} as {}", text.empty() ? "" : ", ", grouped(count), named_count(types.first, count),
                        named_count(types.second, count));
  return text;
}

std::string object_name(const SequenceReader& reader, std::int32_t object, bool named) {
  const auto& names = reader.metadata().object_names;
  const auto name = names.find(object);
  return name == names.end() || !named ? std::string() : name->second;
}

/// `named`: whether the objects are those that the file stores and may name.
void print_mesh(const Report& report, const SequenceReader& reader, const Topology& topology, bool named) {
  const Census counts = census(topology.mesh());
  const Features& features = topology.features();
  report.print("\nframe 0\n");
  for (const auto& [type, count] : counts.types) report.print("  {:<12} {:>10}\n", to_string(type), grouped(count));
  if (const std::string text = collapsed_text(reader); !text.empty())
    report.print("{}\n", wrapped("  nodes repeat, read as: " + text));
  std::size_t shown = 0;
  for (const auto& [object, count] : counts.objects) {
    if (++shown > kObjectsShown) continue;
    report.print("  {:<12} {:>10}  {}\n", fmt::format("{} {}", named ? "object" : "component", object), grouped(count),
                 object_name(reader, object, named));
  }
  if (shown > kObjectsShown) report.print("  and {} more\n", grouped(shown - kObjectsShown));
  report.print("  {:<12} {:>10}\n  {:<12} {:>10}\n  {:<12} {:>10}\n", "vertices used", grouped(features.vertex_count()),
               "edges", grouped(features.edge_count()), "triangles", grouped(features.triangle_count()));
}

nlohmann::json mesh_json(const SequenceReader& reader, const Topology& topology, bool named) {
  const Census counts = census(topology.mesh());
  nlohmann::json elements = nlohmann::json::object(), objects = nlohmann::json::array();
  for (const auto& [type, count] : counts.types) elements[to_string(type)] = count;
  for (const auto& [object, count] : counts.objects)
    objects.push_back({{"object", object}, {"name", object_name(reader, object, named)}, {"elements", count}});
  return {{"elements", elements},
          {"objects", objects},
          {"vertices", topology.features().vertex_count()},
          {"edges", topology.features().edge_count()},
          {"triangles", topology.features().triangle_count()}};
}

/// The mesh of frame 0, with the objects that the options select. `named`: they are those that the file stores and may
/// name.
struct FirstFrame {
  FirstFrame(SequenceReader& reader, const SequenceStepper::Config& config) {
    SequenceCells cells;
    reader.read_cells(0, cells);
    if (config.objects == ObjectModel::components) ConnectedComponents(reader).assign(cells);
    topology.emplace(mesh_of(reader.point_ids(), cells), config.edge_set);
    named = config.objects == ObjectModel::stored;
  }

  std::optional<Topology> topology;
  bool named = true;
};

/// Reads all steps and adds, for each, a row to the text table and an entry to `rows`.
StepsDone read_steps(const InfoOptions& options, SequenceReader& reader, TextTable& table, nlohmann::json& rows) {
  SequenceStepper stepper(reader, options.sequence.config);
  const StepRange range = parse_steps(options.sequence.steps, stepper.step_count(), options.sequence.file);
  return run_steps("reading", range, [&](int k) {
    stepper.go_to(k);
    const MovementFacts facts = movement_facts(stepper.topology(), stepper.motion());
    const Index elements = stepper.topology().mesh().element_count();
    table.add({std::to_string(k), fmt::format("{:g}", reader.time(k)), grouped(elements),
               fmt::format("{:.4g}", facts.mean_edge), fmt::format("{:.3f}", facts.median),
               fmt::format("{:.3f}", facts.p99), fmt::format("{:.3f}", facts.largest)});
    rows.push_back({{"step", k},
                    {"time", reader.time(k)},
                    {"elements", elements},
                    {"mean_edge", facts.mean_edge},
                    {"moved_median", facts.median},
                    {"moved_p99", facts.p99},
                    {"moved_largest", facts.largest}});
  });
}

int info(const InfoOptions& options) {
  const InterruptGuard guard;
  const Report report(options.report);
  SequenceReader reader(options.sequence.file);
  nlohmann::json document = header_json(reader);
  print_header(report, reader);
  {
    const FirstFrame first(reader, options.sequence.config);
    print_mesh(report, reader, *first.topology, first.named);
    document["frame_0"] = mesh_json(reader, *first.topology, first.named);
  }
  StepsDone steps;
  if (reader.frame_count() >= 2) {
    const auto with_unit = [](const char* name, const std::string& unit) {
      return unit.empty() ? std::string(name) : fmt::format("{} [{}]", name, unit);
    };
    TextTable table({"step", with_unit("time", reader.metadata().time_unit), "elements", "mean edge",
                     "moved: median [edges]", "99 % [edges]", "largest [edges]"});
    steps = read_steps(options, reader, table, document["steps"]);
    report.print("\nsteps: distances that vertices move, in mean edges\n{}", table.text(report.width()));
  }
  document["complete"] = steps.complete();
  report.write("info", document);
  print_incomplete(steps, report.people());
  return exit_code(steps);
}

}  // namespace

void add_info_command(CLI::App& app, Action& action) {
  CLI::App* command = app.add_subcommand("info", "contents of a sequence: counts, objects, frames, movement per step");
  const auto options = std::make_shared<InfoOptions>();
  options->sequence.add_to(*command);
  options->sequence.add_objects_to(*command);
  options->report.add_to(*command);
  command->footer(
      "If a scene would have to be simulated first, the error message has the command that simulates it.\n"
      "Examples:\n  volccd info run.vtkhdf --steps 0:10\n  volccd info run.vtkhdf --motion tentative\n"
      "  volccd info run.vtkhdf --json");
  command->callback([options, &action] {
    action = [options] {
      options->sequence.file = present_sequence_file(options->sequence.file);
      return info(*options);
    };
  });
}

}  // namespace volccd
