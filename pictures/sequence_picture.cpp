#include <volccd/pictures/sequence_picture.hpp>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <map>
#include <set>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include <volccd/core/error.hpp>
#include <volccd/core/suggest.hpp>
#include <volccd/io/sequence/reader.hpp>
#include <volccd/mesh/shells.hpp>
#include <volccd/pictures/contact_marks.hpp>
#include <volccd/pictures/palette.hpp>
#include <volccd/pictures/surface.hpp>
#include <volccd/pictures/text.hpp>

namespace volccd {

namespace {

constexpr Colour kTextColour{30, 32, 38};

/// The data of a panel: the cells and points of its frame, and its contacts.
struct PanelData {
  std::string caption, subtitle;
  SequenceCells all, drawn;
  std::vector<Vec3> points;
  std::vector<PictureContact> contacts;
  std::size_t inter = 0, intra = 0;
  std::map<std::int32_t, std::string> part_names;
  std::set<std::int32_t> objects;  ///< of this frame and of the first one
};

std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

/// Parts of a text between semicolons or, if there is none, between commas, without blanks around them.
std::vector<std::string> split(const std::string& text) {
  const char separator = text.find(';') == std::string::npos ? ',' : ';';
  std::vector<std::string> words;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find(separator, at), text.size());
    const std::size_t first = text.find_first_not_of(' ', at);
    if (first < end) words.push_back(text.substr(first, text.find_last_not_of(' ', end - 1) + 1 - first));
    at = end + 1;
  }
  return words;
}

/// Reads a panel.
class PanelReader {
 public:
  PanelReader(const PicturePanel& panel, const PictureConfig& config)
      : panel_(panel), config_(config), reader_(panel.file) {
    if (panel.frame < 0 || panel.frame >= reader_.frame_count())
      throw ConfigError(fmt::format("--step: {} is not within the frames 0:{} of {}", panel.frame,
                                    reader_.frame_count(), panel.file));
  }

  PanelData read() {
    PanelData data;
    data.part_names = reader_.metadata().part_names;
    reader_.read_cells(0, data.all);
    data.objects.insert(data.all.objects.begin(), data.all.objects.end());
    if (!reader_.same_cells(0, panel_.frame)) reader_.read_cells(panel_.frame, data.all);
    data.objects.insert(data.all.objects.begin(), data.all.objects.end());
    reader_.read_points(panel_.frame, data.points);
    ids_.assign(reader_.point_ids().begin(), reader_.point_ids().end());
    if (config_.shells == ShellModel::solid) thicken(data);
    if (config_.contacts && reader_.frame_count() > 1) read_contacts(data);
    title(data);
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

  void title(PanelData& data) const {
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

class Composer {
 public:
  Composer(std::span<const PicturePanel> panels, const PictureConfig& config) : config_(config) {
    if (panels.empty()) throw ConfigError("a picture needs a file");
    for (const PicturePanel& panel : panels) {
      tell(0.5 * static_cast<double>(panels_.size()));
      panels_.push_back(PanelReader(panel, config).read());
    }
    for (const PanelData& panel : panels_) {
      objects_.insert(panel.objects.begin(), panel.objects.end());
      names_.insert(panel.part_names.begin(), panel.part_names.end());
    }
    for (const auto& [object, name] : names_) objects_.insert(object);
    for (const std::int32_t object : objects_) {
      colour_of_[object] = static_cast<std::uint16_t>(colours_.size());
      colours_.push_back(object_colour(colours_.size()));
    }
    for (const std::string& text : config.colours) set_colour(text);
    select_objects();
    select_view();
  }

  Image draw() {
    lay_out();
    Image image(config_.width, height_);
    const Camera camera = Camera::fit(fit_, config_.view, panel_width_, view_height_);
    const int columns = this->columns();
    for (std::size_t i = 0; i < panels_.size(); ++i) {
      tell(0.5 * static_cast<double>(panels_.size() + i));
      const int x = static_cast<int>(i) % columns * (panel_width_ + gap_);
      const int y = static_cast<int>(i) / columns * (view_height_ + caption_height_);
      image.paste(draw_panel(panels_[i], camera), x, y);
      if (config_.text) draw_caption(image, panels_[i], x, y + view_height_);
    }
    if (legend_height_ > 0) draw_legend(image, height_ - legend_height_);
    return image;
  }

 private:
  /// Reading a panel with its contacts counts as much as drawing it.
  void tell(double panels) const {
    if (config_.progress) config_.progress(panels);
  }

  std::string name_of(std::int32_t object) const {
    const auto found = names_.find(object);
    return found == names_.end() || found->second.empty() ? fmt::format("object {}", object) : found->second;
  }

  std::set<std::int32_t> parse_objects(const std::string& option, const std::string& text) const {
    std::set<std::int32_t> chosen;
    const bool is_name = std::any_of(names_.begin(), names_.end(),
                                     [&](const auto& entry) { return lower(entry.second) == lower(text); });
    for (const std::string& word : is_name ? std::vector{text} : split(text)) {
      std::int32_t id = 0;
      const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), id);
      const bool is_id = error == std::errc() && end == word.data() + word.size();
      const std::size_t before = chosen.size();
      for (const std::int32_t object : objects_)
        if (is_id ? object == id : lower(name_of(object)) == lower(word)) chosen.insert(object);
      if (chosen.size() == before && !(is_id && chosen.contains(id)))
        throw ConfigError(fmt::format("{}: there is no object '{}'; there are {}{}", option, word, known_objects(),
                                      did_you_mean(word, object_names())));
    }
    return chosen;
  }

  std::vector<std::string> object_names() const {
    std::vector<std::string> names;
    for (const std::int32_t object : objects_) names.push_back(name_of(object));
    return names;
  }

  std::string known_objects() const {
    std::string known;
    for (const std::int32_t object : objects_) {
      const auto found = names_.find(object);
      known +=
          fmt::format("{}{}{}", known.empty() ? "" : ", ", object, found == names_.end() ? "" : " " + found->second);
    }
    return known;
  }

  void select_objects() {
    const std::set<std::int32_t> only = parse_objects("--parts", config_.parts),
                                 without = parse_objects("--without", config_.without);
    for (PanelData& panel : panels_) {
      if (only.empty() && without.empty()) {
        panel.drawn = panel.all;
      } else {
        for (std::size_t cell = 0; cell < panel.all.size(); ++cell) {
          const std::int32_t object = panel.all.objects[cell];
          if ((only.empty() || only.contains(object)) && !without.contains(object))
            panel.drawn.add(panel.all.spec(cell));
        }
      }
      shown_.insert(panel.drawn.objects.begin(), panel.drawn.objects.end());
    }
  }

  void select_view() {
    for (const PanelData& panel : panels_)
      for (const Index v : panel.drawn.connectivity) box_.extend(panel.points[v]);
    if (box_.isEmpty()) throw ConfigError("nothing is left to draw");
    planes_ = cutting_planes();
    if (config_.box) {
      const std::array<double, 6>& b = *config_.box;
      for (int corner = 0; corner < 8; ++corner)
        fit_.emplace_back(b[corner & 1], b[2 + (corner >> 1 & 1)], b[4 + (corner >> 2 & 1)]);
      return;
    }
    const double min_share = config_.fit_fragments ? 0 : 0.05;
    for (const PanelData& panel : panels_)
      for (const Index v : vertices_of_bodies(panel.drawn, panel.points.size(), min_share))
        if (!taken_away(panel.points[v])) fit_.push_back(panel.points[v]);
    if (fit_.empty()) throw ConfigError("nothing is left to draw: the cuts take everything away");
  }

  /// Parses "object=#rrggbb".
  void set_colour(const std::string& text) {
    const std::size_t at = text.rfind("=#");
    std::uint32_t value = 0;
    const char* const end = text.data() + text.size();
    if (at == std::string::npos || text.size() != at + 8 ||
        std::from_chars(text.data() + at + 2, end, value, 16).ptr != end)
      throw ConfigError(fmt::format("--colour: '{}' is not PART=#RRGGBB", text));
    for (const std::int32_t object : parse_objects("--colour", text.substr(0, at)))
      colours_[colour_of_[object]] = {static_cast<std::uint8_t>(value >> 16), static_cast<std::uint8_t>(value >> 8),
                                      static_cast<std::uint8_t>(value)};
  }

  int columns() const {
    const int n = static_cast<int>(panels_.size());
    return config_.columns > 0 ? std::min(config_.columns, n) : n;
  }

  /// Sizes of the parts of the picture.
  void lay_out() {
    const int columns = this->columns(), rows = (static_cast<int>(panels_.size()) + columns - 1) / columns;
    gap_ = columns > 1 ? std::max(4, config_.width / 200) : 0;
    panel_width_ = (config_.width - (columns - 1) * gap_) / columns;
    text_height_ = std::clamp(std::min(panel_width_ / 62.0, config_.width / 90.0), 7.0, 40.0);
    caption_height_ = config_.text ? caption_height() : 0;
    legend_height_ = config_.text ? legend_height() : 0;
    if (config_.height > 0) {
      // In a picture of small height, captions have fewer lines, so that there is room for the scene.
      height_ = config_.height;
      const int panel_height = (height_ - legend_height_) / rows;
      max_caption_lines_ = caption_line_count();
      while (caption_height_ > panel_height / 2 && max_caption_lines_ > 1) {
        --max_caption_lines_;
        caption_height_ = caption_height();
      }
      view_height_ = panel_height - caption_height_;
    } else {
      const double aspect = std::clamp(aspect_of(fit_, config_.view), 0.3, 1.0);
      view_height_ = static_cast<int>(std::lround(panel_width_ * (0.94 * aspect + 0.06)));
      height_ = rows * (view_height_ + caption_height_) + legend_height_;
    }
    if (panel_width_ < 8 || view_height_ < 8)
      throw ConfigError(fmt::format("--size: {} x {} leaves no room for {} panel(s) and their captions", config_.width,
                                    config_.height, panels_.size()));
  }

  bool taken_away(const Vec3& place) const {
    return std::any_of(planes_.begin(), planes_.end(),
                       [&](const CuttingPlane& plane) { return plane.normal.dot(place) > plane.offset; });
  }

  std::vector<CuttingPlane> cutting_planes() const {
    std::vector<CuttingPlane> planes;
    for (const std::string& text : config_.cuts) {
      double value = 0;
      const bool percent = text.ends_with('%');
      const char *begin = text.data() + std::min<std::size_t>(2, text.size()),
                 *end = text.data() + text.size() - percent;
      const int axis = text.empty() ? -1 : text[0] - 'x';
      const auto [stop, error] = std::from_chars(begin, std::max(begin, end), value);
      if (text.size() < 3 || axis < 0 || axis > 2 || text[1] != '=' || error != std::errc() || stop != end ||
          !std::isfinite(value))
        throw ConfigError(fmt::format("--cut: '{}' is not x=VALUE, y=VALUE or z=VALUE (or x=50%)", text));
      if (percent) value = box_.min()[axis] + value / 100 * box_.sizes()[axis];
      const double sign = towards_viewer(config_.view)[axis] < -1e-9 ? -1 : 1;
      planes.push_back({sign * Vec3::Unit(axis), sign * value});
    }
    return planes;
  }

  Image draw_panel(const PanelData& panel, const Camera& camera) const {
    std::vector<std::uint16_t> colours;
    for (const std::int32_t object : panel.drawn.objects) colours.push_back(colour_of_.at(object));
    Surface surface = surface_of(panel.drawn, panel.points, colours, config_.crease);
    cut(surface, panel.drawn, panel.points, colours, planes_);
    RenderOptions options = config_.render;
    const std::vector<Mark> marks = this->marks(panel);
    const double crowd = std::clamp(std::sqrt(400.0 / (1.0 + static_cast<double>(marks.size()))), 0.4, 1.0);
    options.mark_radius = config_.mark_radius > 0 ? config_.mark_radius : std::max(1.4, mark_size() * crowd);
    return render(surface, colours_, marks, camera, panel_width_, view_height_, options);
  }

  double mark_size() const { return std::min(panel_width_, 2 * view_height_) / 260.0; }

  std::vector<Mark> marks(const PanelData& panel) const {
    // Vertices of the objects left out. Vertices that come with the cells of the end of the step belong to none.
    std::vector<char> left_out(panel.points.size());
    for (const Index v : panel.all.connectivity) left_out[v] = 1;
    for (const Index v : panel.drawn.connectivity) left_out[v] = 0;
    std::vector<Mark> marks;
    for (const PictureContact& contact : panel.contacts) {
      const Vec3 place = mark_place(contact, panel.points);
      const bool shown =
          std::none_of(contact.vertices.begin(), contact.vertices.end(), [&](Index v) { return left_out[v] != 0; }) &&
          !taken_away(place);
      if (shown)
        marks.push_back(
            {place, contact.inter ? kInterColour : kIntraColour, contact.inter ? MarkShape::disc : MarkShape::diamond});
    }
    return marks;
  }

  void draw_caption(Image& image, const PanelData& panel, int x, int y) const {
    const double h = text_height_;
    double base = y - 0.1 * h;
    for (const auto& [line, height] : caption_lines(panel)) {
      base += 1.8 * h;
      draw_text(image, line, x + (panel_width_ - text_width(line, height)) / 2, base, height, kTextColour);
    }
  }

  /// Caption and subtitle, divided into lines that fit the panel, with their heights.
  std::vector<std::pair<std::string, double>> caption_lines(const PanelData& panel) const {
    const double h = text_height_, room = panel_width_ - h;
    std::vector<std::pair<std::string, double>> lines;
    for (const auto& [text, height] : {std::pair(&panel.caption, h), std::pair(&panel.subtitle, 0.86 * h)})
      if (!text->empty())
        for (std::string& line : wrap_text(*text, height, room)) lines.emplace_back(std::move(line), height);
    if (lines.size() > max_caption_lines_) {
      lines.resize(max_caption_lines_);
      lines.back().first += " ...";
    }
    return lines;
  }

  std::size_t caption_line_count() const {
    std::size_t lines = 0;
    for (const PanelData& panel : panels_) lines = std::max(lines, caption_lines(panel).size());
    return lines;
  }

  int caption_height() const {
    return static_cast<int>(std::lround(text_height_ * (0.9 + 1.8 * static_cast<double>(caption_line_count()))));
  }

  /// An entry of the legend: a swatch, or a mark.
  struct Entry {
    std::string text;
    std::optional<Colour> colour;
    std::optional<MarkShape> mark;
    double x = 0;
    int row = 0;
  };

  /// Entries in rows from left to right. At most kLegendRows rows are drawn, and the remaining entries are counted.
  std::vector<Entry> legend() const {
    std::vector<Entry> entries;
    if (shown_.size() > 1)
      for (const std::int32_t object : shown_)
        entries.push_back({name_of(object), colours_[colour_of_.at(object)], {}});
    std::size_t inter = 0, intra = 0;
    for (const PanelData& panel : panels_) inter += panel.inter, intra += panel.intra;
    std::vector<Entry> marks;
    if (inter > 0) marks.push_back({"contact between objects", kInterColour, MarkShape::disc});
    if (intra > 0) marks.push_back({"contact within an object", kIntraColour, MarkShape::diamond});
    // Marks come first, so that they remain if objects are left out.
    entries.insert(entries.begin(), marks.begin(), marks.end());
    place_entries(entries);
    std::size_t hidden = 0;
    while (!entries.empty() && entries.back().row >= kLegendRows) {
      entries.pop_back();
      ++hidden;
    }
    if (hidden > 0) {
      entries.back() = {fmt::format("and {} more", hidden + 1), {}, {}, entries.back().x, entries.back().row};
    }
    return entries;
  }

  /// The entries of a row run from left to right, and the row is centred.
  void place_entries(std::vector<Entry>& entries) const {
    const double h = text_height_, gap = 1.6 * h;
    for (std::size_t begin = 0, row = 0; begin < entries.size(); ++row) {
      double width = -gap;
      std::size_t end = begin;
      for (; end < entries.size(); ++end) {
        const double more = gap + 1.9 * h + text_width(entries[end].text, 0.86 * h);
        if (end > begin && width + more > config_.width - 2 * h) break;
        width += more;
      }
      double x = std::max(h, (config_.width - width) / 2);
      for (; begin < end; ++begin) {
        entries[begin].x = x;
        entries[begin].row = static_cast<int>(row);
        x += gap + 1.9 * h + text_width(entries[begin].text, 0.86 * h);
      }
    }
  }

  int legend_height() const {
    const std::vector<Entry> entries = legend();
    return entries.empty() ? 0 : static_cast<int>(std::lround(text_height_ * (1.0 + 2.1 * (entries.back().row + 1))));
  }

  void draw_legend(Image& image, int top) const {
    const double h = text_height_;
    for (const Entry& entry : legend()) {
      const double base = top + h * (1.5 + 2.1 * entry.row);
      if (entry.mark) {
        draw_mark(image, entry.x + 0.6 * h, base - 0.45 * h, 0.42 * h, *entry.mark, *entry.colour);
      } else if (entry.colour) {
        const int side = static_cast<int>(std::lround(1.2 * h)), x = static_cast<int>(entry.x),
                  y = static_cast<int>(base - 1.05 * h);
        image.fill_rectangle(x, y, side, side, mix(*entry.colour, kTextColour, 0.55));
        image.fill_rectangle(x + 1, y + 1, side - 2, side - 2, *entry.colour);
      }
      draw_text(image, entry.text, entry.x + (entry.colour ? 1.9 * h : 0), base, 0.86 * h, kTextColour);
    }
  }

  static constexpr int kLegendRows = 4;

  const PictureConfig& config_;
  std::vector<PanelData> panels_;
  std::set<std::int32_t> objects_, shown_;  ///< objects of all files; objects that are drawn
  std::map<std::int32_t, std::string> names_;
  std::map<std::int32_t, std::uint16_t> colour_of_;
  std::vector<Colour> colours_;
  Eigen::AlignedBox3d box_;  ///< all vertices in use
  std::vector<CuttingPlane> planes_;
  std::vector<Vec3> fit_;
  int gap_ = 0, panel_width_ = 0, view_height_ = 0, caption_height_ = 0, legend_height_ = 0, height_ = 0;
  double text_height_ = 0;
  std::size_t max_caption_lines_ = SIZE_MAX;  ///< of a panel
};

void check(const PictureConfig& config) {
  if (config.width < 16 || config.width > Image::kMaxSide || config.height < 0 || config.height > Image::kMaxSide ||
      (config.height > 0 && config.height < 16) ||
      std::int64_t{config.width} * std::max(config.height, 1) > Image::kMaxPixels)
    throw ConfigError(fmt::format("--size: {} x {} is out of range: sides are 16 to {}, and at most {} pixels in all",
                                  config.width, config.height, Image::kMaxSide, Image::kMaxPixels));
  if (!(config.view.zoom > 0 && std::isfinite(config.view.zoom))) throw ConfigError("--zoom: a factor above 0");
  if (config.view.up < 'x' || config.view.up > 'z') throw ConfigError("--up: x, y or z");
  if (config.box)
    for (int axis = 0; axis < 3; ++axis)
      if (!((*config.box)[2 * axis] <= (*config.box)[2 * axis + 1] && std::isfinite((*config.box)[2 * axis]) &&
            std::isfinite((*config.box)[2 * axis + 1])))
        throw ConfigError("--box: two finite numbers an axis, the smaller one first");
}

}  // namespace

Image draw_sequences(std::span<const PicturePanel> panels, const PictureConfig& config) {
  check(config);
  return Composer(panels, config).draw();
}

}  // namespace volccd
