#include <algorithm>
#include <cstdio>
#include <map>
#include <optional>
#include <string>

#include <fmt/format.h>

#include <volccd/experiments/tables/text_table.hpp>
#include <volccd/mesh/sequence/reader.hpp>
#include <volccd/program/commands.hpp>
#include <volccd/program/progress.hpp>
#include <volccd/program/query_options.hpp>
#include <volccd/program/scene_files.hpp>
#include <volccd/program/step_loop.hpp>

namespace volccd {

namespace {

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
struct MotionFacts {
  double mean_edge = 0, median = 0, p99 = 0, largest = 0;
};

MotionFacts motion_facts(const Topology& topology, const Motion& motion) {
  MotionFacts facts;
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

void print_header(SequenceReader& reader) {
  const SequenceMetadata& about = reader.metadata();
  fmt::print("{}\n", reader.file());
  const auto line = [](const char* name, const std::string& value) {
    if (!value.empty()) fmt::print("  {:<9} {}\n", name, value);
  };
  line("title", about.title);
  line("source", about.source);
  line("license", about.license);
  line("units", about.units);
  line("time unit", about.time_unit);
  line("INCOMPLETE", about.incomplete);
  line("steps", fmt::format("{}, times {:g} to {:g}", reader.step_count(), reader.time(0),
                            reader.time(reader.step_count() - 1)));
  line("points", grouped(reader.point_count()));
  line("arrays", std::string(reader.has_velocity() ? "velocity " : "") + (reader.has_thickness() ? "thickness" : ""));
}

constexpr std::size_t kPartsShown = 40;

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
    text += fmt::format("{}{} {} as {}", text.empty() ? "" : ", ", grouped(count),
                        named_count(types.first, count), named_count(types.second, count));
  return text;
}

/// `named`: whether the objects are the parts that the file names.
void print_mesh(const SequenceReader& reader, const Topology& topology, bool named) {
  const Census counts = census(topology.mesh());
  const Features& features = topology.features();
  fmt::print("\nstep 0\n");
  for (const auto& [type, count] : counts.types) fmt::print("  {:<12} {:>10}\n", to_string(type), grouped(count));
  if (const std::string text = collapsed_text(reader); !text.empty())
    fmt::print("  nodes repeat, read as: {}\n", text);
  std::size_t shown = 0;
  for (const auto& [object, count] : counts.objects) {
    if (++shown > kPartsShown) continue;
    const auto& names = reader.metadata().part_names;
    const auto name = names.find(object);
    fmt::print("  {:<12} {:>10}  {}\n", fmt::format("{} {}", named ? "part" : "component", object), grouped(count),
               name == names.end() || !named ? "" : name->second);
  }
  if (shown > kPartsShown) fmt::print("  and {} more\n", grouped(shown - kPartsShown));
  fmt::print("  {:<12} {:>10}\n  {:<12} {:>10}\n  {:<12} {:>10}\n", "vertices used", grouped(features.vertex_count()),
             "edges", grouped(features.edge_count()), "triangles", grouped(features.triangle_count()));
}

int info(const SequenceOptions& options) {
  SequenceReader reader(options.file);
  print_header(reader);
  SequenceCells cells;
  const SequenceStepper::Config config = options.stepper();
  const bool components = config.parts == PartModel::components;
  std::optional<ConnectedParts> connected;
  if (components) connected.emplace(reader);
  reader.read_cells(0, cells);
  if (connected) connected->assign(cells);
  print_mesh(reader, Topology(mesh_of(reader.point_ids(), cells), config.edge_set), !components);
  if (reader.step_count() < 2) return kDone;

  SequenceStepper stepper(reader, config);
  const StepRange range = parse_steps(options.steps, stepper.motion_count(), options.file);
  TextTable table({"motion", "time", "elements", "mean edge", "moved: median", "99 %", "largest"});
  const InterruptGuard guard;
  const StepsDone steps = run_steps("reading, step", range, [&](int k) {
    stepper.go_to(k);
    const MotionFacts facts = motion_facts(stepper.topology(), stepper.motion());
    table.add({std::to_string(k), fmt::format("{:g}", reader.time(k)),
               grouped(stepper.topology().mesh().element_count()), fmt::format("{:.4g}", facts.mean_edge),
               fmt::format("{:.3f}", facts.median), fmt::format("{:.3f}", facts.p99),
               fmt::format("{:.3f}", facts.largest)});
  });
  fmt::print("\nmotions (distances moved in mean edges)\n{}", table.text());
  print_incomplete(steps, stdout);
  return exit_code(steps);
}

}  // namespace

void add_info_command(CLI::App& app, Action& action) {
  CLI::App* command = app.add_subcommand("info", "what is in a sequence: counts, parts, steps, motion per step");
  const auto options = std::make_shared<SequenceOptions>();
  options->add_to(*command);
  options->add_parts_to(*command);
  command->footer("Examples:\n  volccd info run.vtkhdf --steps 0:10\n  volccd info run.vtkhdf --motion tentative");
  command->callback([options, &action] {
    action = [options] {
      options->file = sequence_file(options->file);
      return info(*options);
    };
  });
}

}  // namespace volccd
