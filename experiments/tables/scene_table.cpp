#include <volccd/experiments/tables/scene_table.hpp>

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include <volccd/core/error.hpp>
#include <volccd/core/median.hpp>
#include <volccd/experiments/scenes/sequence_statistics.hpp>
#include <volccd/experiments/tables/text_table.hpp>
#include <volccd/io/stats_json.hpp>
#include <volccd/numerics/types.hpp>

namespace volccd {

using nlohmann::json;

namespace {

/// Numbers of elements as printed in the paper.
const std::map<std::string, std::string> kPaper = {
    {"octopi", "17.6K"}, {"bullet", "11.8K-12K"}, {"airbag", "9.1K"}, {"crash", "1.2M"}, {"liver", "3,874-4,338"}};

std::uint64_t element_count(const json& step) {
  std::uint64_t sum = 0;
  for (const auto& [type, count] : step.at("elements").items()) sum += count.get<std::uint64_t>();
  return sum;
}

std::string type_names(const json& step) {
  std::string names;
  for (const auto& [type, count] : step.at("elements").items()) names += (names.empty() ? "" : ", ") + type;
  return names;
}

template <class Value>
double median_over(const json& steps, Value&& value) {
  std::vector<double> values;
  for (const json& step : steps) values.push_back(value(step));
  return median(std::move(values));
}

/// Error of the energy balance, in per cent of the initial energy plus the external work.
std::string energy_text(const json& frames) {
  double worst = 0, scale = 0;
  for (const json& frame : frames) {
    const json& energy = frame.at("energy");
    worst = std::max(worst, std::abs(energy.at("balance_error").get<double>()));
    scale = std::max(scale, energy.at("initial").get<double>() + std::abs(energy.at("external").get<double>()));
  }
  return scale > 0 ? fmt::format("{:.2f} %", 100 * worst / scale) : "-";
}

/// Energy that the time stepping and the contacts removed (negative: added), in per cent of the same sum.
std::string energy_shares(const json& frames) {
  const json& energy = frames.back().at("energy");
  double scale = 0;
  for (const json& frame : frames)
    scale = std::max(scale, frame.at("energy").at("initial").get<double>() +
                                std::abs(frame.at("energy").at("external").get<double>()));
  if (scale <= 0) return "-";
  return fmt::format("{:.1f} / {:.1f} %", 100 * energy.at("numerical").get<double>() / scale,
                     100 * energy.at("contact").get<double>() / scale);
}

/// Change of the angular momentum without the external impulses, in per cent of its greatest value.
std::string angular_drift(const json& frames) {
  const auto vector = [](const json& frame, const char* name) {
    const json& v = frame.at(name);
    return Vec3(v[0].get<double>(), v[1].get<double>(), v[2].get<double>());
  };
  const Vec3 first = vector(frames.front(), "angular_momentum") - vector(frames.front(), "angular_impulse");
  double worst = 0, scale = 0;
  for (const json& frame : frames) {
    const Vec3 now = vector(frame, "angular_momentum"), given = vector(frame, "angular_impulse");
    worst = std::max(worst, (now - given - first).norm());
    scale = std::max({scale, now.norm(), given.norm()});
  }
  return scale > 0 ? fmt::format("{:.2g} %", 100 * worst / scale) : "-";
}

/// Contacts that got a response in a substep: between objects, within one object, between adjacent elements.
std::string resisted_text(const json& frames) {
  std::string text;
  for (const char* kind : {"inter", "intra", "adjacent"}) {
    std::vector<double> values;
    for (const json& frame : frames)
      if (const double substeps = frame.at("substeps").get<double>(); substeps > 0)
        values.push_back(frame.at("responses").at(kind).get<double>() / substeps);
    text += fmt::format("{}{:.0f}", text.empty() ? "" : " / ", values.empty() ? 0 : median(std::move(values)));
  }
  return text;
}

/// Elements of rigid tools, which are among the others. Records of scenes without any may lack the number.
std::string tools_text(const json& baked) {
  return baked.is_null() ? "-" : grouped(baked.value("tool_elements", std::uint64_t{0}));
}

std::vector<std::string> row_of(const json& record) {
  const json &steps = record.at("steps"), &baked = record.at("simulation");
  const std::string name = record.at("scene");
  const auto contacts = [&](const char* kind) {
    return grouped(static_cast<std::uint64_t>(
        median_over(steps, [&](const json& m) { return m.at("contacts").at(kind).get<double>(); })));
  };
  double changed = 0, fastest = 0;
  for (const json& step : steps) {
    changed += step.at("added").get<double>();
    fastest = std::max(fastest, step.at("moved_edges").at("p99").get<double>());
  }
  const auto paper = kPaper.find(name);
  const double usual = median_over(steps, [](const json& m) { return m.at("moved_edges").at("p99").get<double>(); });
  std::vector<std::string> row = {name,
                                  type_names(steps.back()),
                                  grouped(element_count(steps.front())),
                                  grouped(element_count(steps.back())),
                                  tools_text(baked),
                                  paper == kPaper.end() ? "-" : paper->second,
                                  std::to_string(steps.size() + 1),
                                  contacts("inter"),
                                  contacts("intra"),
                                  contacts("adjacent"),
                                  grouped(static_cast<std::uint64_t>(median_over(
                                      steps, [](const json& m) { return m.at("contacts_at_start").get<double>(); }))),
                                  fmt::format("{:.2f} ({:.2f})", usual, fastest),
                                  fmt::format("{:.1f}", changed / static_cast<double>(steps.size()))};
  row.push_back(baked.is_null() ? "-" : resisted_text(baked.at("frames")));
  row.push_back(baked.is_null() ? "-" : duration(baked.at("seconds").get<double>()));
  row.push_back(baked.is_null() ? "-" : energy_text(baked.at("frames")));
  row.push_back(baked.is_null() ? "-" : energy_shares(baked.at("frames")));
  row.push_back(baked.is_null() ? "-" : angular_drift(baked.at("frames")));
  return row;
}

}  // namespace

std::optional<json> scene_record(const std::string& name, const std::string& sequence, const std::string& bake_record,
                                 Executor& executor,
                                 const std::function<bool(std::size_t done, std::size_t steps)>& go_on) {
  json record = read_json_file(bake_record);
  SequenceReader reader(sequence);
  const std::size_t steps = static_cast<std::size_t>(reader.frame_count() - 1);
  bool stopped = false;
  const std::vector<StepStatistics> statistics = sequence_statistics(reader, executor, [&](int done) {
    stopped = !go_on(static_cast<std::size_t>(done), steps);
    return !stopped;
  });
  if (stopped) return std::nullopt;
  return json{
      {"scene", name}, {"machine", machine_facts()}, {"simulation", std::move(record)}, {"steps", to_json(statistics)}};
}

TitledTable scene_table(const std::vector<json>& records) {
  TextTable table({"scene", "elements", "first", "last", "tools", "paper", "frames", "inter", "intra", "adjacent",
                   "at t = 0", "moved, edges", "new elements", "resisted", "computed in", "energy error",
                   "numerical / contacts", "angular drift"});
  for (const json& record : records) table.add(row_of(record));
  return {"", table,
          "tools: of these elements, those of objects that no force moves; contacts: median over the steps, between "
          "objects, within one, of adjacent elements; at t = 0: of those, "
          "touching at the start already; moved: 99th percentile of the vertices, median (greatest) over the "
          "motions; new elements: per step; resisted: contacts that met an impulse in a substep of the simulation "
          "(inter / intra / adjacent), median over the frames: what it keeps apart does not touch in the file; "
          "numerical / contacts: energy that the time stepping and that contacts took out (negative: put in), to the "
          "end, as "
          "shares of what there was and came from outside; angular drift: change of the angular momentum that no "
          "impulse from outside explains, of the greatest that there was\n"};
}

}  // namespace volccd
