#include <volccd/program/query_options.hpp>

#include <charconv>
#include <cstdio>
#include <optional>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include <volccd/program/command_line.hpp>

namespace volccd {

namespace {

/// The number in `text`, or `fallback` if there is none; false if it is something else.
bool parse_bound(std::string_view text, int fallback, int& value) {
  value = fallback;
  if (text.empty()) return true;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

/// Diagonal of the box around the control points of all vertices in use.
double scene_diagonal(const Topology& topology, const Motion& motion) {
  Eigen::AlignedBox3d box;
  const Features& features = topology.features();
  for (Index v = 0; v < features.vertex_slots(); ++v)
    if (!features.vertex_elements(v).empty())
      for (int i = 0; i <= motion.degree(); ++i) box.extend(motion.point(v, i));
  return box.isEmpty() ? 0 : box.sizes().stableNorm();
}

/// The object of all elements if all have the same one.
std::optional<std::int32_t> only_object(const Mesh& mesh) {
  std::optional<std::int32_t> object;
  for (Index o = 0; o < mesh.element_slots(); ++o) {
    if (!mesh.is_live(o)) continue;
    if (object && *object != mesh.object(o)) return std::nullopt;
    object = mesh.object(o);
  }
  return object;
}

}  // namespace

StepRange parse_steps(const std::string& text, int count, const std::string& file, std::string_view unit) {
  StepRange range{0, count};
  const std::size_t colon = text.find(':');
  bool good = true;
  if (colon == std::string::npos) {
    if (!text.empty()) {
      good = parse_bound(text, 0, range.begin);
      range.end = range.begin + 1;
    }
  } else {
    good = parse_bound(std::string_view(text).substr(0, colon), 0, range.begin) &&
           parse_bound(std::string_view(text).substr(colon + 1), count, range.end);
  }
  if (!good) throw ConfigError(fmt::format("--{}s: '{}' is not A:B, A:, :B or K", unit, text));
  if (count == 0) throw InputError(file, "VTKHDF/Steps", "has only one frame, and therefore no step");
  if (range.begin < 0 || range.begin >= range.end || range.end > count)
    throw ConfigError(fmt::format("--{0}s: {1} is not within the {0}s 0:{2} of {3}", unit, text, count, file));
  return range;
}

void add_threads_option(CLI::App& command, unsigned& threads, const std::string& purpose) {
  command.add_option("--threads", threads, purpose + "0: as many as the machine has, which is also the limit")
      ->check(CLI::Range(0u, kMaxThreads))
      ->type_name("N")
      ->capture_default_str();
}

void SequenceOptions::add_to(CLI::App& command) {
  command.add_option("FILE", file, "sequence (VTKHDF), or the name of a scene")->required()->type_name("");
  command.add_option("--steps", steps, "steps k with A <= k < B, from frame k to frame k+1; K alone: one step")
      ->type_name("A:B");
  add_choice(command, "--shells", config.shells, "triangles and quads as surfaces, or thickened by their thickness");
  add_choice(command, "--edges", config.edge_set,
             "with the diagonals of faces (complete), or without (the paper's counts)");
  add_choice(command, "--motion", config.motion,
             "linear: straight lines to the next frame; quadratic: constant acceleration, from stored velocities "
             "or else from three frames; tentative: to x + h v, with the velocities and the cells of the first "
             "frame; query: the last query of the simulation, if the file has it");
}

void SequenceOptions::add_objects_to(CLI::App& command) {
  add_choice(command, "--objects", config.objects,
             "objects are those that the file stores (PartId), or connected components (cells that share a vertex "
             "at any frame belong to one object)");
}

void QueryOptions::add_to(CLI::App& command) {
  add_choice(command, "--pairs", pairs, "contacts of all pairs, between objects, or within objects");
  command
      .add_option("--separation", separation,
                  "distance at which features are in contact; at most the diagonal of the box around the scene; "
                  "default: 0, or with --motion query the separation of the query")
      ->check(at_least(0))
      ->type_name("D");
  command
      .add_option("--shell-neighbours", shell_neighbours,
                  "whether contacts of thickened shells between features with copies of the same shell vertex are left "
                  "out or kept; default: leave-out with --shells solid")
      ->check(one_of({"leave-out", "keep"}));
  add_threads_option(command, threads);
}

bool QueryOptions::leaves_out_shell_neighbours(const SequenceOptions& sequence) const {
  const bool solid = sequence.config.shells == ShellModel::solid;
  if (shell_neighbours == "leave-out" && !solid)
    throw ConfigError("--shell-neighbours: leave-out is for thickened shells: add --shells solid");
  return solid && shell_neighbours != "keep";
}

void QueryOptions::check(const SequenceStepper& stepper) const {
  if (const double diagonal = scene_diagonal(stepper.topology(), stepper.motion());
      !(separation_in(stepper) <= diagonal))
    throw ConfigError(
        fmt::format("--separation: {:g} is greater than the diagonal {:g} of the box around the scene in step {}: "
                    "all features would be in contact",
                    separation_in(stepper), diagonal, stepper.current()));
  if (pairs != PairScope::inter) return;
  if (const std::optional<std::int32_t> object = only_object(stepper.topology().mesh()))
    fmt::print(stderr,
               "volccd: warning: all elements of step {} belong to object {}, so there are no pairs between objects; "
               "--objects components makes each connected component an object\n",
               stepper.current(), *object);
}

}  // namespace volccd
