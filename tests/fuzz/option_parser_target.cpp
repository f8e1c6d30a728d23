#include <volccd/io/sequence/metadata.hpp>
#include <volccd/pipelines/pipeline.hpp>

#include "targets.hpp"

namespace volccd::fuzz {

namespace {

/// A stage either accepts the options or throws ConfigError, and does the same when called again.
template <class Stage>
void make_all(const Registry& registry, const OptionValues& values) {
  for (const StageDescriptor<Stage>& stage : registry.stages<Stage>()) {
    bool accepted[2];
    for (bool& good : accepted) {
      try {
        good = stage.make(values) != nullptr;
        if (!good) promise_broken("no stage " + stage.name);
      } catch (const ConfigError&) {
        good = false;
      }
    }
    if (accepted[0] != accepted[1]) promise_broken("stage " + stage.name + " takes options now and then");
  }
}

void apply(const Registry& registry, PipelineSpec& spec, const std::string& line) {
  try {
    registry.apply_setting(spec, line);
  } catch (const ConfigError&) {
  }
  const std::size_t equals = line.find('=');
  if (equals == std::string::npos) return;
  const OptionValues values = {{line.substr(0, equals), line.substr(equals + 1)}};
  make_all<BroadPhase>(registry, values);
  make_all<ElementCulling>(registry, values);
  make_all<Assignment>(registry, values);
  make_all<OrphanSource>(registry, values);
  make_all<Flood>(registry, values);
  make_all<FeatureFilter>(registry, values);
  make_all<NarrowPhase>(registry, values);
}

/// The attribute `Parts` is read as it was written.
void object_names(const std::string& text) {
  try {
    const auto names = parse_object_names("text", text);
    if (parse_object_names("text", format_object_names(names)) != names) promise_broken("part names change: " + text);
  } catch (const InputError&) {
  }
}

}  // namespace

void option_parser(Bytes bytes) {
  static const Registry registry = Registry::standard();
  std::string text(bytes.begin(), bytes.end());
  object_names(text);
  PipelineSpec spec = registry.pipelines()[bytes.empty() ? 0 : bytes[0] % registry.pipelines().size()];
  int lines = 0;
  for (std::size_t begin = 0; begin < text.size() && lines < 16; ++lines) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    apply(registry, spec, text.substr(begin, end - begin));
    begin = end + 1;
  }
  try {
    const Pipeline pipeline(registry, spec);
  } catch (const ConfigError&) {
  }
}

}  // namespace volccd::fuzz
