#include <volccd/capi/arguments.hpp>

namespace volccd::capi {

namespace {

PairScope pairs_of(std::int32_t pairs) {
  switch (pairs) {
    case VOLCCD_PAIRS_ALL: return PairScope::all;
    case VOLCCD_PAIRS_INTER: return PairScope::inter;
    case VOLCCD_PAIRS_INTRA: return PairScope::intra;
    default: throw ArgumentError(fmt::format("options.pairs: {} is none of VOLCCD_PAIRS_ALL, _INTER, _INTRA", pairs));
  }
}

EdgeSet edges_of(std::int32_t edges) {
  switch (edges) {
    case VOLCCD_EDGES_TRIANGULATED: return EdgeSet::triangulated;
    case VOLCCD_EDGES_POLYTOPE: return EdgeSet::polytope;
    default:
      throw ArgumentError(fmt::format("options.edges: {} is none of VOLCCD_EDGES_TRIANGULATED, _POLYTOPE", edges));
  }
}

ListConfig lists_of(const volccd_options& options) {
  switch (options.lists) {
    case VOLCCD_LISTS_NEVER: return {};
    case VOLCCD_LISTS_AUTO: return {.use = ListConfig::Use::automatic};
    case VOLCCD_LISTS_ALWAYS:
      return {.use = ListConfig::Use::always, .budget = options.list_budget, .steps = options.list_steps};
    default:
      throw ArgumentError(
          fmt::format("options.lists: {} is none of VOLCCD_LISTS_NEVER, _AUTO, _ALWAYS", options.lists));
  }
}

ObjectFilter filter_of(const volccd_options& options) {
  ObjectFilter filter(pairs_of(options.pairs));
  const std::size_t n = size_of("options.excluded_count", options.excluded_count, 2 * sizeof(std::int32_t));
  const auto excluded = array_of("options.excluded", options.excluded, 2 * n);
  for (std::size_t i = 0; i < n; ++i) filter.exclude(excluded[2 * i], excluded[2 * i + 1]);
  return filter;
}

std::vector<std::string> settings_of(const volccd_options& options) {
  const std::size_t n = size_of("options.setting_count", options.setting_count, sizeof(const char*));
  std::vector<std::string> settings;
  for (const char* const setting : array_of("options.settings", options.settings, n)) {
    if (!setting) throw ArgumentError(fmt::format("options.settings[{}] is NULL", settings.size()));
    settings.emplace_back(setting);
  }
  return settings;
}

/// Empty if it is NULL.
template <class T>
std::span<const T> optional_array(const T* data, std::size_t size) {
  return data ? std::span<const T>(data, size) : std::span<const T>();
}

}  // namespace

std::span<const Vec3> points_of(const char* name, const double* values, std::size_t n) {
  static_assert(sizeof(Vec3) == 3 * sizeof(double) && alignof(Vec3) == alignof(double));
  return {reinterpret_cast<const Vec3*>(array_of(name, values, 3 * n).data()), n};
}

Index vertex_count_of(const char* name, std::int64_t count, Index present, bool thickened) {
  const std::size_t n = size_of(name, count), limit = (kNone - 1) / (thickened ? 3u : 1u);
  if (n > limit || n + present > limit)
    throw ArgumentError(fmt::format("{}: a mesh with {} vertices has more than {}", name, n + present, limit));
  return static_cast<Index>(n);
}

CellArrays cells_of(const char* name, const volccd_cells& cells) {
  const auto size = [name](const char* member, std::int64_t n) {
    return size_of(fmt::format("{}.{}", name, member).c_str(), n, sizeof(std::int64_t));
  };
  const auto array = [name](const char* member, const auto* data, std::size_t n) {
    return array_of(fmt::format("{}.{}", name, member).c_str(), data, n);
  };
  static constexpr std::int64_t kOffsetsOfNone[] = {0};
  const std::size_t n = size("count", cells.count);
  const std::int64_t* const offsets = n == 0 && !cells.offsets ? kOffsetsOfNone : cells.offsets;
  return {.types = array("types", cells.types, n),
          .offsets = array("offsets", offsets, n + 1),
          .connectivity = array("connectivity", cells.connectivity, size("connectivity_size", cells.connectivity_size)),
          .ids = optional_array(cells.ids, n),
          .objects = optional_array(cells.objects, n),
          .face_offsets = optional_array(cells.face_offsets, n + 1),
          .faces = array("faces", cells.faces, size("faces_size", cells.faces_size))};
}

std::span<const double> thickness_of(const char* name, const volccd_cells& cells) {
  const std::size_t n = size_of(fmt::format("{}.count", name).c_str(), cells.count, sizeof(double));
  return optional_array(cells.thickness, n);
}

DetectorConfig config_of(const volccd_options& options) {
  if (options.threads < 0) throw ArgumentError(fmt::format("options.threads: {} is negative", options.threads));
  DetectorConfig config{.settings = settings_of(options),
                        .threads = static_cast<unsigned>(options.threads),
                        .separation = options.separation,
                        .filter = filter_of(options),
                        .lists = lists_of(options),
                        .edge_set = edges_of(options.edges)};
  if (options.pipeline) config.pipeline = options.pipeline;
  return config;
}

Request request_of(std::int32_t flags) {
  constexpr std::int32_t known = VOLCCD_STEP_FIRST | VOLCCD_STEP_INITIAL_OVERLAPS | VOLCCD_STEP_ENDS;
  if ((flags & ~known) != 0) throw ArgumentError(fmt::format("flags: {} is not a sum of VOLCCD_STEP_...", flags));
  return {.query = (flags & VOLCCD_STEP_FIRST) != 0 ? Query::first : Query::all,
          .initial_overlaps = (flags & VOLCCD_STEP_INITIAL_OVERLAPS) != 0,
          .ends = (flags & VOLCCD_STEP_ENDS) != 0};
}

}  // namespace volccd::capi
