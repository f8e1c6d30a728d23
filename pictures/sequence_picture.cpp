#include <volccd/pictures/sequence_picture.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <map>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include <volccd/core/error.hpp>
#include <volccd/pictures/contact_marks.hpp>
#include <volccd/pictures/detail/legend.hpp>
#include <volccd/pictures/detail/object_names.hpp>
#include <volccd/pictures/detail/panel_data.hpp>
#include <volccd/pictures/palette.hpp>
#include <volccd/pictures/surface.hpp>
#include <volccd/pictures/text.hpp>

namespace volccd {

namespace {

class Composer {
 public:
  Composer(std::span<const PicturePanel> panels, const PictureConfig& config) : config_(config) {
    if (panels.empty()) throw ConfigError("a picture needs a file");
    for (const PicturePanel& panel : panels) {
      report_progress(0.5 * static_cast<double>(panels_.size()));
      panels_.push_back(detail::read_panel(panel, config));
      names_.add(panels_.back().objects, panels_.back().object_names);
    }
    for (const std::int32_t object : names_.objects()) {
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
      report_progress(0.5 * static_cast<double>(panels_.size() + i));
      const int x = static_cast<int>(i) % columns * (panel_width_ + gap_);
      const int y = static_cast<int>(i) / columns * (view_height_ + caption_height_);
      image.paste(draw_panel(panels_[i], camera), x, y);
      if (config_.text) draw_caption(image, panels_[i], x, y + view_height_);
    }
    legend_.draw(image, height_ - legend_.height());
    return image;
  }

 private:
  /// Reading a panel with its contacts counts as much as drawing it.
  void report_progress(double panels) const {
    if (config_.progress) config_.progress(panels);
  }

  void select_objects() {
    const std::set<std::int32_t> only = names_.parse("--objects", config_.objects),
                                 without = names_.parse("--without", config_.without);
    for (detail::PanelData& panel : panels_) {
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
    for (const detail::PanelData& panel : panels_)
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
    for (const detail::PanelData& panel : panels_)
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
      throw ConfigError(fmt::format("--colour: '{}' is not OBJECT=#RRGGBB", text));
    for (const std::int32_t object : names_.parse("--colour", text.substr(0, at)))
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
    if (config_.text) legend_ = legend();
    const int legend_height = legend_.height();
    if (config_.height > 0) {
      // In a picture of small height, captions have fewer lines, so that there is room for the scene.
      height_ = config_.height;
      const int panel_height = (height_ - legend_height) / rows;
      max_caption_lines_ = caption_line_count();
      while (caption_height_ > panel_height / 2 && max_caption_lines_ > 1) {
        --max_caption_lines_;
        caption_height_ = caption_height();
      }
      view_height_ = panel_height - caption_height_;
    } else {
      const double aspect = std::clamp(aspect_of(fit_, config_.view), 0.3, 1.0);
      view_height_ = static_cast<int>(std::lround(panel_width_ * (0.94 * aspect + 0.06)));
      height_ = rows * (view_height_ + caption_height_) + legend_height;
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

  Image draw_panel(const detail::PanelData& panel, const Camera& camera) const {
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

  std::vector<Mark> marks(const detail::PanelData& panel) const {
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

  void draw_caption(Image& image, const detail::PanelData& panel, int x, int y) const {
    const double h = text_height_;
    double base = y - 0.1 * h;
    for (const auto& [line, height] : caption_lines(panel)) {
      base += 1.8 * h;
      draw_text(image, line, x + (panel_width_ - text_width(line, height)) / 2, base, height, kTextColour);
    }
  }

  /// Caption and subtitle, divided into lines that fit the panel, with their heights.
  std::vector<std::pair<std::string, double>> caption_lines(const detail::PanelData& panel) const {
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
    for (const detail::PanelData& panel : panels_) lines = std::max(lines, caption_lines(panel).size());
    return lines;
  }

  int caption_height() const {
    return static_cast<int>(std::lround(text_height_ * (0.9 + 1.8 * static_cast<double>(caption_line_count()))));
  }

  /// Marks come first, so that they remain if objects are left out.
  detail::Legend legend() const {
    std::size_t inter = 0, intra = 0;
    for (const detail::PanelData& panel : panels_) inter += panel.inter, intra += panel.intra;
    std::vector<detail::LegendEntry> entries;
    if (inter > 0) entries.push_back({"contact between objects", kInterColour, MarkShape::disc});
    if (intra > 0) entries.push_back({"contact within an object", kIntraColour, MarkShape::diamond});
    if (shown_.size() > 1)
      for (const std::int32_t object : shown_)
        entries.push_back({names_.name_of(object), colours_[colour_of_.at(object)]});
    return {std::move(entries), config_.width, text_height_};
  }

  const PictureConfig& config_;
  std::vector<detail::PanelData> panels_;
  detail::ObjectNames names_;     ///< of the objects of all files
  std::set<std::int32_t> shown_;  ///< objects that are drawn
  std::map<std::int32_t, std::uint16_t> colour_of_;
  std::vector<Colour> colours_;
  Eigen::AlignedBox3d box_;  ///< all vertices in use
  std::vector<CuttingPlane> planes_;
  std::vector<Vec3> fit_;
  int gap_ = 0, panel_width_ = 0, view_height_ = 0, caption_height_ = 0, height_ = 0;
  detail::Legend legend_;
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
