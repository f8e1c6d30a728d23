#include <volccd/experiments/scenes/scene.hpp>

#include <numeric>

#include <volccd/core/error.hpp>
#include <volccd/core/suggest.hpp>
#include <volccd/experiments/scenes/builtin.hpp>
#include <volccd/experiments/scenes/deform.hpp>
#include <volccd/io/sequence/reader.hpp>
#include <volccd/io/sequence/writer.hpp>

namespace volccd {

namespace {

std::vector<std::int64_t> first_ids(Index n) {
  std::vector<std::int64_t> ids(n);
  std::iota(ids.begin(), ids.end(), 0);
  return ids;
}

}  // namespace

StepsDone write_scene(const Scene& scene, const std::string& file, const std::function<bool(int done)>& go_on) {
  StepsDone steps{0, 0, scene.frames(), "", "frame"};
  SequenceWriter writer(file, first_ids(scene.vertex_count()), scene.metadata());
  std::vector<Vec3> points;
  SequenceCells cells;
  for (int frame = 0; frame < scene.frames(); ++frame) {
    if (go_on && !go_on(frame)) {
      steps.stopped_by = "interrupted";
      break;
    }
    scene.positions(frame, points);
    scene.cells(frame, cells);
    writer.write_frame(scene.time(frame), points, cells);
    steps.done = frame + 1;
  }
  if (steps.done > 0) writer.finish(steps.complete() ? std::string() : steps.text());
  return steps;
}

Mesh scene_mesh(const Scene& scene, int frame) {
  SequenceCells cells;
  scene.cells(frame, cells);
  return mesh_of(first_ids(scene.vertex_count()), cells);
}

Shape shape_from_file(const std::string& file, int frame) {
  SequenceReader reader(file);
  if (frame < 0 || frame >= reader.frame_count())
    throw ConfigError(file + " has frames 0 .. " + std::to_string(reader.frame_count() - 1) + ", not " +
                      std::to_string(frame));
  std::vector<Vec3> points;
  SequenceCells cells;
  reader.read_points(frame, points);
  reader.read_cells(frame, cells);
  std::vector<Index> slot(points.size(), kNone);
  for (const Index v : cells.connectivity) slot[v] = 0;
  Shape shape;
  for (std::size_t v = 0; v < points.size(); ++v)
    if (slot[v] != kNone) {
      slot[v] = static_cast<Index>(shape.positions.size());
      shape.positions.push_back(points[v]);
    }
  for (std::size_t i = 0; i < cells.size(); ++i) {
    ElementSpec spec = cells.spec(i);
    spec.renumber([&](Index v) { return slot[v]; });
    shape.elements.push_back(std::move(spec));
  }
  return shape;
}

const std::vector<SceneDescriptor>& scenes() {
  static const std::vector<SceneDescriptor> all = {describe_deform(), describe_builtin()};
  return all;
}

std::unique_ptr<Scene> make_scene(const std::string& name, const OptionValues& values, const Shape* mesh) {
  std::string known;
  for (const SceneDescriptor& scene : scenes()) {
    known += (known.empty() ? "" : ", ") + scene.name;
    if (scene.name != name) continue;
    if (scene.needs_mesh != (mesh != nullptr))
      throw ConfigError("scene " + name + (mesh ? " takes no mesh" : " needs a mesh to work on"));
    return scene.make(values, mesh);
  }
  throw ConfigError("no scene is called \"" + name + "\"; there are: " + known + did_you_mean(name, known));
}

}  // namespace volccd
