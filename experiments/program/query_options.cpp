#include <volccd/experiments/program/query_options.hpp>

#include <charconv>

#include <fmt/format.h>

namespace volccd {

namespace {

/// The number in `text`, or `fallback` if there is none; false if it is something else.
bool parse_bound(std::string_view text, int fallback, int& value) {
  value = fallback;
  if (text.empty()) return true;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

}  // namespace

StepRange parse_steps(const std::string& text, int motions, const std::string& file) {
  StepRange range{0, motions};
  const std::size_t colon = text.find(':');
  bool good = true;
  if (colon == std::string::npos) {
    if (!text.empty()) {
      good = parse_bound(text, 0, range.begin);
      range.end = range.begin + 1;
    }
  } else {
    good = parse_bound(std::string_view(text).substr(0, colon), 0, range.begin) &&
           parse_bound(std::string_view(text).substr(colon + 1), motions, range.end);
  }
  if (!good) throw ConfigError(fmt::format("--steps: '{}' is not A:B, A:, :B or K", text));
  if (motions == 0) throw InputError(file, "VTKHDF/Steps", "has one step only: no motion to look at");
  if (range.begin < 0 || range.begin >= range.end || range.end > motions)
    throw ConfigError(fmt::format("--steps: {} is not within the motions 0:{} of {}", text, motions, file));
  return range;
}

void add_threads_option(CLI::App& command, unsigned& threads, const std::string& purpose) {
  command.add_option("--threads", threads, purpose + "0: as many as the machine has; more are never made")
      ->check(CLI::Range(0u, kMaxThreads))
      ->type_name("N")
      ->capture_default_str();
}

void SequenceOptions::add_to(CLI::App& command) {
  command.add_option("FILE", file, "sequence (VTKHDF), or the name of a scene")->required()->type_name("");
  command.add_option("--steps", steps, "motions k -> k+1 with A <= k < B; K alone: one motion")->type_name("A:B");
  command.add_option("--shells", shells, "triangles and quads as surfaces, or thickened by their thickness")
      ->check(CLI::IsMember({"surface", "solid"}))
      ->capture_default_str();
  command.add_option("--edges", edges, "with the diagonals of faces (complete), or without (the paper's counts)")
      ->check(CLI::IsMember({"triangulated", "polytope"}))
      ->capture_default_str();
  command
      .add_option("--motion", motion,
                  "on straight lines, or with constant acceleration (by stored velocities, else by three steps)")
      ->check(CLI::IsMember({"linear", "quadratic"}))
      ->capture_default_str();
}

SequenceStepper::Config SequenceOptions::stepper() const {
  SequenceStepper::Config config;
  config.edge_set = edges == "polytope" ? EdgeSet::polytope : EdgeSet::triangulated;
  config.shells = shells == "solid" ? ShellModel::solid : ShellModel::surface;
  config.motion = motion == "quadratic" ? MotionModel::quadratic : MotionModel::linear;
  return config;
}

void QueryOptions::add_to(CLI::App& command) {
  command.add_option("--pairs", pairs, "contacts of all pairs, between objects, or within objects")
      ->check(CLI::IsMember({"all", "inter", "intra"}))
      ->capture_default_str();
  command.add_option("--separation", separation, "contact when the distance reaches this")
      ->check(CLI::NonNegativeNumber)
      ->type_name("D");
  add_threads_option(command, threads);
}

ObjectFilter QueryOptions::filter() const {
  return ObjectFilter(pairs == "inter" ? PairScope::inter : pairs == "intra" ? PairScope::intra : PairScope::all);
}

}  // namespace volccd
