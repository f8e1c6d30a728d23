#include <algorithm>
#include <cctype>
#include <charconv>
#include <filesystem>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include <volccd/pictures/sequence_picture.hpp>
#include <volccd/program/command_line.hpp>
#include <volccd/program/commands.hpp>
#include <volccd/program/output_plan.hpp>
#include <volccd/program/progress.hpp>
#include <volccd/program/query_options.hpp>
#include <volccd/program/report.hpp>
#include <volccd/program/scene_files.hpp>

namespace volccd {

namespace {

struct PictureOptions {
  std::vector<std::string> files, contact_files, captions;
  std::string frames = "0", output, size = "1600", view = "iso", up = "z", box;
  bool no_lines = false;
  PictureConfig config;
  ReportOptions report;
};

/// Numbers separated by `separator`. Throws ConfigError.
template <class Number>
std::vector<Number> parse_list(const std::string& option, const std::string& text, char separator, const char* form) {
  std::vector<Number> numbers;
  for (const char *at = text.data(), *end = at + text.size();; ++at) {
    Number number{};
    const auto [stop, error] = std::from_chars(at, end, number);
    if (error != std::errc() || (stop != end && *stop != separator))
      throw ConfigError(fmt::format("{}: '{}' is not {}", option, text, form));
    numbers.push_back(number);
    if (stop == end) return numbers;
    at = stop;
  }
}

/// The panels in their order: for each frame, one panel for each file.
std::vector<PicturePanel> panels_of(const PictureOptions& options) {
  const std::vector<int> frames =
      parse_list<int>("--frames", options.frames, ',', "a frame, or frames such as 0,10,20");
  const std::size_t count = options.files.size() * frames.size();
  const auto per_panel = [&](const char* option, const std::vector<std::string>& values) {
    if (!values.empty() && values.size() != count)
      throw ConfigError(fmt::format("{}: given {} time(s) for {} panel(s)", option, values.size(), count));
  };
  per_panel("--caption", options.captions);
  if (!options.contact_files.empty() && options.contact_files.size() != options.files.size())
    throw ConfigError(fmt::format("--contacts-from: given {} time(s) for {} file(s)", options.contact_files.size(),
                                  options.files.size()));
  std::vector<PicturePanel> panels;
  for (const int frame : frames)
    for (std::size_t i = 0; i < options.files.size(); ++i) {
      PicturePanel panel{options.files[i], frame, "", ""};
      if (!options.contact_files.empty()) panel.contacts = options.contact_files[i];
      if (!options.captions.empty()) panel.caption = options.captions[panels.size()];
      panels.push_back(std::move(panel));
    }
  return panels;
}

/// The suffix of the file must be that of the format.
void check_suffix(const std::string& output) {
  std::string suffix = std::filesystem::path(output).extension().string();
  std::transform(suffix.begin(), suffix.end(), suffix.begin(), [](unsigned char c) { return std::tolower(c); });
  if (!suffix.empty() && suffix != ".png")
    throw ConfigError(fmt::format("-o: pictures are PNG files; name it {} instead of {}",
                                  std::filesystem::path(output).replace_extension(".png").string(), output));
}

int draw_picture(const PictureOptions& options) {
  PictureConfig config = options.config;
  const std::vector<int> size = parse_list<int>("--size", options.size, 'x', "WIDTH or WIDTHxHEIGHT");
  if (size.size() > 2 || size[0] < 1 || size.back() < 1)
    throw ConfigError(fmt::format("--size: '{}' is not WIDTH or WIDTHxHEIGHT", options.size));
  config.width = size[0];
  config.height = size.size() == 2 ? size[1] : 0;
  parse_view(options.view, config.view);
  config.view.up = options.up[0];
  config.render.lines = !options.no_lines;
  if (!options.box.empty()) {
    const std::vector<double> box = parse_list<double>("--box", options.box, ',', "X0,X1,Y0,Y1,Z0,Z1");
    if (box.size() != 6) throw ConfigError(fmt::format("--box: '{}' is not X0,X1,Y0,Y1,Z0,Z1", options.box));
    config.box.emplace();
    std::copy(box.begin(), box.end(), config.box->begin());
  }
  const std::vector<PicturePanel> panels = panels_of(options);
  if (config.columns == 0 && options.files.size() > 1) config.columns = static_cast<int>(options.files.size());
  OutputPlan plan;
  for (const std::string& file : options.files) plan.input("FILE", file);
  for (const std::string& file : options.contact_files) plan.input("--contacts-from", file);
  plan.output("-o", options.output);
  plan.check();
  check_suffix(options.output);
  const InterruptGuard guard;
  std::optional<Progress> progress(std::in_place, "drawing", panels.size(), "panels");
  config.progress = [&](double done) {
    InterruptGuard::check();
    const auto whole = static_cast<std::size_t>(done);
    progress->advance(whole, done - static_cast<double>(whole));
  };
  const Image image = draw_sequences(panels, config);
  progress.reset();
  write_png(image, options.output);
  Report(options.report, plan.report())
      .print("{} x {} pixels written to {}\n", image.width(), image.height(), options.output);
  return kDone;
}

void add_picture_view(CLI::App& command, PictureOptions& options) {
  PictureConfig& config = options.config;
  command
      .add_option("--size", options.size, "WIDTHxHEIGHT in pixels; with WIDTH alone, the scene determines the height")
      ->type_name("SIZE")
      ->capture_default_str();
  command
      .add_option("--view", options.view,
                  "front, back, left, right, side, top, bottom, iso, or AZIMUTH,ELEVATION in degrees")
      ->type_name("VIEW")
      ->capture_default_str();
  command.add_option("--up", options.up, "axis that points upwards")
      ->check(one_of({"x", "y", "z"}))
      ->capture_default_str();
  command.add_flag("--orthographic", config.view.orthographic, "without perspective");
  command.add_option("--zoom", config.view.zoom, "enlarge about the middle")
      ->type_name("FACTOR")
      ->capture_default_str();
  command.add_flag("--fit-fragments", config.fit_fragments, "fit the camera to fragments as well as to bodies");
  command.add_option("--box", options.box, "the box that the camera shows in all frames, instead of the bodies")
      ->type_name("X0,X1,Y0,Y1,Z0,Z1");
  command
      .add_option("--columns", config.columns,
                  "number of panels in a row; 0: one for each file, or all frames of one file")
      ->check(at_least(0))
      ->type_name("N")
      ->capture_default_str();
}

void add_picture_content(CLI::App& command, PictureOptions& options) {
  PictureConfig& config = options.config;
  command.add_option("--objects", config.objects, "draw only these objects: ids or names, separated by , or ;")
      ->type_name("LIST");
  command.add_option("--without", config.without, "leave these objects out")->type_name("LIST");
  command.add_option("--colour", config.colours, "colour of an object: bullet=#C87533; may be repeated")
      ->type_name("OBJECT=#RRGGBB")
      ->allow_extra_args(false);
  command
      .add_option("--cut", config.cuts,
                  "remove the viewer's side of a plane: y=1.5, or y=50% (the middle); may be repeated")
      ->type_name("AXIS=VALUE")
      ->allow_extra_args(false);
  add_choice(command, "--shells", config.shells, "triangles and quads as surfaces, or thickened by their thickness");
  command.add_flag("--contacts,!--no-contacts", config.contacts,
                   "mark the contacts of step K, from frame K to K+1 (the default)");
  command
      .add_option("--contacts-from", options.contact_files,
                  "CSV file of `volccd detect` with the contacts; one for each sequence")
      ->type_name("FILE")
      ->allow_extra_args(false);
  command.add_option("--hidden-contacts", config.render.hidden_marks, "opacity of marks behind surfaces, 0 to 1")
      ->check(CLI::Range(0.0, 1.0))
      ->type_name("S")
      ->capture_default_str();
  command.add_option("--mark-size", config.mark_radius, "radius of marks in pixels; 0: chosen by their number")
      ->check(CLI::Range(0.0, 200.0))
      ->type_name("R")
      ->capture_default_str();
  command.add_flag("--edges", config.render.edges, "draw the elements' edges as thin lines");
  command.add_flag("--no-lines", options.no_lines, "draw neither outlines nor creases");
  command.add_flag("--text,!--no-text", config.text, "captions and legend (the default)");
  command.add_option("--caption", options.captions, "caption instead of the title; one for each panel")
      ->type_name("TEXT")
      ->allow_extra_args(false);
  command.add_option("--samples", config.render.samples, "a pixel has N x N")
      ->check(CLI::Range(1, 8))
      ->capture_default_str();
  add_threads_option(command, config.threads, "for the contacts; ");
  options.report.add_quiet_to(command);
}

}  // namespace

void add_picture_command(CLI::App& scene, Action& action) {
  CLI::App* command =
      scene.add_subcommand("picture", "draw frames of sequences as PNG: shaded, objects in colours, contacts marked");
  const auto options = std::make_shared<PictureOptions>();
  command->add_option("FILE", options->files, "sequences (VTKHDF); several are drawn side by side, with one camera")
      ->required()
      ->type_name("");
  command->add_option("--frames", options->frames, "frames K or K,L,M, with one panel for each")
      ->type_name("K")
      ->capture_default_str();
  command->add_option("-o,--output", options->output, "picture to write (PNG); `-`: to the standard output")
      ->required()
      ->type_name("FILE");
  add_picture_view(*command, *options);
  add_picture_content(*command, *options);
  command->footer(
      "Marks: a disc is a contact between objects, a diamond is one within an object; pale marks are behind a "
      "surface.\n"
      "Examples:\n"
      "  volccd scene picture run.vtkhdf --frames 8 -o run-8.png\n"
      "  volccd scene picture run.vtkhdf --frames 8 --cut y=50% --edges -o inside.png\n"
      "  volccd scene picture crash.vtkhdf --frames 60 --view 120,15 --without 'wall; hood, outer' --no-contacts -o "
      "crash.png\n"
      "  volccd scene picture run.vtkhdf --frames 0,20,40,60 --columns 2 -o strip.png\n"
      "  volccd scene picture all.vtkhdf boundary.vtkhdf --frames 50 --caption 'all features' --caption 'boundary' -o "
      "two.png");
  command->callback([options, &action] {
    action = [options] {
      for (std::string& file : options->files) file = sequence_file(file);
      return draw_picture(*options);
    };
  });
}

}  // namespace volccd
