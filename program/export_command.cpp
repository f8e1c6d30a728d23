#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include <volccd/io/sequence/reader.hpp>
#include <volccd/io/sequence/writer.hpp>
#include <volccd/program/commands.hpp>
#include <volccd/program/output_plan.hpp>
#include <volccd/program/query_options.hpp>
#include <volccd/program/report.hpp>
#include <volccd/program/scene_files.hpp>
#include <volccd/program/step_loop.hpp>

namespace volccd {

namespace {

struct ExportOptions {
  std::string file, frames, output;
  ReportOptions report;
};

/// run.vtkhdf, 7 -> run_0007.vtkhdf: ParaView opens files with such names as one series.
std::string file_of_frame(const std::string& output, int frame) {
  const std::filesystem::path path(output);
  return (path.parent_path() / fmt::format("{}_{:04}{}", path.stem().string(), frame, path.extension().string()))
      .string();
}

void write_frame(SequenceReader& reader, int frame, const std::string& file) {
  std::vector<Vec3> points, velocity;
  std::vector<double> thickness;
  SequenceCells cells;
  reader.read_points(frame, points);
  reader.read_cells(frame, cells);
  if (reader.has_velocity()) reader.read_velocity(frame, velocity);
  if (reader.has_thickness()) reader.read_thickness(frame, thickness);
  SequenceWriter writer(file, reader.point_ids(), reader.metadata(), SequenceForm::single);
  writer.write_frame(reader.time(frame), points, cells, {velocity, thickness});
  writer.finish();
}

int export_frames(const ExportOptions& options) {
  const InterruptGuard guard;
  const Report report(options.report);
  SequenceReader reader(options.file);
  warn_of_incomplete(reader);
  const StepRange range = parse_steps(options.frames, reader.frame_count(), options.file, "frame");
  OutputPlan plan;
  plan.input("FILE", options.file);
  for (int k = range.begin; k < range.end; ++k)
    plan.output("-o", file_of_frame(options.output, k), kSequenceIsNoStream);
  plan.check();
  StepsDone frames =
      run_steps("exporting", range, [&](int k) { write_frame(reader, k, file_of_frame(options.output, k)); });
  frames.unit = "frame";
  report.print("{} written to {} .. {}\n", counted(static_cast<std::uint64_t>(frames.done - frames.begin), "frame"),
               file_of_frame(options.output, frames.begin), file_of_frame(options.output, frames.done - 1));
  print_incomplete(frames, report.people());
  return exit_code(frames);
}

}  // namespace

void add_export_command(CLI::App& scene, Action& action) {
  CLI::App* command =
      scene.add_subcommand("export", "a file for each frame, for VTK before 9.3 and ParaView before 5.12");
  const auto options = std::make_shared<ExportOptions>();
  command->add_option("FILE", options->file, "sequence (VTKHDF), or the name of a scene")->required()->type_name("");
  command->add_option("--frames", options->frames, "frames k with A <= k < B; or one frame K")->type_name("A:B");
  command
      ->add_option(
          "-o,--output", options->output,
          "name of the files, to which the number of the frame is added: run.vtkhdf gives run_0000.vtkhdf, ...")
      ->required()
      ->type_name("FILE");
  options->report.add_quiet_to(*command);
  command->footer(
      "Writes VTKHDF 1.0, which the VTK of Debian 12 (9.1) opens; ParaView takes the files as one series. A sequence "
      "itself is one temporal file, which VTK opens from 9.3 on.\n"
      "Example:\n"
      "  volccd scene export run.vtkhdf --frames 0:10 -o run-frames.vtkhdf");
  command->callback([options, &action] {
    action = [options] {
      options->file = sequence_file(options->file);
      return export_frames(*options);
    };
  });
}

}  // namespace volccd
