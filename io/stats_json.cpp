#include <volccd/io/stats_json.hpp>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <thread>

#include <sched.h>
#include <sys/utsname.h>

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <volccd/io/build_facts.hpp>

namespace volccd {

using nlohmann::json;

namespace {

std::string cpu_name() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);)
    if (line.rfind("model name", 0) == 0) return line.substr(line.find(':') + 2);
  return "unknown";
}

/// Mean number of running or waiting processes over the last minute; null if the system does not report it.
json load_average() {
  double load = 0;
  std::ifstream file("/proc/loadavg");
  return file >> load ? json(load) : json(nullptr);
}

/// Name and release of the operating system, "Linux 6.1.0".
std::string kernel() {
  utsname names{};
  return uname(&names) == 0 ? fmt::format("{} {}", names.sysname, names.release) : "unknown";
}

/// How many processors this process may run on: fewer than there are if it is pinned. Null if the system does not say.
json allowed_cores() {
  cpu_set_t set;
  return sched_getaffinity(0, sizeof set, &set) == 0 ? json(CPU_COUNT(&set)) : json(nullptr);
}

json to_json(const StageChoice& choice) {
  json options = json::object();
  for (const auto& [name, value] : choice.options) options[name] = value;
  return {{"name", choice.name}, {"options", options}};
}

}  // namespace

json machine_facts() {
  const BuildFacts build = build_facts();
  return {{"version", build.version},
          {"commit", build.commit},
          {"compiler", "g++ " __VERSION__},
          {"build_type", build.build_type},
          {"flags", build.flags},
          {"cpu", cpu_name()},
          {"cores", std::thread::hardware_concurrency()},
          {"allowed_cores", allowed_cores()},
          {"kernel", kernel()},
          {"load", load_average()},
          {"date", fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)))}};
}

json to_json(const Pipeline& pipeline) {
  json record = to_json(pipeline.spec());
  record["guarantee"] = to_string(pipeline.guarantee());
  return record;
}

json to_json(const PipelineSpec& spec) {
  json culling = json::array(), filters = json::array();
  for (const StageChoice& choice : spec.element_culling) culling.push_back(to_json(choice));
  for (const StageChoice& choice : spec.feature_filters) filters.push_back(to_json(choice));
  return {{"name", spec.name},
          {"broad_phase", to_json(spec.broad_phase)},
          {"element_culling", culling},
          {"assignment", to_json(spec.assignment)},
          {"orphans", spec.orphans ? to_json(*spec.orphans) : json(nullptr)},
          {"flood", spec.flood ? to_json(*spec.flood) : json(nullptr)},
          {"feature_filters", filters},
          {"narrow_phase", to_json(spec.narrow_phase)}};
}

json to_json(const Statistics& s) {
  json stages = json::array();
  for (const StageStatistics& stage : s.stages) {
    json counters = json::object();
    for (const StageCounter& counter : stage.counters) counters[counter.name] = counter.value;
    stages.push_back({{"role", stage.role},
                      {"name", stage.name},
                      {"in", stage.in},
                      {"out", stage.out},
                      {"prepare_seconds", stage.prepare_seconds},
                      {"seconds", stage.seconds},
                      {"counters", counters}});
  }
  json result;
  visit_values(s, [&](const char* name, auto value) { result[name] = value; });
  if (!std::isfinite(s.earliest_toi)) result["earliest_toi"] = nullptr;
  result["stages"] = stages;
  return result;
}

nlohmann::json read_json_file(const std::string& path) {
  if (path.empty()) return nullptr;
  std::ifstream in(path);
  nlohmann::json record = nlohmann::json::parse(in, nullptr, false);
  if (record.is_discarded()) throw InputError(path, "", "is not there or no JSON");
  return record;
}

}  // namespace volccd
