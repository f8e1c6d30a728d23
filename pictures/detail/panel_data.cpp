#include <volccd/pictures/detail/panel_data.hpp>

#include <algorithm>
#include <filesystem>
#include <utility>

#include <fmt/format.h>

#include <volccd/core/error.hpp>
#include <volccd/io/sequence/reader.hpp>
#include <volccd/mesh/shells.hpp>

namespace volccd::detail {

namespace {

class PanelReader {
 public:
  PanelReader(const PicturePanel& panel, const PictureConfig& config)
      : panel_(panel), config_(config), reader_(panel.file) {
    if (panel.frame < 0 || panel.frame >= reader_.frame_count())
      throw ConfigError(fmt::format("--frames: {} is not within the frames 0:{} of {}", panel.frame,
                                    reader_.frame_count(), panel.file));
  }

  PanelData read() {
    PanelData data;
    data.object_names = reader_.metadata().object_names;
    reader_.read_cells(0, data.all);
    data.objects.insert(data.all.objects.begin(), data.all.objects.end());
    if (!reader_.same_cells(0, panel_.frame)) reader_.read_cells(panel_.frame, data.all);
    data.objects.insert(data.all.objects.begin(), data.all.objects.end());
    reader_.read_points(panel_.frame, data.points);
    ids_.assign(reader_.point_ids().begin(), reader_.point_ids().end());
    if (config_.shells == ShellModel::solid) thicken(data);
    if (config_.contacts && reader_.frame_count() > 1) read_contacts(data);
    set_caption(data);
    return data;
  }

 private:
  void thicken(PanelData& data) {
    if (!reader_.has_thickness())
      throw InputError(panel_.file, "CellData/Thickness", "is not there: shells stay surfaces");
    std::vector<double> thickness;
    reader_.read_thickness(panel_.frame, thickness);
    const Mesh mesh = mesh_of(ids_, data.all);
    const ShellThickener thickener(mesh);
    std::vector<Vec3> solid;
    thickener.positions(data.points, thickness, solid);
    data.points = std::move(solid);
    data.all = cells_of(thickener.solid_mesh(mesh));
    ids_ = solid_vertex_ids(ids_);
  }

  /// A step has the cells of its end, which may differ from those in the picture.
  SequenceCells cells_of_step(int step) {
    SequenceCells cells;
    reader_.read_cells(step + 1, cells);
    if (config_.shells == ShellModel::surface) return cells;
    const Mesh mesh = mesh_of(reader_.point_ids(), cells);
    return cells_of(ShellThickener(mesh).solid_mesh(mesh));
  }

  void read_contacts(PanelData& data) {
    const int step = std::min(panel_.frame, reader_.frame_count() - 2);
    data.contacts = panel_.contacts.empty() ? find_contacts(reader_, step, config_.shells, config_.threads)
                                            : contacts_from_csv(panel_.contacts, step, ids_);
    classify(data.contacts, cells_of_step(step), static_cast<Index>(data.points.size()));
    for (const PictureContact& contact : data.contacts) ++(contact.inter ? data.inter : data.intra);
  }

  void set_caption(PanelData& data) const {
    const SequenceMetadata& metadata = reader_.metadata();
    data.caption = !panel_.caption.empty()   ? panel_.caption
                   : !metadata.title.empty() ? metadata.title
                                             : std::filesystem::path(panel_.file).stem().string();
    if (reader_.frame_count() == 1) return;
    data.subtitle = fmt::format("frame {} of {}, t = {:.4g} {}", panel_.frame, reader_.frame_count() - 1,
                                reader_.time(panel_.frame), metadata.time_unit);
    if (config_.contacts)
      data.subtitle += fmt::format("; contacts: {} between objects, {} within", data.inter, data.intra);
  }

  const PicturePanel& panel_;
  const PictureConfig& config_;
  SequenceReader reader_;
  std::vector<std::int64_t> ids_;
};

}  // namespace

PanelData read_panel(const PicturePanel& panel, const PictureConfig& config) {
  return PanelReader(panel, config).read();
}

}  // namespace volccd::detail
