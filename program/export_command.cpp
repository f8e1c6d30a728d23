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
  std::string file, steps, output;
  ReportOptions report;
};

/// run.vtkhdf, 7 -> run_0007.vtkhdf: ParaView opens files with such names as one series.
std::string file_of_step(const std::string& output, int step) {
  const std::filesystem::path path(output);
  return (path.parent_path() / fmt::format("{}_{:04}{}", path.stem().string(), step, path.extension().string()))
      .string();
}

void write_step(SequenceReader& reader, int step, const std::string& file) {
  std::vector<Vec3> points, velocity;
  std::vector<double> thickness;
  SequenceCells cells;
  reader.read_points(step, points);
  reader.read_cells(step, cells);
  if (reader.has_velocity()) reader.read_velocity(step, velocity);
  if (reader.has_thickness()) reader.read_thickness(step, thickness);
  SequenceWriter writer(file, reader.point_ids(), reader.metadata(), SequenceForm::single);
  writer.write_step(reader.time(step), points, cells, {velocity, thickness});
  writer.finish();
}

int export_steps(const ExportOptions& options) {
  const InterruptGuard guard;
  const Report report(options.report);
  SequenceReader reader(options.file);
  warn_of_incomplete(reader);
  const StepRange range = parse_steps(options.steps, reader.step_count(), options.file);
  OutputPlan plan;
  plan.input("FILE", options.file);
  for (int k = range.begin; k < range.end; ++k) plan.output("-o", file_of_step(options.output, k), kSequenceIsNoStream);
  plan.check();
  const StepsDone steps =
      run_steps("exporting", range, [&](int k) { write_step(reader, k, file_of_step(options.output, k)); });
  report.print("{} step(s) written to {} .. {}\n", steps.done - steps.begin, file_of_step(options.output, steps.begin),
               file_of_step(options.output, steps.done - 1));
  print_incomplete(steps, report.people());
  return exit_code(steps);
}

}  // namespace

void add_export_command(CLI::App& scene, Action& action) {
  CLI::App* command =
      scene.add_subcommand("export", "a file for each step, for VTK before 9.3 and ParaView before 5.12");
  const auto options = std::make_shared<ExportOptions>();
  command->add_option("FILE", options->file, "sequence (VTKHDF), or the name of a scene")->required()->type_name("");
  command->add_option("--steps", options->steps, "steps k with A <= k < B; or one step K")->type_name("A:B");
  command
      ->add_option("-o,--output", options->output,
                   "name of the files, to which the number of the step is added: run.vtkhdf gives run_0000.vtkhdf, ...")
      ->required()
      ->type_name("FILE");
  options->report.add_quiet_to(*command);
  command->footer(
      "Writes VTKHDF 1.0, which the VTK of Debian 12 (9.1) opens; ParaView takes the files as one series. A sequence "
      "itself is one temporal file, which VTK opens from 9.3 on.\n"
      "Example:\n"
      "  volccd scene export run.vtkhdf --steps 0:10 -o run-steps.vtkhdf");
  command->callback([options, &action] {
    action = [options] {
      options->file = sequence_file(options->file);
      return export_steps(*options);
    };
  });
}

}  // namespace volccd
