#include <volccd/experiments/scenes/simulated/frame_store.hpp>

#include <cerrno>
#include <cstring>
#include <fstream>

#include <volccd/core/error.hpp>
#include <volccd/io/output_file.hpp>
#include <volccd/io/sequence/writer.hpp>

namespace volccd {

namespace {

void archive_frame(simulation::Archive& archive, Frame& frame) {
  archive(frame.time);
  archive(frame.vertex_ids);
  archive(frame.positions);
  archive(frame.velocities);
  archive(frame.start_positions);
  archive(frame.query_start);
  archive(frame.query_end);
  archive(frame.query_separation);
  archive(frame.cells.types);
  archive(frame.cells.offsets);
  archive(frame.cells.connectivity);
  archive(frame.cells.objects);
  archive(frame.cells.ids);
  archive(frame.cells.face_offsets);
  archive(frame.cells.faces);
  archive(frame.thickness);
  archive(frame.counts);
  // Ledger contains Vec3, which has constructors, so that archive() takes it only as an element of a vector.
  std::vector<simulation::Ledger> ledger{frame.ledger};
  archive(ledger);
  if (ledger.size() != 1) throw InputError("frame", "ledger", "is not one record");
  frame.ledger = ledger[0];
  archive(frame.seconds);
}

/// For each vertex of the last frame that the first frame does not have: its position before it existed. Index 0 is
/// that of vertex `first`.
struct Births {
  std::size_t first = 0;
  std::vector<Vec3> places;
  std::vector<std::int64_t> ids;  ///< of all vertices
};

Births find_births(const std::vector<std::string>& files) {
  Births births;
  for (std::size_t k = 0; k < files.size(); ++k) {
    Frame frame = read_frame(files[k]);
    if (k == 0) births.first = frame.vertex_ids.size();
    const std::size_t fresh = k == 0 ? 0 : frame.vertex_ids.size() - births.ids.size();
    if (frame.vertex_ids.size() < births.ids.size() || frame.start_positions.size() != fresh)
      throw InputError(files[k], "start positions", "do not belong to the vertices that are new");
    births.places.insert(births.places.end(), frame.start_positions.begin(), frame.start_positions.end());
    births.ids = std::move(frame.vertex_ids);
  }
  return births;
}

}  // namespace

Frame capture_frame(simulation::Simulation& simulation, Index vertices_before) {
  const Mesh& mesh = simulation.topology().mesh();
  Frame frame;
  frame.time = simulation.time();
  frame.vertex_ids.assign(mesh.vertex_ids().begin(), mesh.vertex_ids().end());
  frame.positions.assign(simulation.positions().begin(), simulation.positions().end());
  frame.velocities.assign(simulation.velocities().begin(), simulation.velocities().end());
  frame.start_positions.assign(simulation.start_positions().begin() + vertices_before,
                               simulation.start_positions().end());
  if (const std::optional<simulation::AskedQuery> query = simulation.last_query()) {
    frame.query_start.assign(query->start.begin(), query->start.end());
    frame.query_end.assign(query->end.begin(), query->end.end());
    frame.query_separation = query->separation;
  }
  frame.cells = cells_of(mesh);
  bool shells = false;
  for (const ElementType type : frame.cells.types) shells = shells || is_shell(type);
  for (std::int32_t& object : frame.cells.objects) ++object;
  if (shells) {
    const std::vector<double> thickness = simulation.thickness();
    for (Index o = 0; o < mesh.element_slots(); ++o)
      if (mesh.is_live(o)) frame.thickness.push_back(thickness[o]);
  }
  frame.counts = simulation.drain_counts();
  frame.ledger = simulation.ledger();
  return frame;
}

void write_checkpoint(const std::string& file, FunctionRef<void(std::ostream&)> write) {
  OutputFile target(file, "it is read back later");
  {
    std::ofstream out(target.temporary(), std::ios::binary);
    errno = 0;
    try {
      write(out);
    } catch (const InputError&) {
      if (out) throw;
    }
    out.flush();
    if (!out) throw InputError(file, "", std::string("cannot be written: ") + std::strerror(errno));
  }
  target.commit();
}

void write_frame(const std::string& file, const Frame& frame) {
  write_checkpoint(file, [&](std::ostream& out) {
    simulation::Archive archive(out);
    Frame copy = frame;
    archive_frame(archive, copy);
  });
}

Frame read_frame(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw InputError(file, "", "cannot be opened");
  Frame frame;
  simulation::Archive archive(in);
  archive_frame(archive, frame);
  return frame;
}

void write_frames(const std::vector<std::string>& frame_files, const std::string& file, SequenceMetadata metadata) {
  const Births births = find_births(frame_files);
  SequenceWriter writer(file, births.ids, std::move(metadata));
  for (const std::string& name : frame_files) {
    Frame frame = read_frame(name);
    const auto later = births.places.begin() + static_cast<std::ptrdiff_t>(frame.positions.size() - births.first);
    for (std::vector<Vec3>* places : {&frame.positions, &frame.query_start, &frame.query_end})
      if (!places->empty()) places->insert(places->end(), later, births.places.end());
    frame.velocities.resize(births.ids.size(), Vec3::Zero());
    writer.write_frame(frame.time, frame.positions, frame.cells,
                       {frame.velocities, frame.thickness, frame.query_start, frame.query_end, frame.query_separation});
  }
  writer.finish();
}

}  // namespace volccd
